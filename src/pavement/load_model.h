// The model of one load on a section: the cheapest one that serves it.
#pragma once

#include "base/outcome.h"
#include "fe/solver.h"
#include "pavement/fields.h"
#include "pavement/observation.h"
#include "pavement/section.h"

#include <map>
#include <memory>
#include <span>

namespace pave::pavement {

// Positions of the mesh lines along each axis, or the breaks among them that geometry moves [m].
using Lines = std::vector<std::vector<double>>;

// The two kinds of model. Each says where the lines of its mesh lie and how its load acts.
struct Axisymmetric { // one circle on the axis
    using Element = fe::AxisymmetricQ8;
    using Mesh = mesh::AxisymmetricMesh;
    static Mesh nominal_mesh(const Case& c, int load);
    static Lines lines_of(const Mesh& mesh);
    static Lines breaks(const Case& c, int load);
    static Mesh mesh_of(Lines lines, const Case& c, int load);
    // Force of a mean pressure of 1 Pa on the footprint, on every free unknown [N].
    static Eigen::VectorXd unit_load(const Mesh& mesh, const fe::Model<Element>& model, const Load& load);
};
// Any load: a quarter, for all loads are symmetric to x = 0 and y = 0.
struct Solid {
    using Element = fe::Hex20;
    using Mesh = mesh::SolidMesh;
    static Mesh nominal_mesh(const Case& c, int load);
    static Lines lines_of(const Mesh& mesh);
    static Lines breaks(const Case& c, int load);
    static Mesh mesh_of(Lines lines, const Case& c, int load);
    static Eigen::VectorXd unit_load(const Mesh& mesh, const fe::Model<Element>& model, const Load& load);
};

// The lines; of a half-space at rest with cells after the last that double its distance each, then one without end. A
// cell without end alone would be too stiff: far below, what falls off to the side does so from a distance like the
// depth. The waves of a pulse leave through sides that are open.
std::vector<double> with_far_cells(std::vector<double> lines, const Case& c, int load, int doublings);

// Depth of the bottom of every layer [m].
std::vector<double> bottoms_of(const Case& c);

// The layers as the solvers see them.
std::vector<fe::LayerMaterial> materials_of(const Case& c);

// The springs of the model of a load: slipping interfaces from above, then the plate.
fe::Springs springs_of(const Case& c, int load);

// Of each layer, whether its stiffness stays what it is.
std::vector<bool> linear_layers(const Case& c);

// Of each layer, whether Poisson's ratio is above 0.45: see observe().
std::vector<bool> incompressible_layers(const Case& c);

// Cases of moved geometry near one: the derivative of a function of the case by what moves it is the sum of the
// function at each, times its weight.
using Neighbours = std::vector<std::pair<double, Case>>;

class LoadModel {
public:
    virtual ~LoadModel() = default;

    // The cache of one thread: the last geometry and the factors on it. Makes a run faster, never different.
    class Workspace {
    public:
        virtual ~Workspace() = default;
    };
    // Solvers that the loads of one thread use in turn: one serves all whose finite element model is the same. By that
    // model; what is under it is the model's business.
    using Lent = std::map<const void*, std::shared_ptr<void>>;
    virtual std::unique_ptr<Workspace> make_workspace(Lent& lent) const = 0;
    // Of a load on its own.
    std::unique_ptr<Workspace> make_workspace() const {
        Lent lent;
        return make_workspace(lent);
    }
    // Of the finite element system; 0: there is none.
    virtual int unknowns() const = 0;
    // The finite element model under it; loads with the same one use its memory in turn. None: there is none.
    virtual const void* shared_model() const { return nullptr; }
    // Has f called along the pulses of runs with this workspace.
    virtual void watch(Workspace&, const fe::OnMarch&) const {}
    // How deep a section can be read [m].
    virtual double reach(const Case& values) const { return values.depth(); }

    struct Reading {
        // Of every sensor of the case, SI; 0 for those of loads that are not on the path of this one.
        std::vector<double> values;
        Eigen::MatrixXd derivatives; // sensors x variations, SI
        fe::Statistics statistics;
        std::vector<double> errors{}; // of a reduced model: estimates of |error| of the values; empty: none is made
    };
    // values differ from the nominal case in numbers only. moving: of each motion of the mesh that a variation is the
    // number of.
    virtual Outcome<Reading> run(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                                 const std::vector<fe::Variation>& variations, const std::vector<Neighbours>& moving,
                                 Workspace& workspace) const = 0;
    // How many runs go together for about the price of one, in lanes of the processor's vectors; 1: none do.
    virtual int lanes() const { return 1; }
    // A run whose mesh moves with no variation.
    struct Run {
        const Case* values;
        const std::vector<fe::LayerMaterial>* layers;
        const std::vector<fe::Variation>* variations;
    };
    // Whether a run goes with others, whatever these are.
    virtual bool goes_with_others(const Run&) const { return false; }
    // Those runs, as run() but for rounding; the bits of each are the same with other runs beside it, and alone.
    virtual std::vector<Outcome<Reading>> run_together(std::span<const Run>, Workspace&) const { return {}; }
    // At the end of such a run, of the load at rest.
    virtual Outcome<Fields> fields(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                                   Workspace& workspace) const = 0;
};

using LoadModels = std::vector<std::shared_ptr<const LoadModel>>;

// The layered engine where the settings allow it and it serves; else finite elements, by the model of one of the others
// whose mesh is the same.
std::unique_ptr<const LoadModel> make_load_model(const Case& nominal, int load, const LoadModels& others = {});
// The geometry of the nominal case fixes the structure of the mesh; other geometries move its lines. Throws Error when
// the load does not fit into the mesh.
std::unique_ptr<const LoadModel> make_finite_element_model(const Case& nominal, int load,
                                                           const LoadModels& others = {});

// The same of a load that is a pulse, its motion looked for in a subspace of that model.
std::unique_ptr<const LoadModel> make_pulse_model(const Case& nominal, int load, fe::Subspace subspace);

// The parts of such a model with the load vector at the load's own pressure, for tests and benchmarks that look inside.
template <class Kind>
struct Parts {
    typename Kind::Mesh mesh;
    fe::Model<typename Kind::Element> model;
    Eigen::VectorXd load; // N
    std::vector<fe::LayerMaterial> layers;
};
template <class Kind>
Parts<Kind> parts_of(const Case& c, int load) {
    Parts<Kind> parts;
    parts.mesh = Kind::nominal_mesh(c, load);
    parts.model = fe::make_model(parts.mesh, linear_layers(c));
    parts.load =
        c.loads[load].pressure * c.loads[load].factor * Kind::unit_load(parts.mesh, parts.model, c.loads[load]);
    parts.layers = materials_of(c);
    return parts;
}

} // namespace pave::pavement
