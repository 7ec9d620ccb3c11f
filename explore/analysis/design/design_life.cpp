#include "analysis/design/design_life.h"

#include "base/error.h"
#include "pavement/forward.h"
#include "pavement/layered.h"
#include "pavement/tie.h"
#include "study/pavement_function.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace explore::analysis {
namespace {

using namespace pave::pavement;
using Eigen::Index;
using Eigen::VectorXd;

// A strain below this [microstrain] counts as this, so that a walk over sets goes on where tension turns to pressure.
constexpr double least_strain = 1.0;
constexpr double above_bottom = 1e-5; // m: at an interface the layer below is read

struct Point {
    double x = 0.0, y = 0.0; // m
};

// Under the wheels, at their edges, between them. few: where strains change over the thickness of a thin layer, every
// place costs a fine mesh.
std::vector<Point> places_under(const Load& load, bool few) {
    if (load.type == LoadType::gear) {
        std::vector<Point> points;
        for (const Load::Wheel& w : load.wheels) {
            points.push_back({w.x, w.y});
            for (const Load::Wheel& other : load.wheels) {
                constexpr double near = 2.0; // m: farther wheels add little to each other
                if (&other > &w && std::hypot(other.x - w.x, other.y - w.y) < near) {
                    points.push_back({(w.x + other.x) / 2.0, (w.y + other.y) / 2.0});
                }
            }
        }
        return points;
    }
    const Load::Footprint f = load.footprint();
    std::vector<double> list{f.centre};
    if (f.centre > 0.0) {
        list.insert(list.end(), {0.0, f.inner()});
    }
    if (!few) {
        list.insert(list.end(), {f.outer(), (f.centre + f.outer()) / 2.0});
        if (f.centre > 0.0) {
            // The largest tension of two wheels lies between a wheel's middle and its inner edge.
            const double edge = f.inner();
            list.insert(list.end(), {edge / 2.0, edge + (f.centre - edge) / 4.0, (edge + f.centre) / 2.0,
                                     f.centre - (f.centre - edge) / 4.0});
        }
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    std::vector<Point> points;
    for (const double x : list) {
        points.push_back({x, 0.0});
    }
    return points;
}

} // namespace

CriticalPlaces critical_places(study::Study study, const std::vector<study::Criterion>& criteria) {
    CriticalPlaces places;
    places.first = study.readings.size();
    const auto add = [&](const study::Criterion& criterion, Quantity quantity, Point at, double depth) {
        const auto load = static_cast<int>(criterion.load);
        for (std::size_t i = places.first; i < study.readings.size(); ++i) {
            const Sensor& s = study.model.sensors[i];
            if (s.load == load && s.quantity == quantity && s.x == at.x && s.y == at.y && s.depth == depth) {
                return i;
            }
        }
        Sensor sensor;
        sensor.load = load;
        sensor.quantity = quantity;
        sensor.x = at.x;
        sensor.y = at.y;
        sensor.depth = depth;
        sensor.measured = false;
        check_sensor(study.model, sensor, {.file = study.file, .line = criterion.line, .key = criterion.name});
        data::Reading reading;
        reading.load = study.model.loads[criterion.load].name;
        reading.quantity = info(quantity).name;
        reading.x_mm = 1e3 * at.x;
        reading.y_mm = 1e3 * at.y;
        reading.depth_mm = 1e3 * depth;
        reading.unit = data::unit_named(info(quantity).unit);
        reading.output = fmt::format("{} {:g},{:g},{:g} {}", reading.load, reading.x_mm, reading.y_mm, reading.depth_mm,
                                     reading.quantity);
        study.model.sensors.push_back(sensor);
        study.hash += "+" + reading.output;
        study.readings.push_back(std::move(reading));
        return study.readings.size() - 1;
    };
    for (const study::Criterion& criterion : criteria) {
        const Load& load = study.model.loads[criterion.load];
        const bool is_meshed =
            !study.model.settings.layered || !why_not_layered(study.model, static_cast<int>(criterion.load)).empty();
        std::vector<std::size_t> own;
        switch (criterion.place) {
        case CriticalPlace::plate:
            own = {add(criterion, Quantity::deflection, {}, 0.0),
                   add(criterion, Quantity::deflection, {1e-3 * criterion.options.back(), 0.0}, 0.0)};
            break;
        case CriticalPlace::asphalt_bottom:
            for (const Point& at : places_under(load, is_meshed)) {
                for (const Quantity quantity : {Quantity::strain_xx, Quantity::strain_yy}) {
                    own.push_back(add(criterion, quantity, at, criterion.depth(study.model) - above_bottom));
                }
            }
            break;
        case CriticalPlace::subgrade_top:
            for (const Point& at : places_under(load, load.is_axisymmetric())) {
                own.push_back(add(criterion, Quantity::strain_zz, at, criterion.depth(study.model)));
            }
            break;
        }
        places.candidates.push_back(std::move(own));
    }
    places.count = study.readings.size() - places.first;
    places.seasons = study::seasons_of(study);
    for (const study::Season& season : places.seasons) {
        study.hash += "+" + season.name;
        for (const double factor : season.factors) {
            study.hash += fmt::format(" {:.17g}", factor);
        }
        for (std::size_t i = 0; i < places.count; ++i) {
            study.model.sensors.push_back(study.model.sensors[places.first + i]);
            study.readings.push_back(study.readings[places.first + i]);
            study.readings.back().output += ", " + season.name;
        }
    }
    places.study = std::move(study);
    return places;
}

namespace {

// The responses of a study with critical places: those of the seasons by runs with other layers.
class SeasonalFunction final : public problem::ForwardFunction {
public:
    SeasonalFunction(std::shared_ptr<const problem::ForwardFunction> as_read, const CriticalPlaces& places)
        : first_(places.in_season(places.first, 0)),
          count_(places.count) {
        states_.push_back({std::move(as_read), {}});
        Case model = places.study.model;
        model.sensors.resize(first_);
        model.sensors.erase(model.sensors.begin(), model.sensors.begin() + static_cast<std::ptrdiff_t>(places.first));
        std::vector<bool> loads(model.loads.size(), false);
        for (const Sensor& sensor : model.sensors) {
            loads[static_cast<std::size_t>(sensor.load)] = true;
        }
        for (const study::Season& season : places.seasons) {
            Case then = model;
            study::soften(then, season);
            states_.push_back({study::make_function(then, places.study.parameters, loads),
                               study::parameter_factors(places.study, season)});
        }
    }

