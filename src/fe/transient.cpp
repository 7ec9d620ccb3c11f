#include "base/units.h"
#include "fe/gauss_rule.h"
#include "fe/solver_work.h"

#include <cmath>

namespace pave::fe {
namespace {

// Calls at(position, weight) for the product rule of three points a direction.
template <class Element, class F>
void integrate(F at) {
    int all = 1;
    for (int d = 0; d < Element::dim; ++d) {
        all *= 3;
    }
    for (int q = 0; q < all; ++q) {
        typename Element::Position position;
        double weight = 1.0;
        for (int d = 0, rest = q; d < Element::dim; ++d, rest /= 3) {
            position[d] = three_points[rest % 3].first;
            weight *= three_points[rest % 3].second;
        }
        at(position, weight);
    }
}

// The extreme of larger magnitude of a cubic between two values with their slopes over a unit interval.
double extreme(double a, double da, double b, double db) {
    double best = std::abs(a) > std::abs(b) ? a : b;
    // d/dx of the Hermite cubic: c0 + c1 x + c2 x^2
    const double c0 = da;
    const double c1 = 6.0 * (b - a) - 4.0 * da - 2.0 * db;
    const double c2 = 3.0 * (da + db) - 6.0 * (b - a);
    const double root = c1 * c1 - 4.0 * c0 * c2;
    if (root < 0.0) {
        return best;
    }
    const double q = -(c1 + std::copysign(std::sqrt(root), c1)) / 2.0;
    for (const double x : {q / c2, c0 / q}) {
        if (x > 0.0 && x < 1.0) {
            const double value = a + x * (c0 + x * (c1 / 2.0 + x * c2 / 3.0));
            best = std::abs(value) > std::abs(best) ? value : best;
        }
    }
    return best;
}

double value_of(const Functional& reading, const Eigen::VectorXd& u) {
    double value = 0.0;
    for (const auto& [unknown, weight] : reading) {
        value += weight * u[unknown];
    }
    return value;
}

// y += K x
void add_product(const Pattern& lower, const std::vector<double>& values, const Eigen::VectorXd& x,
                 Eigen::VectorXd& y) {
    for (int j = 0; j < lower.size; ++j) {
        for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
            const int i = lower.row[k];
            y[i] += values[k] * x[j];
            if (i != j) {
                y[j] += values[k] * x[i];
            }
        }
    }
}

} // namespace

