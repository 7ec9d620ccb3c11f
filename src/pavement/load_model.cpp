#include "pavement/load_model.h"

#include "base/error.h"
#include "base/memory_limit.h"
#include "base/units.h"
#include "fe/batch_solver.h"
#include "pavement/forward.h"
#include "pavement/layered.h"
#include "pavement/pulse.h"
#include "pavement/solid_cost.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numbers>
#include <utility>

namespace pave::pavement {
namespace {

constexpr double giga = 1e9;

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

const Failure energy_beside_secant{Status::failed,
                                   "a layer whose strain derives from an energy stands beside one whose modulus is a "
                                   "secant: they can be followed along the load path together (incremental)"};

// Steps of the pulse: of what relaxes, and of what moves.
constexpr int relaxing_steps = 40;
constexpr int moving_steps = 80;

// Under a pulse damping in proportion to the stiffness has this ratio to the critical one at the frequency 1/duration.
constexpr double damping_ratio = 0.05;

// The direction in which the extreme of a reading is looked for: deflections downwards, for that is the peak that a
// deflectometer keeps; strains and stresses as they point under the load at rest.
double direction_of(const Sensor& sensor, double at_rest) {
    return sensor.quantity == Quantity::deflection || at_rest >= 0.0 ? 1.0 : -1.0;
}

// Readings of sensors over the time of a load, a row a sensor. All ways of modelling it end here; a load at rest is the
// course of one instant.
struct Responses {
    fe::Course at_rest; // one instant: the load at rest, or where it is largest
    fe::Course moving;  // over time
    fe::Course slow;    // what that would come to if the load acted slowly: one instant
    std::vector<std::pair<std::size_t, fe::Followed>> on_the_way; // sensors of lighter loads, by their number
    fe::Statistics statistics;
};

// The reading that stands for a course: what it is at rest, and by how much its extreme over time is beyond that of a
// load that acts slowly. Slowly applied, a reading reaches what it is at rest, but nothing where that points against
// its direction (the heave beside a plate): so a section that hardly moves or relaxes reads as one at rest there too.
fe::Followed reading_of(const Sensor& sensor, const Responses& responses, Eigen::Index row) {
    fe::Followed reading = fe::at_instant(responses.at_rest, row, 0);
    const double direction = direction_of(sensor, reading.value);
    const fe::Followed extreme = fe::peak(responses.moving, row, direction);
    const fe::Followed slowly = fe::peak(responses.slow, row, direction);
    reading.value += extreme.value - slowly.value;
    reading.rates += extreme.rates - slowly.rates;
    return reading;
}

void keep_at_rest(fe::Course& course, Eigen::Index row) {
    course.values.row(row).setZero();
    if (course.slopes.size() > 0) {
        course.slopes.row(row).setZero();
    }
    for (auto* rates : {&course.d_values, &course.d_slopes}) {
        for (Eigen::MatrixXd& at_instant : *rates) {
            at_instant.row(row).setZero();
        }
    }
}

// A mesh whose factor fits into the memory of this machine; throws Error for another.
template <class Kind>
typename Kind::Mesh affordable_mesh(const Case& nominal, int number) {
    auto mesh = Kind::nominal_mesh(nominal, number);
    if constexpr (Kind::Element::dim == 3) {
        const double unknowns = 3.0 * static_cast<double>(mesh.nodes.size());
        const double available = memory_limit();
        if (solid_memory(unknowns) > available) {
            throw Error({.key = "mesh.refine"},
                        "a run of the load \"" + nominal.loads[number].name + "\" needs more memory than there is",
                        fmt::format("about {:.0f} GB for {:.0f} unknowns", solid_memory(unknowns) / giga, unknowns),
                        fmt::format("{:.0f} GB: a smaller refine or extent_m", available / giga));
        }
    }
    return mesh;
}

template <class Kind>
class LoadModelOf final : public LoadModel {
public:
    using Element = typename Kind::Element;