    std::unique_ptr<Workspace> make_workspace() const override {
        auto workspace = std::make_unique<Own>();
        for (const State& state : states_) {
            workspace->own.push_back(state.function->make_workspace());
        }
        return workspace;
    }

    pave::Outcome<problem::Prediction> evaluate(std::span<const double> parameters, bool with_jacobian,
                                                Workspace& workspace) const override {
        auto& own = static_cast<Own&>(workspace).own;
        auto outcome = states_[0].function->evaluate(parameters, with_jacobian, *own[0]);
        if (!outcome) {
            return outcome.failure();
        }
        problem::Prediction all = std::move(outcome).value();
        for (std::size_t s = 1; s < states_.size(); ++s) {
            std::vector<double> then(parameters.begin(), parameters.end());
            for (std::size_t k = 0; k < then.size(); ++k) {
                then[k] *= states_[s].factors[k];
            }
            auto of_season = states_[s].function->evaluate(then, with_jacobian, *own[s]);
            if (!of_season) {
                return of_season.failure();
            }
            const problem::Prediction part = std::move(of_season).value();
            const std::size_t begin = first_ + (s - 1) * count_;
            std::copy(part.responses.begin(), part.responses.end(),
                      all.responses.begin() + static_cast<std::ptrdiff_t>(begin));
            for (std::size_t k = 0; with_jacobian && k < then.size(); ++k) {
                const auto column = static_cast<Index>(k);
                all.jacobian.col(column).segment(static_cast<Index>(begin), static_cast<Index>(count_)) =
                    states_[s].factors[k] * part.jacobian.col(column);
            }
        }
        return all;
    }

private:
    struct Own : Workspace {
        std::vector<std::unique_ptr<Workspace>> own;
    };
    struct State {
        std::shared_ptr<const problem::ForwardFunction> function;
        std::vector<double> factors; // on the parameters
    };
    std::size_t first_, count_; // where the responses of the first season begin; how many a season has
    std::vector<State> states_; // as read, then the seasons
};

} // namespace

problem::Problem seasonal(problem::Problem problem, const CriticalPlaces& places) {
    if (!places.seasons.empty()) {
        problem.function = std::make_shared<SeasonalFunction>(problem.function, places);
    }
    return problem;
}

Life::Life(const CriticalPlaces& places, const study::Criterion& criterion, std::vector<std::size_t> candidates)
    : places_(places),
      study_(places.study),
      criterion_(criterion),
      candidates_(std::move(candidates)) {}

std::size_t Life::critical(const Case& at, const std::vector<double>& responses) const {
    if (criterion_.place == CriticalPlace::plate) {
        return candidates_[0];
    }
    const auto strained_less = [&](std::size_t a, std::size_t b) {
        return strain(a, responses) < strain(b, responses);
    };
    if (places_.seasons.empty()) {
        return *std::max_element(candidates_.begin(), candidates_.end(), strained_less);
    }
    return *std::max_element(candidates_.begin(), candidates_.end(), [&](std::size_t a, std::size_t b) {
        const double life_a = log_repetitions(a, at, responses);
        const double life_b = log_repetitions(b, at, responses);
        return life_a != life_b ? life_a > life_b : strained_less(a, b);
    });
}

double Life::strain(std::size_t candidate, const std::vector<double>& responses) const {
    switch (criterion_.place) {
    case CriticalPlace::asphalt_bottom: return -1e6 * responses[candidate];
    case CriticalPlace::subgrade_top: return 1e6 * responses[candidate];
    case CriticalPlace::plate: break;
    }
    return std::numeric_limits<double>::quiet_NaN();
}

double Life::modulus(const Case& at) const {
    if (criterion_.modulus_MPa || !criterion_.reads_modulus()) {
        return criterion_.modulus_MPa.value_or(0.0);
    }
    return find_parameter(at, at.layers[criterion_.layer].name + ".modulus_MPa", {}).get(at);
}

double Life::log_repetitions_of(std::size_t candidate, std::size_t strained, double softer, const Case& at,
                                const std::vector<double>& responses) const {
    if (criterion_.place != CriticalPlace::plate) {
        return criterion_.log_repetitions(
            {.strain = std::max(strain(strained, responses), least_strain), .modulus_MPa = softer * modulus(at)});
    }
    const Load& load = at.loads[criterion_.load];
    return criterion_.log_repetitions({.centre_mm = 1e3 * responses[strained],
                                       .far_mm = 1e3 * responses[candidates_[1] + (strained - candidate)],
                                       .distance_mm = criterion_.options.back(),
                                       .pressure_kPa = 1e-3 * load.pressure * load.factor,
                                       .radius_mm = 1e3 * load.radius,
                                       .cover_mm = 1e3 * criterion_.depth(at)});
}

double Life::log_repetitions(std::size_t candidate, const Case& at, const std::vector<double>& responses) const {
    if (places_.seasons.empty()) {
        return log_repetitions_of(candidate, candidate, 1.0, at, responses);
    }
    double damage = 0.0; // of a repetition
    for (std::size_t s = 0; s < places_.seasons.size(); ++s) {
        const study::Season& season = places_.seasons[s];
        const double log_life = log_repetitions_of(candidate, places_.in_season(candidate, s),
                                                   season.factors[criterion_.layer], at, responses);
        damage += season.share * std::exp(-log_life);
    }
    return -std::log(damage);
}

double Life::log_repetitions(std::size_t candidate, const Case& at, std::vector<double> responses, double ratio) const {
    for (const std::size_t r : reads(candidate)) {
        responses[r] *= ratio;
    }
    return log_repetitions(candidate, at, responses);
}

std::vector<std::size_t> Life::reads(std::size_t candidate) const {
    const std::vector<std::size_t> as_read =
        criterion_.place == CriticalPlace::plate ? candidates_ : std::vector<std::size_t>{candidate};
    std::vector<std::size_t> list = as_read;
    for (std::size_t s = 0; s < places_.seasons.size(); ++s) {
        for (const std::size_t r : as_read) {
            list.push_back(places_.in_season(r, s));
        }
    }
    return list;
}

Case Life::at(const std::vector<double>& parameters) const {
    const auto c = study::case_at(study_.model, study_.parameters, parameters);
    return c ? *c : study_.model;
}

VectorXd Life::gradient(std::size_t candidate, const std::vector<double>& unit, const problem::Evaluation& e) const {
    constexpr double share = 1e-5; // of a number: central differences of closed forms, to some 1e-9
    const Case here = at(e.parameters);
    VectorXd by_physical = VectorXd::Zero(static_cast<Index>(unit.size()));
    std::vector<double> responses = e.responses;
    for (const std::size_t r : reads(candidate)) {
        const double value = responses[r];
        const double step = share * std::max(std::abs(value), 1e-9);
        responses[r] = value + step;
        double slope = log_repetitions(candidate, here, responses);
        responses[r] = value - step;
        slope = (slope - log_repetitions(candidate, here, responses)) / (2.0 * step);
        responses[r] = value;
        by_physical += slope * e.jacobian.row(static_cast<Index>(r)).transpose();
    }
    std::vector<double> moved = e.parameters;
    for (std::size_t k = 0; k < unit.size(); ++k) {
        const problem::Axis& axis = study_.space.axes[k];
        if (criterion_.reads_modulus() && !criterion_.modulus_MPa) {
            const double step = share * std::max(std::abs(moved[k]), 1e-6);
            moved[k] = e.parameters[k] + step;
            double slope = log_repetitions(candidate, at(moved), responses);
            moved[k] = e.parameters[k] - step;
            slope = (slope - log_repetitions(candidate, at(moved), responses)) / (2.0 * step);
            moved[k] = e.parameters[k];
            by_physical[static_cast<Index>(k)] += slope;
        }
        by_physical[static_cast<Index>(k)] *= axis.d_physical(unit[k]);
    }
    return by_physical;
}

} // namespace explore::analysis
