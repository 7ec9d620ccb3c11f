// A deflection sensor, or a whole bar of them, stands elsewhere than stated, on every drop.
//
// One sensor stands farther from the load by the size. A layout (`offsets`) moves all sensors of the surface, from the
// distances r_i of the study to r_i + s (o_i - r_i) / max_j |o_j - r_j|, both in order of distance, where s is the
// size: at 0 they stand as stated, at the largest of the moves in the layout.
#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "pavement/buried.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <vector>

namespace pave::pavement {
namespace {

bool is_on_surface(const Sensor& sensor) {
    return sensor.measured && !is_buried(sensor);
}

// The sensor that is named, or the first beside the load.
const Sensor* named(const Case& c, const AppliedEffect& applied) {
    if (applied.reading) {
        const auto reading = static_cast<std::size_t>(*applied.reading);
        return reading < c.sensors.size() && is_on_surface(c.sensors[reading]) ? &c.sensors[reading] : nullptr;
    }
    const auto found = std::find_if(c.sensors.begin(), c.sensors.end(), [](const Sensor& sensor) {
        return is_on_surface(sensor) && (sensor.x != 0.0 || sensor.y != 0.0);
    });
    return found == c.sensors.end() ? nullptr : &*found;
}

constexpr double same = 1e-6; // m

// The distances at which sensors of the surface stand, nearest first; empty where a distance is no place of one sensor:
// they stand on two sides of the load.
std::vector<double> distances(const Case& c) {
    std::vector<std::pair<double, const Sensor*>> places;
    for (const Sensor& sensor : c.sensors) {
        if (is_on_surface(sensor)) {
            places.emplace_back(std::hypot(sensor.x, sensor.y), &sensor);
        }
    }
    std::stable_sort(places.begin(), places.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<double> list;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto& [distance, sensor] = places[i];
        if (i > 0 && distance - list.back() < same) {
            const Sensor& other = *places[i - 1].second;
            if (std::hypot(sensor->x - other.x, sensor->y - other.y) > same) {
                return {};
            }
            continue;
        }
        list.push_back(distance);
    }
    return list;
}

// By how much each distance changes in the layout [m].
std::vector<double> moves(const std::vector<double>& from, const std::vector<double>& to) {
    std::vector<double> list;
    for (std::size_t i = 0; i < from.size(); ++i) {
        list.push_back(to[i] - from[i]);
    }
    return list;
}

double largest_of(const std::vector<double>& moves) {
    double largest = 0.0;
    for (const double move : moves) {
        largest = std::max(largest, std::abs(move));
    }
    return largest;
}

// Away from the load by so much [m]; one under the load moves along x.
void move_away(Sensor& sensor, double by) {
    const double distance = std::hypot(sensor.x, sensor.y);
    const double along_x = distance > 0.0 ? sensor.x / distance : 1.0;
    const double along_y = distance > 0.0 ? sensor.y / distance : 0.0;
    sensor.x += along_x * by;
    sensor.y += along_y * by;
}

void apply_layout(Case& c, const AppliedEffect& applied) {
    const std::vector<double> from = distances(c);
    if (from.size() != applied.offsets.size()) { // another bar
        return;
    }
    const std::vector<double> by = moves(from, applied.offsets);
    const double share = applied.size * unit::mm / largest_of(by);
    for (Sensor& sensor : c.sensors) {
        if (!is_on_surface(sensor)) {
            continue;
        }
        const double distance = std::hypot(sensor.x, sensor.y);
        for (std::size_t i = 0; i < from.size(); ++i) {
            if (std::abs(from[i] - distance) < same) {
                move_away(sensor, share * by[i]);
                break;
            }
        }
    }
}

// One bar carries the sensors of all drops: what is stated at the same place is the same sensor.
void apply(Case& c, const AppliedEffect& applied, int) {
    if (!applied.offsets.empty()) {
        apply_layout(c, applied);
        return;
    }
    const Sensor* own = named(c, applied);
    if (own == nullptr) {
        return;
    }
    const Sensor at = *own;
    for (Sensor& sensor : c.sensors) {
        if (is_on_surface(sensor) && std::abs(sensor.x - at.x) < same && std::abs(sensor.y - at.y) < same) {
            move_away(sensor, applied.size * unit::mm);
        }
    }
}

std::string refuses_layout(const Case& c, const AppliedEffect& applied) {
    if (applied.reading) {
        return "a layout is of all sensors, not of one reading";
    }
    const std::vector<double> from = distances(c);
    if (from.empty()) {
        return "no deflections are measured at distances that are the places of one sensor each";
    }
    if (from.size() != applied.offsets.size()) {
        return fmt::format("the layout has {} sensors, the readings are of {}", applied.offsets.size(), from.size());
    }
    if (!std::is_sorted(applied.offsets.begin(), applied.offsets.end()) || applied.offsets[0] < 0.0) {
        return "the offsets of a layout rise, from 0 or more";
    }
    return largest_of(moves(from, applied.offsets)) < same ? "the sensors stand in that layout already" : "";
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    if (!applied.offsets.empty()) {
        return refuses_layout(c, applied);
    }
    if (named(c, applied) != nullptr) {
        return "";
    }
    return applied.reading ? "the reading is no deflection" : "no deflection is measured beside a load";
}

std::string layout_words(const AppliedEffect& a) {
    std::vector<std::string> places;
    for (const double offset : a.offsets) {
        places.push_back(figure(offset / unit::mm));
    }
    return fmt::format("the sensors stand at {} mm, or that far on the way there: the one that moves most by {} mm",
                       join(places), figure(std::abs(a.size), 3));
}

} // namespace

const Effect& sensor_position() {
    static const Effect effect{
        .name = "sensor-position",
        .unit = "mm",
        .null = 0.0,
        .low = -360.0,
        .high = 360.0,
        .typical = 50.0,
        .mechanism =
            "A sensor was mounted at another hole of the bar than the file says, or slipped: it stands farther from "
            "the load than stated by the size, under every load that it reads. Only its own readings change, by the "
            "slope of the basin there. With offsets_mm the whole bar has another layout: the size is what the sensor "
            "moves that moves most, the others move in proportion.",
        .source =
            "FHWA-RD-03-093 (2006), pavement deflections of LTPP: sensors found one holder off, by 150 to 305 mm, for "
            "days to years",
        .acts_on = "the deflections at the place of the first reading beside a load",
        .takes_reading = true,
        .takes_offsets = true,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            if (!a.offsets.empty()) {
                return layout_words(a);
            }
            return fmt::format("the sensor stands {} mm {} the load than stated", figure(std::abs(a.size), 2),
                               a.size > 0.0 ? "farther from" : "nearer to");
        },
    };
    return effect;
}

} // namespace pave::pavement