    // subspace: of the pulse, if it is looked for in one.
    LoadModelOf(const Case& nominal, int load, const LoadModels& others, std::optional<fe::Subspace> subspace = {})
        : load_(load),
          breaks_(Kind::breaks(nominal, load)),
          mesh_(affordable_mesh<Kind>(nominal, load)),
          springs_(springs_of(nominal, load)),
          is_pulse_(nominal.loads[load].is_pulse()),
          model_(model_among(others)),
          incompressible_(incompressible_layers(nominal)),
          path_of_(path_of_each(nominal)),
          subspace_(std::move(subspace)) {
        if (!model_) {
            model_ = std::make_shared<fe::Model<Element>>(fe::make_model(mesh_, linear_layers(nominal), springs_));
        }
    }

    std::unique_ptr<Workspace> make_workspace(Lent& lent) const override {
        std::shared_ptr<void>& shared = lent[model_.get()];
        if (!shared) {
            shared = std::make_shared<Geometry>();
        }
        auto own = std::make_unique<Own>();
        own->geometry = std::static_pointer_cast<Geometry>(shared);
        return own;
    }
    int unknowns() const override {
        return subspace_ ? static_cast<int>(subspace_->modes.cols()) : model_->free_unknowns();
    }
    const void* shared_model() const override { return model_.get(); }
    void watch(Workspace& workspace, const fe::OnMarch& f) const override { static_cast<Own&>(workspace).on_march = f; }

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
        const auto followed = follow(values, layers, force, by, motions, observation_rates, own);
        if (!followed) {
            return followed.failure();
        }
        const std::vector<std::size_t> sensors = sensors_of(values);
        Reading reading;
        reading.values.resize(values.sensors.size());
        reading.derivatives.setZero(static_cast<Eigen::Index>(values.sensors.size()),
                                    static_cast<Eigen::Index>(by.size()));
        reading.statistics = followed->statistics;
        for (std::size_t r = 0; r < sensors.size(); ++r) {
            const std::size_t i = sensors[r];
            const auto row = static_cast<Eigen::Index>(r);
            const auto read = load.is_pulse() ? read_pulse(values.sensors[i], load, followed->moving, row,
                                                           values.settings.time_step, by)
                                              : reading_of(values.sensors[i], *followed, row);
            reading.values[i] = read.value;
            reading.derivatives.row(static_cast<Eigen::Index>(i)) = read.rates;
        }
        for (const auto& [i, read] : followed->on_the_way) {
            reading.values[i] = read.value;
            reading.derivatives.row(static_cast<Eigen::Index>(i)) = read.rates;
        }
        return reading;
    }

    int lanes() const override {
        return !is_axisymmetric || is_pulse_ || !model_->springs.empty() ? 1 : fe::BatchSolver::lanes();
    }
    bool goes_with_others(const Run& run) const override {
        if constexpr (is_axisymmetric) {
            const Case& values = *run.values;
            return !is_pulse_ && !values.relaxes() && !values.is_hyperelastic() &&
                   values.settings.integration == Integration::incremental && !values.loads[load_].inertia &&
                   sensors_on_the_way(values).empty() && fe::BatchSolver::serves(*model_, *run.layers, *run.variations);
        }
        return false;
    }
    std::vector<Outcome<Reading>> run_together(std::span<const Run> runs, Workspace& workspace) const override {
        std::vector<std::optional<Outcome<Reading>>> readings(runs.size());
        if constexpr (is_axisymmetric) {
            for (std::size_t i = 0; i < runs.size(); ++i) {
                if (readings[i]) {
                    continue;
                }
                std::vector<std::size_t> alike;
                for (std::size_t j = i; j < runs.size(); ++j) {
                    if (!readings[j] && are_alike(runs[i], runs[j])) {
                        alike.push_back(j);
                    }
                }
                follow_in_lanes(runs, alike, static_cast<Own&>(workspace), readings);
            }
        }
        std::vector<Outcome<Reading>> all;
        for (auto& reading : readings) {
            all.push_back(std::move(*reading));
        }
        return all;
    }

