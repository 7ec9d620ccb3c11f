#include "analysis/design_life.h"

#include "base/error.h"
#include "pavement/forward.h"
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
            list.insert(list.end(), {f.inner() / 2.0, (f.inner() + f.centre) / 2.0});
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
        std::vector<std::size_t> own;
        switch (criterion.place) {
        case CriticalPlace::plate:
            own = {add(criterion, Quantity::deflection, {}, 0.0),
                   add(criterion, Quantity::deflection, {1e-3 * criterion.options.back(), 0.0}, 0.0)};
            break;
        case CriticalPlace::asphalt_bottom:
            for (const Point& at : places_under(load, true)) {
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
    places.study = std::move(study);
    return places;
}

Life::Life(const study::Study& study, const study::Criterion& criterion, std::vector<std::size_t> candidates)
    : study_(study),
      criterion_(criterion),
      candidates_(std::move(candidates)) {}

std::size_t Life::critical(const std::vector<double>& responses) const {
    if (criterion_.place == CriticalPlace::plate) {
        return candidates_[0];
    }
    return *std::max_element(candidates_.begin(), candidates_.end(),
                             [&](std::size_t a, std::size_t b) { return strain(a, responses) < strain(b, responses); });
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

double Life::log_repetitions(double strain, const Case& at) const {
    return criterion_.log_repetitions({.strain = std::max(strain, least_strain), .modulus_MPa = modulus(at)});
}

double Life::log_repetitions(std::size_t candidate, const Case& at, const std::vector<double>& responses) const {
    if (criterion_.place != CriticalPlace::plate) {
        return log_repetitions(strain(candidate, responses), at);
    }
    const Load& load = at.loads[criterion_.load];
    return criterion_.log_repetitions({.centre_mm = 1e3 * responses[candidates_[0]],
                                       .far_mm = 1e3 * responses[candidates_[1]],
                                       .distance_mm = criterion_.options.back(),
                                       .pressure_kPa = 1e-3 * load.pressure * load.factor,
                                       .radius_mm = 1e3 * load.radius,
                                       .cover_mm = 1e3 * criterion_.depth(at)});
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
    const std::vector<std::size_t> read =
        criterion_.place == CriticalPlace::plate ? candidates_ : std::vector<std::size_t>{candidate};
    for (const std::size_t r : read) {
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
