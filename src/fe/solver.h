// The ways of integrating the laws of a section over the application of a load, with derivatives.
//
//   incremental   d(sigma) = D(E(sigma)) d(strain), an ordinary differential equation in the load factor, solved by a
//                 Runge-Kutta formula in a fixed sequence of steps; every stage is one symmetric positive definite
//                 solve.
//   secant        sigma - sigma0 = D(E(sigma)) strain at the full load, solved by Newton with the consistent tangent.
//   hyperelastic  for laws whose strain derives from an energy: the minimum of the energy of the section at the full
//                 load, which is where every path of load ends.
//   over time     the incremental law in steps of time, for layers that relax.
//   inertial      the answer of mass and damping to a load in time, linear about the end of one of the first two.
//   pulse         the equation of motion in steps of time, for a load as it was recorded.
//
// The first three end in a Solution, the state under the load; the others give the Course of readings over time.
// Derivatives are those of the discrete algorithm: the tangent linear of the load path, whose steps depend on nothing
// but their number, and the implicit function theorem at the equilibria.
#pragma once

#include "base/outcome.h"
#include "fe/course.h"
#include "fe/functional.h"
#include "fe/materials.h"
#include "fe/model.h"
#include "fe/settings.h"
#include "fe/sparse_solver.h"
#include "fe/statistics.h"
#include "fe/subspace.h"

#include <functional>
#include <limits>
#include <memory>

namespace pave::fe {

// Rates of all that the positions of the nodes enter, when the mesh moves with one parameter.
template <class Element>
struct Motion {
    std::vector<typename Element::Point> points; // of weight and shape derivatives, every Gauss point
    std::vector<double> vertical_stress;         // initial, at every Gauss point as it moves [Pa]
    Eigen::VectorXd load;                        // on every free unknown [N]
    // For a pulse, what else the positions enter is differentiated through these: the mesh at values beside, whose
    // weighted sum is the derivative.
    std::vector<std::pair<double, Model<Element>>> beside;
};

template <class Element>
struct Solution {
    Eigen::VectorXd displacement;                                 // free unknowns [m]
    Eigen::Matrix<double, Element::voigt, Eigen::Dynamic> stress; // load-induced, every Gauss point [Pa]
    Eigen::VectorXd modulus;                                      // every Gauss point [Pa]
    // With variations: column k of d_displacement; column point * variations + k of d_stress.
    Eigen::MatrixXd d_displacement;
    Eigen::Matrix<double, Element::voigt, Eigen::Dynamic> d_stress;
    Statistics statistics;
    // At the load factors that were requested, in their order.
    struct OnTheWay {
        Eigen::VectorXd displacement;
        Eigen::MatrixXd d_displacement;
    };
    std::vector<OnTheWay> on_the_way;
};

// The result of a march in time: the readings at the end of every step, and the state where the load is largest.
template <class Element>
struct Marched {
    Course course;
    Solution<Element> at_largest;
    // Of a pulse [J]: what the load did, what the open sides took, what moves at the end. In an elastic section without
    // damping the rest is stored.
    double work = 0.0;
    double absorbed = 0.0;
    double kinetic = 0.0;
};

// How inertia is modelled.
struct Inertia {
    double factor = 1.0; // on mass and damping; 0: the answer of a section without
    double delay = 0.0;  // s, of damping in proportion to the stiffness: stress = E C (strain + delay d(strain)/dt)
    bool absorbs = true; // the wall absorbs; else it is smooth, as for a load at rest
    double reach = 0.0;  // m, the distance that waves are given the time to come
};

// Readings of the section linear about a state, under a load in time and under the same load at rest.
struct InertialCourse {
    Course moving;
    Course at_rest; // one instant, at a factor of 1 on the load
};

// Observes a march in time: the displacement at the end of a step, and the modulus in its middle at the Gauss points
// of the stress-dependent elements, in the order of elements.
using OnMarch = std::function<void(const Eigen::VectorXd& displacement, const Eigen::VectorXd& modulus)>;

// Solves on one model; keeps its factors and buffers between calls (same input, same bits, whatever came before).
// One object a thread. The model must outlive it.
template <class Element>
class Solver {
public:
    explicit Solver(const Model<Element>& model);
    ~Solver();

    // The same structure with other node positions; `model` shares the topology of the one before.
    void move(const Model<Element>& model);