    Outcome<Fields> fields(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                           Workspace& workspace) const override {
        const Load& load = values.loads[load_];
        Own& own = static_cast<Own&>(workspace);
        if (!own.fit(*this, values)) {
            return does_not_fit;
        }
        const Eigen::VectorXd force = load.pressure * load.factor * own.unit_load;
        if (subspace_) {
            return Failure{Status::failed, "a reduced model knows readings, not fields"};
        }
        if (load.is_pulse()) {
            const auto marched = own.geometry->solver->pulse(layers, force, pulse_of(values, load_), {}, {},
                                                             values.settings.solver, spring_stiffness(values));
            return marched ? Outcome<Fields>(fields_of(*own.geometry->model, layers, marched->at_largest))
                           : marched.failure();
        }
        if (values.relaxes()) {
            const auto relaxed =
                own.geometry->solver->over_time(layers, force, fe::haversine(load.duration, relaxing_steps), {}, {},
                                                values.settings.solver, spring_stiffness(values));
            return relaxed ? Outcome<Fields>(fields_of(*own.geometry->model, layers, relaxed->at_largest))
                           : relaxed.failure();
        }
        const auto solved = solve(values, layers, force, {}, {}, {}, own);
        if (!solved) {
            return solved.failure();
        }
        return fields_of(*own.geometry->model, layers, solved.value());
    }

private:
    struct Geometry;
    struct Own;
    static constexpr bool is_axisymmetric = std::is_same_v<Kind, Axisymmetric>;

    // Whether two runs have one mesh and the same variations.
    bool are_alike(const Run& a, const Run& b) const {
        return lines_at(*a.values) == lines_at(*b.values) &&
               a.values->settings.solver.load_steps == b.values->settings.solver.load_steps &&
               std::equal(a.variations->begin(), a.variations->end(), b.variations->begin(), b.variations->end(),
                          [](const fe::Variation& v, const fe::Variation& w) {
                              return v.kind == w.kind && v.layer == w.layer && v.index == w.index;
                          });
    }
    // Runs that are alike.
    void follow_in_lanes(std::span<const Run> runs, const std::vector<std::size_t>& numbers, Own& own,
                         std::vector<std::optional<Outcome<Reading>>>& readings) const {
        std::vector<Eigen::VectorXd> forces;
        std::vector<std::vector<fe::Functional<fe::AxisymmetricQ8>>> read;
        std::vector<std::size_t> fitting;
        for (const std::size_t i : numbers) {
            const Case& values = *runs[i].values;
            const Load& load = values.loads[load_];
            if (!own.fit(*this, values)) {
                readings[i] = does_not_fit;
                continue;
            }
            fitting.push_back(i);
            forces.push_back(load.pressure * load.factor * own.unit_load);
            read.push_back(functionals(values, own));
        }
        std::vector<fe::BatchRun> batch;
        for (std::size_t k = 0; k < fitting.size(); ++k) {
            batch.push_back({runs[fitting[k]].layers, &forces[k], &read[k]});
        }
        if (batch.empty()) {
            return;
        }
        Geometry& g = *own.geometry;
        if (!g.batch) {
            g.batch = std::make_unique<fe::BatchSolver>(*g.model);
        }
        const Run& first = runs[fitting[0]];
        const auto followed = g.batch->incremental(batch, *first.variations, first.values->settings.solver);
        for (std::size_t k = 0; k < fitting.size(); ++k) {
            if (!followed[k]) {
                readings[fitting[k]] = followed[k].failure();
                continue;
            }
            const fe::Course& at_rest = followed[k]->at_rest;
            if (!at_rest.values.allFinite()) {
                readings[fitting[k]] = not_finite;
                continue;
            }
            const Case& values = *runs[fitting[k]].values;
            Reading reading;
            reading.values.resize(values.sensors.size());
            reading.derivatives.setZero(static_cast<Eigen::Index>(values.sensors.size()), at_rest.d_values[0].cols());
            reading.statistics = followed[k]->statistics;
            const std::vector<std::size_t> sensors = sensors_of(values);
            for (std::size_t r = 0; r < sensors.size(); ++r) {
                const auto row = static_cast<Eigen::Index>(r);
                reading.values[sensors[r]] = at_rest.values(row, 0);
                reading.derivatives.row(static_cast<Eigen::Index>(sensors[r])) = at_rest.d_values[0].row(row);
            }
            readings[fitting[k]] = std::move(reading);
        }
    }