template <class Element>
Outcome<std::vector<double>> Solver<Element>::inertial_excess(const Solution<Element>& end, const Eigen::VectorXd& load,
                                                              const Pulse& pulse,
                                                              const std::vector<Functional>& readings) {
    Work& w = *work_;
    const Pattern& lower = w.topology->lower;
    Eigen::VectorXd modulus(w.points());
    for (int q = 0; q < w.points(); ++q) {
        modulus[q] = end.modulus[w.active[q / Element::gauss] * Element::gauss + q % Element::gauss];
    }
    w.assemble(modulus);
    const std::vector<double> stiffness = w.values;

    std::vector<double> mass(stiffness.size(), 0.0);
    std::vector<double> damping(stiffness.size(), 0.0);
    const double per_stiffness = pulse.inertia * pulse.damping * pulse.duration / std::numbers::pi;
    for (std::size_t k = 0; k < stiffness.size(); ++k) {
        damping[k] = per_stiffness * stiffness[k];
    }
    double wall = 0.0; // where it stands: the farthest coordinate
    for (const auto& x : w.model->coordinates) {
        wall = std::max(wall, x.row(0).maxCoeff());
    }
    // Adds factor * (shape shape^T) of one element for displacements in the directions first .. dim - 1.
    const auto add = [&](std::vector<double>& to, int e, const Eigen::Matrix<double, Element::nodes, 1>& shape,
                         double factor, int first) {
        const auto& scatter = w.topology->scatter[e];
        for (int a = 0; a < Element::dofs; ++a) {
            for (int b = 0; b <= a; ++b) {
                const int place = scatter[a * (a + 1) / 2 + b];
                if (place >= 0 && a % Element::dim == b % Element::dim && a % Element::dim >= first) {
                    to[place] += factor * shape[a / Element::dim] * shape[b / Element::dim];
                }
            }
        }
    };
    for (int e = 0; e < w.model->elements(); ++e) {
        const auto& x = w.model->coordinates[e];
        const double density = w.layer_of(e).unit_weight / unit::gravity;
        integrate<Element>([&](const typename Element::Position& at, double weight) {
            add(mass, e, Element::shape(at), pulse.inertia * density * weight * Element::point(x, at).weight, 0);
        });
        if constexpr (Element::dim == 2) {
            if (!pulse.absorbs || x.row(0).maxCoeff() < wall) {
                continue;
            }
            // The shear wave speed on average over the element.
            double shear = 0.0;
            for (int g = 0; g < Element::gauss; ++g) {
                shear += end.modulus[e * Element::gauss + g] * w.unit(e, g)(3, 3) / Element::gauss;
            }
            const double height = x(1, 3) - x(1, 0);
            for (const auto& [eta, weight] : three_points) {
                const double area = 2.0 * std::numbers::pi * wall * weight * height / 2.0;
                add(damping, e, Element::shape({1.0, eta}), pulse.inertia * std::sqrt(density * shear) * area,
                    Element::down);
            }
        }
    }

    constexpr int steps_of_pulse = 80;
    const double step = pulse.duration / steps_of_pulse;
    std::vector<double> effective = stiffness;
    for (std::size_t k = 0; k < effective.size(); ++k) {
        effective[k] += 2.0 / step * damping[k] + 4.0 / (step * step) * mass[k];
    }
    const Failure not_definite{Status::failed,
                               "the section has lost its stiffness at the end of the load path: no pulse "
                               "can be followed there"};
    SupernodalFactor<double> factor(lower, w.topology->analysis->structure());
    if (!factor.factorize(stiffness, true)) {
        return not_definite;
    }
    Block<1> at_rest = load;
    factor.solve<1>(at_rest);
    if (!factor.factorize(effective, true)) {
        return not_definite;
    }
    Eigen::VectorXd u = Eigen::VectorXd::Zero(load.size());
    Eigen::VectorXd v = u;
    Eigen::VectorXd acceleration = u;
    std::vector<double> peak(readings.size(), 0.0);
    std::vector<double> value(readings.size(), 0.0);
    std::vector<double> slope(readings.size(), 0.0);    // per step
    for (int n = 1; n <= 4 * steps_of_pulse / 3; ++n) { // the farthest sensors lag by some milliseconds
        const double sine = n < steps_of_pulse ? std::sin(std::numbers::pi * n / steps_of_pulse) : 0.0;
        Block<1> next = sine * sine * load;
        add_product(lower, mass, 4.0 / (step * step) * u + 4.0 / step * v + acceleration, next);
        add_product(lower, damping, 2.0 / step * u + v, next);
        factor.solve<1>(next);
        const Eigen::VectorXd change = next - u;
        acceleration = 4.0 / (step * step) * change - 4.0 / step * v - acceleration;
        v = 2.0 / step * change - v;
        u = next;
        for (std::size_t i = 0; i < readings.size(); ++i) {
            const double now = value_of(readings[i], u);
            const double now_slope = step * value_of(readings[i], v);
            const double most = extreme(value[i], slope[i], now, now_slope);
            peak[i] = std::abs(most) > std::abs(peak[i]) ? most : peak[i];
            value[i] = now;
            slope[i] = now_slope;
        }
    }
    for (std::size_t i = 0; i < readings.size(); ++i) {
        peak[i] -= value_of(readings[i], at_rest);
    }
    return peak;
}

template Outcome<std::vector<double>> Solver<AxisymmetricQ8>::inertial_excess(const Solution<AxisymmetricQ8>&,
                                                                              const Eigen::VectorXd&, const Pulse&,
                                                                              const std::vector<Functional>&);
template Outcome<std::vector<double>> Solver<Hex20>::inertial_excess(const Solution<Hex20>&, const Eigen::VectorXd&,
                                                                     const Pulse&, const std::vector<Functional>&);

} // namespace pave::fe
