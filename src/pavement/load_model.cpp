#include "pavement/load_model.h"

#include "base/error.h"
#include "base/units.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace pave::pavement {
namespace {

// Piecewise linear map of mesh lines from one set of breaks to another of the same length. A break that has no line of
// its own, too near another for one, moves none.
std::vector<double> moved_lines(std::vector<double> lines, std::vector<double> from, std::vector<double> to) {
    if (from == to) {
        return lines;
    }
    for (std::size_t i = from.size(); i-- > 0;) {
        if (!std::binary_search(lines.begin(), lines.end(), from[i])) {
            from.erase(from.begin() + static_cast<std::ptrdiff_t>(i));
            to.erase(to.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }
    for (double& x : lines) {
        const auto above = std::lower_bound(from.begin(), from.end(), x);
        const std::size_t i = above - from.begin();
        x = *above == x ? to[i] : to[i - 1] + (x - from[i - 1]) / (from[i] - from[i - 1]) * (to[i] - to[i - 1]);
    }
    return lines;
}

const Failure does_not_fit{Status::invalid_parameters,
                           "the patch does not fit into the mesh, or those of the dual overlap, for this geometry"};

const Failure not_finite{Status::failed, "the solution is not a finite number"};

// sin^2(pi t / duration); shown at its peak.
fe::History history_of(const Load& load) {
    constexpr std::size_t steps = 40;
    fe::History history{.step = load.duration / steps, .factors = {}, .shown = steps / 2 - 1};
    for (std::size_t i = 1; i <= steps; ++i) {
        const double sine = std::sin(std::numbers::pi * static_cast<double>(i) / steps);
        history.factors.push_back(sine * sine);
    }
    return history;
}

// Weights on the steps of a course that make its extreme: that of the parabola through the step of largest magnitude
// and the two beside it. Its place is stationary: the weights are, for derivatives.
std::vector<std::pair<Eigen::Index, double>> at_extreme(const Eigen::RowVectorXd& values) {
    Eigen::Index i = 0;
    values.cwiseAbs().maxCoeff(&i);
    const Eigen::Index last = values.size() - 1;
    const double before = i > 0 ? values[i - 1] : 0.0;
    const double curvature = i < last ? before - 2.0 * values[i] + values[i + 1] : 0.0;
    if (curvature == 0.0) {
        return {{i, 1.0}};
    }
    const double x = (before - values[i + 1]) / (2.0 * curvature); // in steps from i
    std::vector<std::pair<Eigen::Index, double>> weights{{i, 1.0 - x * x}, {i + 1, x * (x + 1.0) / 2.0}};
    if (i > 0) {
        weights.emplace_back(i - 1, x * (x - 1.0) / 2.0);
    }
    return weights;
}

template <class Kind>
class LoadModelOf final : public LoadModel {
public:
    using Element = typename Kind::Element;

    LoadModelOf(const Case& nominal, int load)
        : load_(load),
          breaks_(Kind::breaks(nominal, load)),
          mesh_(Kind::nominal_mesh(nominal, load)),
          model_(fe::make_model(mesh_, linear_layers(nominal), springs_of(nominal, load))),
          incompressible_(incompressible_layers(nominal)) {}

    std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Own>(); }
    int unknowns() const override { return model_.free_unknowns(); }

    Outcome<Reading> run(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                         const std::vector<fe::Variation>& variations, const std::vector<Neighbours>& moving,
                         Workspace& workspace) const override {
        const Load& load = values.loads[load_];
        Own& own = static_cast<Own&>(workspace);
        if (!own.fit(*this, values)) {
            return does_not_fit;
        }
        const double pressure = load.pressure * load.factor;
        const Eigen::VectorXd force = pressure * own.unit_load;
        std::vector<fe::Variation> by = variations;
        for (fe::Variation& variation : by) {
            if (variation.kind == fe::Variation::Kind::pressure_shape) {
                variation.load_rate = pressure * own.unit_load_rate(load);
            }
        }
        std::vector<fe::Motion<Element>> motions;
        std::vector<std::vector<Observation<Element>>> observation_rates;
        for (const Neighbours& near : moving) {
            auto [motion, rates] = move(values, near, own);
            motions.push_back(std::move(motion));
            observation_rates.push_back(std::move(rates));
        }
        if (values.relaxes()) {
            return over_time(values, layers, force, by, own);
        }
        const auto solved = solve(values, layers, force, by, motions, own);
        if (!solved) {
            return solved.failure();
        }
        const auto count = static_cast<Eigen::Index>(variations.size());
        Reading reading;
        reading.values.resize(values.sensors.size());
        reading.derivatives.setZero(static_cast<Eigen::Index>(values.sensors.size()), count);
        reading.statistics = solved->statistics;
        for (std::size_t i = 0; i < values.sensors.size(); ++i) {
            if (values.sensors[i].load != load_) {
                continue;
            }
            const auto& o = own.observations[i];
            const bool stress = !o.on_stress.empty();
            reading.values[i] =
                stress ? o.of_stress(solved->stress, 1, 0) : o.of_displacement(solved->displacement.data());
            for (Eigen::Index k = 0; k < count; ++k) {
                reading.derivatives(static_cast<Eigen::Index>(i), k) =
                    stress ? o.of_stress(solved->d_stress, count, k)
                           : o.of_displacement(solved->d_displacement.col(k).data());
                const fe::Variation& v = variations[static_cast<std::size_t>(k)];
                if (v.kind == fe::Variation::Kind::motion) { // the place in the mesh that is read moves too
                    const auto& rate = observation_rates[v.index][i];
                    reading.derivatives(static_cast<Eigen::Index>(i), k) +=
                        stress ? rate.of_stress(solved->stress, 1, 0)
                               : rate.of_displacement(solved->displacement.data());
                }
            }
            if (!std::isfinite(reading.values[i])) {
                return not_finite;
            }
        }
        if (load.inertia) {
            return with_inertia(std::move(reading), values, solved.value(), force, own);
        }
        return reading;
    }

    Outcome<Fields> fields(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                           Workspace& workspace) const override {
        const Load& load = values.loads[load_];
        Own& own = static_cast<Own&>(workspace);
        if (!own.fit(*this, values)) {
            return does_not_fit;
        }
        const Eigen::VectorXd force = load.pressure * load.factor * own.unit_load;
        if (values.relaxes()) {
            const auto course = own.solver->over_time(layers, force, history_of(load), {}, {}, values.settings.solver,
                                                      spring_stiffness(values));
            return course ? Outcome<Fields>(fields_of(*own.model, layers, course->shown)) : course.failure();
        }
        const auto solved = solve(values, layers, force, {}, {}, own);
        if (!solved) {
            return solved.failure();
        }
        return fields_of(*own.model, layers, solved.value());
    }

private:
    struct Own;

    Outcome<fe::Solution<Element>> solve(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                                         const Eigen::VectorXd& force, const std::vector<fe::Variation>& by,
                                         const std::vector<fe::Motion<Element>>& motions, Own& own) const {
        const auto& settings = values.settings.solver;
        const std::vector<double> springs = spring_stiffness(values);
        return values.settings.integration == Integration::secant
                   ? own.solver->secant(layers, force, by, settings, springs, motions)
                   : own.solver->incremental(layers, force, by, settings, springs, motions);
    }

    // Of a section with layers that relax: the extreme of every reading over the time of the load.
    Outcome<Reading> over_time(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                               const Eigen::VectorXd& force, const std::vector<fe::Variation>& by, Own& own) const {
        std::vector<Eigen::Index> rows;
        std::vector<fe::Functional<Element>> functionals;
        for (std::size_t i = 0; i < values.sensors.size(); ++i) {
            if (values.sensors[i].load == load_) {
                rows.push_back(static_cast<Eigen::Index>(i));
                functionals.push_back(own.observations[i]);
            }
        }
        const auto course = own.solver->over_time(layers, force, history_of(values.loads[load_]), functionals, by,
                                                  values.settings.solver, spring_stiffness(values));
        if (!course) {
            return course.failure();
        }
        Reading reading;
        reading.values.resize(values.sensors.size());
        reading.derivatives.setZero(static_cast<Eigen::Index>(values.sensors.size()),
                                    static_cast<Eigen::Index>(by.size()));
        reading.statistics = course->shown.statistics;
        for (std::size_t r = 0; r < rows.size(); ++r) {
            const auto row = static_cast<Eigen::Index>(r);
            double& value = reading.values[static_cast<std::size_t>(rows[r])];
            for (const auto& [step, weight] : at_extreme(course->values.row(row))) {
                value += weight * course->values(row, step);
                reading.derivatives.row(rows[r]) += weight * course->d_values[static_cast<std::size_t>(step)].row(row);
            }
            if (!std::isfinite(value)) {
                return not_finite;
            }
        }
        return reading;
    }

    // Of every spring of the model [Pa/m].
    std::vector<double> spring_stiffness(const Case& values) const {
        std::vector<double> stiffness;
        for (const Layer& layer : values.layers) {
            if (layer.compliance) {
                stiffness.push_back(1.0 / *layer.compliance);
            }
        }
        if (const auto& plate = values.loads[load_].plate_stiffness) {
            stiffness.push_back(*plate);
        }
        return stiffness;
    }

    // What a pulse of the load adds to what is measured under it.
    Outcome<Reading> with_inertia(Reading reading, const Case& values, const fe::Solution<Element>& solved,
                                  const Eigen::VectorXd& force, Own& own) const {
        std::vector<std::size_t> rows;
        std::vector<fe::Functional<Element>> functionals;
        for (std::size_t i = 0; i < values.sensors.size(); ++i) {
            if (values.sensors[i].load == load_ && values.sensors[i].measured) {
                rows.push_back(i);
                functionals.push_back(own.observations[i]);
            }
        }
        fe::Pulse pulse;
        pulse.duration = values.loads[load_].duration;
        pulse.inertia = *values.loads[load_].inertia;
        const auto excess = own.solver->inertial_excess(solved, force, pulse, functionals);
        if (!excess) {
            return excess.failure();
        }
        for (std::size_t k = 0; k < rows.size(); ++k) {
            reading.values[rows[k]] += excess->values[k];
            reading.derivatives.row(static_cast<Eigen::Index>(rows[k])) +=
                excess->derivatives.row(static_cast<Eigen::Index>(k));
        }
        return reading;
    }

    struct Own : Workspace {
        Lines lines;
        typename Kind::Mesh mesh;
        std::unique_ptr<fe::Model<Element>> model;
        std::unique_ptr<fe::Solver<Element>> solver;
        double pressure_shape = 0.0; // of unit_load
        Eigen::VectorXd unit_load;   // pressure 1 Pa
        std::vector<Sensor> sensors; // of the observations
        std::vector<Observation<Element>> observations;

        // d(unit_load)/d(pressure_shape): the pressure is linear in it.
        Eigen::VectorXd unit_load_rate(Load load) const {
            load.pressure_shape += 1.0;
            return Kind::unit_load(mesh, *model, load) - unit_load;
        }

        // False: the load does not fit into the mesh of this geometry.
        bool fit(const LoadModelOf& of, const Case& values) {
            const Lines breaks = Kind::breaks(values, of.load_);
            for (const auto& along : breaks) {
                if (!std::is_sorted(along.begin(), along.end(), std::less_equal<>())) {
                    return false;
                }
            }
            Lines wanted = of.lines_for(breaks);
            const Load& load = values.loads[of.load_];
            const bool moves = wanted != lines;
            if (moves) {
                lines = wanted;
                mesh = Kind::mesh_of(std::move(wanted), bottoms_of(values));
                auto moved =
                    std::make_unique<fe::Model<Element>>(fe::make_model(mesh, of.model_, springs_of(values, of.load_)));
                if (solver == nullptr) {
                    solver = std::make_unique<fe::Solver<Element>>(*moved);
                } else {
                    solver->move(*moved);
                }
                model = std::move(moved);
            }
            if (moves || load.pressure_shape != pressure_shape) {
                unit_load = Kind::unit_load(mesh, *model, load);
                pressure_shape = load.pressure_shape;
            }
            if (moves || sensors != values.sensors) {
                sensors = values.sensors;
                observations.clear();
                for (const Sensor& sensor : sensors) {
                    observations.push_back(sensor.load == of.load_
                                               ? observe(sensor, mesh, *model, mesh, of.incompressible_)
                                               : Observation<Element>{});
                }
            }
            return true;
        }
    };

    Lines lines_for(const Lines& breaks) const {
        Lines lines = Kind::lines_of(mesh_);
        for (std::size_t axis = 0; axis < lines.size(); ++axis) {
            lines[axis] = moved_lines(std::move(lines[axis]), breaks_[axis], breaks[axis]);
        }
        return lines;
    }

    // How the mesh, the load and the readings move. No system is solved for them.
    std::pair<fe::Motion<Element>, std::vector<Observation<Element>>> move(const Case& values, const Neighbours& near,
                                                                           const Own& own) const {
        fe::Motion<Element> motion;
        motion.points.resize(model_.points.size());
        for (auto& point : motion.points) {
            point.rows.setZero();
        }
        motion.vertical_stress.assign(model_.points.size(), 0.0);
        motion.load = Eigen::VectorXd::Zero(model_.free_unknowns());
        std::vector<Observation<Element>> rates(values.sensors.size());
        for (const auto& [weight, there] : near) {
            const auto mesh = Kind::mesh_of(lines_for(Kind::breaks(there, load_)), bottoms_of(there));
            const auto model = fe::make_model(mesh, model_);
            const auto layers = materials_of(there);
            for (std::size_t q = 0; q < model.points.size(); ++q) {
                motion.points[q].weight += weight * model.points[q].weight;
                motion.points[q].rows += weight * model.points[q].rows;
                const auto layer = static_cast<std::size_t>(model.topology->layer[q / Element::gauss]);
                motion.vertical_stress[q] += weight * layers[layer].vertical_stress(model.depth[q]);
            }
            const Load& load = there.loads[load_];
            motion.load += weight * load.pressure * load.factor * Kind::unit_load(mesh, model, load);
            for (std::size_t i = 0; i < values.sensors.size(); ++i) {
                if (values.sensors[i].load != load_) {
                    continue;
                }
                const auto o = observe(values.sensors[i], mesh, model, own.mesh, incompressible_);
                for (const auto& [unknown, part] : o.on_displacement) {
                    rates[i].on_displacement.emplace_back(unknown, weight * part);
                }
                for (const auto& [point, part, direction] : o.on_stress) {
                    rates[i].on_stress.push_back({point, weight * part, direction});
                }
            }
        }
        return {std::move(motion), std::move(rates)};
    }

    int load_;
    Lines breaks_;
    typename Kind::Mesh mesh_;
    fe::Model<Element> model_;
    std::vector<bool> incompressible_; // layers
};

} // namespace

std::vector<double> bottoms_of(const Case& c) {
    std::vector<double> bottoms;
    double z = 0.0;
    for (const Layer& layer : c.layers) {
        bottoms.push_back(z += layer.thickness);
    }
    return bottoms;
}

std::vector<fe::LayerMaterial> materials_of(const Case& c) {
    std::vector<fe::LayerMaterial> layers;
    double top = 0.0;
    double stress = 0.0;
    for (const Layer& layer : c.layers) {
        fe::LayerMaterial m;
        m.law = layer.law;
        m.parameters = layer.parameters;
        if (const auto floor = layer.law->index_of("shear_floor"); floor && std::isnan(m.parameters[*floor])) {
            m.parameters[*floor] = c.settings.integration == Integration::secant ? 1.0 : 0.0;
        }
        m.top = top;
        m.thickness = layer.thickness;
        m.top_stress = stress;
        m.unit_weight = layer.density * unit::gravity;
        m.k0 = layer.k0;
        m.residual_stress = layer.residual_stress;
        m.fields = layer.fields;
        top += layer.thickness;
        stress += m.unit_weight * layer.thickness;
        layers.push_back(std::move(m));
    }
    return layers;
}

fe::Springs springs_of(const Case& c, int load) {
    fe::Springs springs;
    for (std::size_t l = 0; l < c.layers.size(); ++l) {
        if (c.layers[l].compliance) {
            springs.slipping_layers.push_back(static_cast<int>(l));
        }
    }
    if (c.loads[load].plate_stiffness) {
        springs.plate_radius = c.loads[load].radius;
    }
    return springs;
}

std::vector<bool> linear_layers(const Case& c) {
    std::vector<bool> linear;
    for (const Layer& layer : c.layers) {
        linear.push_back(!layer.law->stress_dependent() && !layer.law->relaxes());
    }
    return linear;
}

std::vector<bool> incompressible_layers(const Case& c) {
    std::vector<bool> incompressible;
    for (const Layer& layer : c.layers) {
        const auto poisson = layer.law->index_of("poisson");
        incompressible.push_back(poisson && layer.parameters[*poisson] > 0.45 + 1e-9);
    }
    return incompressible;
}

std::unique_ptr<const LoadModel> make_load_model(const Case& nominal, int number) {
    const Load& load = nominal.loads[number];
    const auto footprint = load.footprint();
    const double reach = std::max(footprint.outer(), footprint.half_y);
    if (!(1.01 * reach < nominal.settings.extent)) {
        throw Error({.key = "mesh.extent_m"}, "the load \"" + load.name + "\" does not fit into the mesh",
                    fmt::format("{}", nominal.settings.extent),
                    fmt::format("more than 1.01 times its reach of {:.4g} m", reach));
    }
    if (footprint.centre > 0.0 && footprint.inner() < -1e-9 * footprint.half_x) {
        throw Error({.key = load.name + ".spacing_mm"}, "the two patches of the dual wheel overlap",
                    fmt::format("{:g}", load.spacing / unit::mm),
                    fmt::format("at least the width of a patch, {:.4g} mm", 2.0 * footprint.half_x / unit::mm));
    }
    if (load.is_axisymmetric()) {
        return std::make_unique<LoadModelOf<Axisymmetric>>(nominal, number);
    }
    return std::make_unique<LoadModelOf<Solid>>(nominal, number);
}

} // namespace pave::pavement