    // The model of one of the others whose mesh is this one's; none.
    std::shared_ptr<const fe::Model<Element>> model_among(const LoadModels& others) const {
        for (const auto& other : others) {
            const auto* like = dynamic_cast<const LoadModelOf*>(other.get());
            if (like != nullptr && like->is_pulse_ == is_pulse_ && like->springs_ == springs_ &&
                Kind::lines_of(like->mesh_) == Kind::lines_of(mesh_)) {
                return like->model_;
            }
        }
        return nullptr;
    }

    Outcome<fe::Solution<Element>> solve(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                                         const Eigen::VectorXd& force, const std::vector<fe::Variation>& by,
                                         const std::vector<fe::Motion<Element>>& motions,
                                         const std::vector<double>& on_the_way, Own& own) const {
        const auto& settings = values.settings.solver;
        const std::vector<double> springs = spring_stiffness(values);
        const bool as_secant = values.settings.integration == Integration::secant;
        if (values.is_hyperelastic()) {
            // Inertia asks for the tangent at the end of a path.
            return values.loads[load_].inertia
                       ? own.geometry->solver->incremental(layers, force, by, settings, springs, motions)
                       : own.geometry->solver->hyperelastic(layers, force, by, settings, springs, motions);
        }
        if (as_secant && values.has_energy()) {
            return energy_beside_secant;
        }
        return as_secant ? own.geometry->solver->secant(layers, force, by, settings, springs, motions)
                         : own.geometry->solver->incremental(layers, force, by, settings, springs, motions, on_the_way);
    }

    // The sensors that this model reads.
    std::vector<std::size_t> sensors_of(const Case& values) const {
        std::vector<std::size_t> own;
        for (std::size_t i = 0; i < values.sensors.size(); ++i) {
            if (values.sensors[i].load == load_) {
                own.push_back(i);
            }
        }
        return own;
    }

    // Those of lighter loads that lie on its path.
    std::vector<std::size_t> sensors_on_the_way(const Case& values) const {
        std::vector<std::size_t> lighter;
        for (std::size_t i = 0; i < values.sensors.size(); ++i) {
            if (values.sensors[i].load != load_ && is_read(values.sensors[i])) {
                lighter.push_back(i);
            }
        }
        return lighter;
    }
    bool is_read(const Sensor& sensor) const { return path_of_[static_cast<std::size_t>(sensor.load)] == load_; }

    std::vector<fe::Functional<Element>> functionals(const Case& values, const Own& own) const {
        std::vector<fe::Functional<Element>> list;
        for (const std::size_t i : sensors_of(values)) {
            list.push_back(own.observations[i]);
        }
        return list;
    }

    // The same, and behind them for each motion of the mesh what the places that are read move by.
    std::vector<fe::Functional<Element>>
    with_moved(const Case& values, const std::vector<std::vector<Observation<Element>>>& observation_rates,
               const Own& own) const {
        std::vector<fe::Functional<Element>> list = functionals(values, own);
        for (const auto& rates : observation_rates) {
            for (const std::size_t i : sensors_of(values)) {
                list.push_back(rates[i]);
            }
        }
        return list;
    }
    // Takes those further rows of a course into the derivatives of the readings.
    static void add_moved(const std::vector<fe::Variation>& by, std::size_t motions, fe::Course& course) {
        const Eigen::Index readings = course.values.rows() / static_cast<Eigen::Index>(1 + motions);
        for (std::size_t instant = 0; instant < course.d_values.size(); ++instant) {
            Eigen::MatrixXd& rates = course.d_values[instant];
            const auto values = course.values.col(static_cast<Eigen::Index>(instant));
            for (std::size_t k = 0; k < by.size(); ++k) {
                if (by[k].kind == fe::Variation::Kind::motion) {
                    rates.col(static_cast<Eigen::Index>(k)).head(readings) +=
                        values.segment(static_cast<Eigen::Index>(1 + by[k].index) * readings, readings);
                }
            }
            rates.conservativeResize(readings, Eigen::NoChange);
        }
        course.values.conservativeResize(readings, Eigen::NoChange);
    }