    // load: force on every free unknown [N] at load factor 1. d(load)/d(load_factor) = load.
    // springs: stiffness of each spring of the model [Pa/m].
    // Layers that relax have their instantaneous modulus in these two.
    // motions, here and below: of a model without springs and fields. Derivatives of stress are those at the Gauss
    // points as they move. on_the_way: load factors in (0, 1] to know the displacement at: the cubic through the ends
    // of a step and their rates, of the order of the path (Hairer, Norsett and Wanner 1993, II.6).
    Outcome<Solution<Element>> incremental(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                                           const std::vector<Variation>& variations, const SolverSettings& settings,
                                           const std::vector<double>& springs = {},
                                           const std::vector<Motion<Element>>& motions = {},
                                           const std::vector<double>& on_the_way = {});
    Outcome<Solution<Element>> secant(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                                      const std::vector<Variation>& variations, const SolverSettings& settings,
                                      const std::vector<double>& springs = {},
                                      const std::vector<Motion<Element>>& motions = {});

    // Where the law of every stress-dependent layer has an energy: Newton's method on the energy of the section, which
    // is convex, with its symmetric positive definite tangent.
    Outcome<Solution<Element>> hyperelastic(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                                            const std::vector<Variation>& variations, const SolverSettings& settings,
                                            const std::vector<double>& springs = {},
                                            const std::vector<Motion<Element>>& motions = {});

    // Layers that relax: quasi-static. A step of time is one of the midpoint rule for stress-dependent layers, at rates
    // of displacement that are constant in it, for which what a relaxing layer remembers is exact; second order in the
    // step. Stress-dependent layers follow the incremental law. What is out of balance after a step is in the next one.
    Outcome<Marched<Element>> over_time(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                                        const History& history, const std::vector<Functional<Element>>& readings,
                                        const std::vector<Variation>& variations, const SolverSettings& settings,
                                        const std::vector<double>& springs = {},
                                        const std::vector<Motion<Element>>& motions = {});

    // The section in motion (axisymmetric): M a + internal forces = load, from rest. Stress-dependent layers follow the
    // incremental law through loading and unloading, layers that relax their memory, and every layer damps by its
    // damping time. Consistent mass (density = unit weight / g). The sides of the mesh that are open absorb: dashpots
    // of the impedances rho cp and rho cs (Lysmer and Kuhlemeyer 1969) at the moduli before the load, beside springs
    // that stand for the section beyond (boundary.h). The implicit midpoint rule, second order and without damping of
    // its own, with the moduli at the middle of a step as the step before predicts them: one symmetric positive
    // definite system a step, whatever its length. Derivatives are those of its steps. subspace: the motion is looked
    // for in it, of a model without springs; the course alone is of it then.
    Outcome<Marched<Element>> pulse(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                                    const Pulse& pulse, const std::vector<Functional<Element>>& readings,
                                    const std::vector<Variation>& variations, const SolverSettings& settings,
                                    const std::vector<double>& springs = {},
                                    const std::vector<Motion<Element>>& motions = {},
                                    const Subspace* subspace = nullptr);

    // Called by `incremental` at the start of a stress-dependent load path and after every step, with the load factor,
    // the rate of the displacement by it and the modulus at the Gauss points of the stress-dependent elements, in the
    // order of elements.
    using OnStep = std::function<void(double load_factor, const Eigen::VectorXd& rate, const Eigen::VectorXd& modulus)>;
    void on_step(OnStep f) { on_step_ = std::move(f); }
    // Called by `pulse` on all unknowns after every step.
    void on_march(OnMarch f) { on_march_ = std::move(f); }

    // right := K^-1 right with the last stiffness of `incremental`, that of the section as it stands under the load.
    // False: it is not definite.
    bool solve_at_end(Eigen::MatrixXd& right);

    // Readings over time at the end of the run before this call, whose layers, springs and variations must still exist
    // (no motion among them). Linear about that end, with the modulus reached there as stiffness, consistent mass
    // (density = unit weight / g), damping in proportion to the stiffness and, on the smooth wall, dashpots that absorb
    // shear waves (Lysmer and Kuhlemeyer 1969); the floor reflects. Integrated by Newmark's average acceleration in the
    // steps of the history; derivatives are those of its steps. It is followed for twice the time of the history, and
    // then for twice the time that a shear wave takes to inertia.reach at the slowest pace from the surface down, that
    // of the mean of 1/Vs over all layers above one depth or another: what the floor throws back may be the largest.
    Outcome<InertialCourse> inertial(const Solution<Element>& end, const Eigen::VectorXd& load, const History& history,
                                     const Inertia& inertia, const std::vector<Functional<Element>>& readings);

private:
    struct Work;
    std::unique_ptr<Work> work_;
    OnStep on_step_;
    OnMarch on_march_;
};

} // namespace pave::fe