    // The sensors over the time of the load, as the section and the load ask for. Fails where one reads no number.
    Outcome<Responses> follow(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                              const Eigen::VectorXd& force, const std::vector<fe::Variation>& by,
                              const std::vector<fe::Motion<Element>>& motions,
                              const std::vector<std::vector<Observation<Element>>>& observation_rates, Own& own) const {
        Responses responses;
        if (values.loads[load_].is_pulse()) {
            auto& solver = *own.geometry->solver;
            const auto march = [&](const fe::Pulse& pulse, const std::vector<fe::Functional<Element>>& readings,
                                   const std::vector<fe::Variation>& variations) {
                return solver.pulse(layers, force, pulse, readings, variations, values.settings.solver,
                                    spring_stiffness(values), motions, subspace_ ? &*subspace_ : nullptr);
            };
            const fe::Pulse pulse = pulse_of(values, load_);
            std::optional<fe::Course> coarse; // a reduced model is judged by the full one
            if (!subspace_) {
                auto outcome = march(coarser(pulse), functionals(values, own), {});
                if (!outcome) {
                    return outcome.failure();
                }
                coarse = std::move(std::move(outcome).value().course);
            }
            solver.on_march(own.on_march);
            auto outcome = march(pulse, with_moved(values, observation_rates, own), by);
            solver.on_march({});
            if (!outcome) {
                return outcome.failure();
            }
            auto fine = std::move(outcome).value();
            add_moved(by, observation_rates.size(), fine.course);
            responses.statistics = fine.at_largest.statistics;
            if (coarse) {
                responses.statistics.time_error = time_error(values, fine.course, *coarse);
            }
            responses.moving = std::move(fine.course);
        } else if (values.relaxes()) {
            const fe::History history = fe::haversine(values.loads[load_].duration, relaxing_steps);
            auto outcome =
                own.geometry->solver->over_time(layers, force, history, with_moved(values, observation_rates, own), by,
                                                values.settings.solver, spring_stiffness(values), motions);
            if (!outcome) {
                return outcome.failure();
            }
            auto relaxed = std::move(outcome).value();
            add_moved(by, observation_rates.size(), relaxed.course);
            const std::size_t largest = history.largest();
            responses.statistics = relaxed.at_largest.statistics;
            responses.moving = std::move(relaxed.course);
            responses.at_rest = fe::Course(responses.moving.values.col(static_cast<Eigen::Index>(largest)),
                                           responses.moving.d_values[largest]);
            responses.slow = responses.at_rest;
        } else {
            const auto lighter = sensors_on_the_way(values);
            std::vector<double> load_factors;
            load_factors.reserve(lighter.size());
            for (const std::size_t i : lighter) {
                load_factors.push_back(values.loads[static_cast<std::size_t>(values.sensors[i].load)].pressure /
                                       values.loads[load_].pressure);
            }
            const auto solved = solve(values, layers, force, by, motions, load_factors, own);
            if (!solved) {
                return solved.failure();
            }
            for (std::size_t r = 0; r < lighter.size(); ++r) {
                const auto& there = solved->on_the_way[r];
                const auto& o = own.observations[lighter[r]];
                fe::Followed read{o.of_displacement(there.displacement.data()), Eigen::RowVectorXd(by.size())};
                for (Eigen::Index k = 0; k < read.rates.size(); ++k) {
                    read.rates[k] = o.of_displacement(there.d_displacement.col(k).data());
                }
                responses.on_the_way.emplace_back(lighter[r], std::move(read));
            }
            responses.statistics = solved->statistics;
            responses.at_rest = course_at_rest(values, solved.value(), by, observation_rates, own);
            responses.moving = responses.slow = responses.at_rest;
            if (values.loads[load_].inertia) {
                if (const auto failure = move_with_inertia(values, solved.value(), force, own, responses)) {
                    return *failure;
                }
            }
        }
        const bool finite = responses.at_rest.values.allFinite() && responses.moving.values.allFinite();
        return finite ? Outcome<Responses>(std::move(responses)) : not_finite;
    }

    // The error of the readings of a pulse in its steps, of the largest of their kind, by those in steps twice as long:
    // of second order, it is a third of the difference.
    double time_error(const Case& values, const fe::Course& fine, const fe::Course& coarse) const {
        const std::vector<std::size_t> sensors = sensors_of(values);
        const Load& load = values.loads[load_];
        const double step = values.settings.time_step;
        std::map<Quantity, std::pair<double, double>> of_kind; // largest difference, largest reading
        for (std::size_t r = 0; r < sensors.size(); ++r) {
            const Sensor& sensor = values.sensors[sensors[r]];
            const auto row = static_cast<Eigen::Index>(r);
            const double value = read_pulse(sensor, load, fine, row, step, {}).value;
            const double other = read_pulse(sensor, load, coarse, row, 2.0 * step, {}).value;
            auto& [difference, largest] = of_kind[sensor.quantity];
            difference = std::max(difference, std::abs(value - other));
            largest = std::max(largest, std::abs(value));
        }
        double error = 0.0;
        for (const auto& [kind, of] : of_kind) {
            error = of.second > 0.0 ? std::max(error, of.first / (3.0 * of.second)) : error;
        }
        return error;
    }

    // One instant: the sensors under the load at rest.
    fe::Course course_at_rest(const Case& values, const fe::Solution<Element>& solved,
                              const std::vector<fe::Variation>& by,
                              const std::vector<std::vector<Observation<Element>>>& observation_rates,
                              const Own& own) const {
        const std::vector<std::size_t> sensors = sensors_of(values);
        const auto count = static_cast<Eigen::Index>(by.size());
        fe::Course course(static_cast<Eigen::Index>(sensors.size()), 1, count, false);
        for (std::size_t r = 0; r < sensors.size(); ++r) {
            const auto row = static_cast<Eigen::Index>(r);
            const auto& o = own.observations[sensors[r]];
            const bool stress = !o.on_stress.empty();
            course.values(row, 0) =
                stress ? o.of_stress(solved.stress, 1, 0) : o.of_displacement(solved.displacement.data());
            for (Eigen::Index k = 0; k < count; ++k) {
                double& rate = course.d_values[0](row, k);
                rate = stress ? o.of_stress(solved.d_stress, count, k)
                              : o.of_displacement(solved.d_displacement.col(k).data());
                const fe::Variation& v = by[static_cast<std::size_t>(k)];
                if (v.kind == fe::Variation::Kind::motion) { // the place in the mesh that is read moves too
                    const auto& moved = observation_rates[v.index][sensors[r]];
                    rate += stress ? moved.of_stress(solved.stress, 1, 0)
                                   : moved.of_displacement(solved.displacement.data());
                }
            }
        }
        return course;
    }

    // The answer of mass and damping to a pulse, about the end of a load path. What no instrument measures is read at
    // rest.
    std::optional<Failure> move_with_inertia(const Case& values, const fe::Solution<Element>& solved,
                                             const Eigen::VectorXd& force, Own& own, Responses& responses) const {
        const Load& load = values.loads[load_];
        const std::vector<std::size_t> sensors = sensors_of(values);
        fe::Inertia inertia;
        inertia.factor = *load.inertia;
        inertia.delay = damping_ratio * load.duration / std::numbers::pi;
        for (const std::size_t i : sensors) {
            if (values.sensors[i].measured) {
                inertia.reach = std::max(inertia.reach, std::hypot(values.sensors[i].x, values.sensors[i].y));
            }
        }
        auto followed = own.geometry->solver->inertial(solved, force, fe::haversine(load.duration, moving_steps),
                                                       inertia, functionals(values, own));
        if (!followed) {
            return followed.failure();
        }
        responses.moving = std::move(followed->moving);
        responses.slow = std::move(followed->at_rest);
        for (std::size_t r = 0; r < sensors.size(); ++r) {
            if (!values.sensors[sensors[r]].measured) {
                keep_at_rest(responses.moving, static_cast<Eigen::Index>(r));
                keep_at_rest(responses.slow, static_cast<Eigen::Index>(r));
            }
        }
        return std::nullopt;
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

    // Where the mesh stands, for all loads on it.
    struct Geometry {
        Lines lines;
        typename Kind::Mesh mesh;
        std::unique_ptr<fe::Model<Element>> model;
        std::unique_ptr<fe::Solver<Element>> solver;
        std::unique_ptr<fe::BatchSolver> batch; // made when first needed
        int moves = 0;
    };

    struct Own : Workspace {
        std::shared_ptr<Geometry> geometry;
        int moves = 0;               // of the geometry, when the rest was made
        double pressure_shape = 0.0; // of unit_load
        Eigen::VectorXd unit_load;   // pressure 1 Pa
        std::vector<Sensor> sensors; // of the observations
        std::vector<Observation<Element>> observations;
        fe::OnMarch on_march;

        // d(unit_load)/d(pressure_shape): the pressure is linear in it.
        Eigen::VectorXd unit_load_rate(Load load) const {
            load.pressure_shape += 1.0;
            return Kind::unit_load(geometry->mesh, *geometry->model, load) - unit_load;
        }

        // False: the load does not fit into the mesh of this geometry.
        bool fit(const LoadModelOf& of, const Case& values) {
            const std::optional<Lines> wanted = of.lines_at(values);
            if (!wanted) {
                return false;
            }
            const Load& load = values.loads[of.load_];
            Geometry& g = *geometry;
            if (*wanted != g.lines) {
                g.lines = *wanted;
                g.mesh = Kind::mesh_of(*wanted, values, of.load_);
                auto moved = std::make_unique<fe::Model<Element>>(
                    fe::make_model(g.mesh, *of.model_, springs_of(values, of.load_)));
                if (g.solver == nullptr) {
                    g.solver = std::make_unique<fe::Solver<Element>>(*moved);
                } else {
                    g.solver->move(*moved);
                }
                if constexpr (is_axisymmetric) {
                    if (g.batch) {
                        g.batch->move(*moved);
                    }
                }
                g.model = std::move(moved);
                ++g.moves;
            }
            const bool has_moved = std::exchange(moves, g.moves) != g.moves;
            if (has_moved || load.pressure_shape != pressure_shape) {
                unit_load = Kind::unit_load(g.mesh, *g.model, load);
                pressure_shape = load.pressure_shape;
            }
            if (has_moved || sensors != values.sensors) {
                sensors = values.sensors;
                observations.clear();
                for (const Sensor& sensor : sensors) {
                    observations.push_back(of.is_read(sensor)
                                               ? observe(sensor, g.mesh, *g.model, g.mesh, of.incompressible_)
                                               : Observation<Element>{});
                }
            }
            return true;
        }
    };

    // None: the load does not fit into the mesh of this geometry.
    std::optional<Lines> lines_at(const Case& values) const {
        const Lines breaks = Kind::breaks(values, load_);
        for (const auto& along : breaks) {
            if (!std::is_sorted(along.begin(), along.end(), std::less_equal<>())) {
                return std::nullopt;
            }
        }
        return lines_for(breaks);
    }
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
        motion.points.resize(model_->points.size());
        for (auto& point : motion.points) {
            point.rows.setZero();
        }
        motion.vertical_stress.assign(model_->points.size(), 0.0);
        motion.load = Eigen::VectorXd::Zero(model_->free_unknowns());
        std::vector<Observation<Element>> rates(values.sensors.size());
        for (const auto& [weight, there] : near) {
            const auto mesh = Kind::mesh_of(lines_for(Kind::breaks(there, load_)), there, load_);
            auto model = fe::make_model(mesh, *model_);
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
                const auto o = observe(values.sensors[i], mesh, model, own.geometry->mesh, incompressible_);
                for (const auto& [unknown, part] : o.on_displacement) {
                    rates[i].on_displacement.emplace_back(unknown, weight * part);
                }
                for (const auto& [point, part, direction] : o.on_stress) {
                    rates[i].on_stress.push_back({point, weight * part, direction});
                }
            }
            if (is_pulse_) {
                motion.beside.emplace_back(weight, std::move(model));
            }
        }
        return {std::move(motion), std::move(rates)};
    }

    int load_;
    Lines breaks_;
    typename Kind::Mesh mesh_;
    fe::Springs springs_;
    bool is_pulse_;                                   // the sides of its mesh are open
    std::shared_ptr<const fe::Model<Element>> model_; // nominal; loads on one mesh have one
    std::vector<bool> incompressible_;                // layers
    std::vector<int> path_of_;                        // path_of_each()
    std::optional<fe::Subspace> subspace_;
};

} // namespace

std::vector<double> with_far_cells(std::vector<double> lines, const Case& c, int load, int doublings) {
    if (c.half_space && !c.loads[load].is_pulse()) {
        for (int i = 0; i < doublings; ++i) {
            lines.push_back(2.0 * lines.back());
        }
        lines.push_back(3.0 * lines.back());
    }
    return lines;
}

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
        m.damping_time = layer.damping_time;
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

namespace {

bool takes_layers(const Case& nominal, int number) {
    return (nominal.settings.layered || nominal.loads[number].type == LoadType::gear) &&
           why_not_layered(nominal, number).empty();
}

void check_on_mesh(const Case& nominal, int number, const Place& place) {
    const Load& load = nominal.loads[number];
    const auto footprint = load.footprint();
    const double reach = std::max(footprint.outer(), footprint.half_y);
    if (!(reach < nominal.settings.extent)) {
        throw Error({place.file, place.line, "mesh.extent_m"},
                    "the load \"" + load.name + "\" does not fit into the mesh",
                    fmt::format("{}", nominal.settings.extent), fmt::format("more than its reach of {:.4g} m", reach));
    }
    if (footprint.centre > 0.0 && footprint.inner() < -1e-9 * footprint.half_x) {
        throw Error({place.file, place.line, load.name + ".spacing_mm"}, "the two patches of the dual wheel overlap",
                    fmt::format("{:g}", load.spacing / unit::mm),
                    fmt::format("at least the width of a patch, {:.4g} mm", 2.0 * footprint.half_x / unit::mm));
    }
}

} // namespace

void check_load(const Case& nominal, int number, const Place& place) {
    const Load& load = nominal.loads[number];
    const std::string why_not = why_not_layered(nominal, number);
    if (load.type == LoadType::gear && !why_not.empty()) {
        throw Error({place.file, place.line, load.name + ".type"}, "a gear stands on linear layers only", why_not,
                    "law = \"linear\" in every layer, or one of its wheels as a load");
    }
    if (!takes_layers(nominal, number)) {
        check_on_mesh(nominal, number, place);
    } else if (load.circles_overlap()) {
        const double wide = 2.0 * load.circles()[0].radius / unit::mm;
        const bool is_gear = load.type == LoadType::gear;
        throw Error({place.file, place.line, load.name + (is_gear ? ".wheels" : ".spacing_mm")},
                    "the patches of the load overlap",
                    is_gear ? std::string() : fmt::format("{:g}", load.spacing / unit::mm),
                    fmt::format("wheels at least {:.4g} mm apart, or a higher pressure", wide));
    }
}

std::unique_ptr<const LoadModel> make_load_model(const Case& nominal, int number, const LoadModels& others) {
    check_load(nominal, number, {});
    return takes_layers(nominal, number) ? make_layered_model(nominal, number)
                                         : make_finite_element_model(nominal, number, others);
}

std::unique_ptr<const LoadModel> make_finite_element_model(const Case& nominal, int number, const LoadModels& others) {
    const Load& load = nominal.loads[number];
    check_on_mesh(nominal, number, {});
    if (load.is_axisymmetric()) {
        return std::make_unique<LoadModelOf<Axisymmetric>>(nominal, number, others);
    }
    return std::make_unique<LoadModelOf<Solid>>(nominal, number, others);
}

std::unique_ptr<const LoadModel> make_pulse_model(const Case& nominal, int number, fe::Subspace subspace) {
    if (nominal.loads[number].is_axisymmetric()) {
        return std::make_unique<LoadModelOf<Axisymmetric>>(nominal, number, LoadModels{}, std::move(subspace));
    }
    return std::make_unique<LoadModelOf<Solid>>(nominal, number, LoadModels{}, std::move(subspace));
}

} // namespace pave::pavement
