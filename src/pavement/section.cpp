#include "pavement/section.h"

#include "pavement/device.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace pave::pavement {

Load::Footprint Load::footprint() const {
    Footprint f;
    f.shape = patch;
    if (type == LoadType::plate) {
        f.half_x = f.half_y = radius;
        return f;
    }
    const double area = force / pressure / (type == LoadType::dual_wheel ? 2.0 : 1.0);
    f.centre = type == LoadType::dual_wheel ? spacing / 2.0 : 0.0;
    if (patch == Patch::circle) {
        f.half_x = f.half_y = std::sqrt(area / std::numbers::pi);
    } else {
        f.half_x = patch_width / 2.0;
        f.half_y = area / patch_width / 2.0;
    }
    return f;
}

std::vector<Load::Circle> Load::circles() const {
    if (type == LoadType::gear) {
        std::vector<Circle> circles;
        for (const Wheel& wheel : wheels) {
            circles.push_back({wheel.x, wheel.y, std::sqrt(wheel.force / pressure / std::numbers::pi)});
        }
        return circles;
    }
    const Footprint f = footprint();
    if (f.centre > 0.0) {
        return {{f.centre, 0.0, f.half_x}, {-f.centre, 0.0, f.half_x}};
    }
    return {{0.0, 0.0, f.half_x}};
}

bool Load::circles_overlap() const {
    const auto all = circles();
    for (std::size_t i = 0; i < all.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (std::hypot(all[i].x - all[j].x, all[i].y - all[j].y) < all[i].radius + all[j].radius) {
                return true;
            }
        }
    }
    return false;
}

double Load::total_force() const {
    if (type == LoadType::gear) {
        double sum = 0.0;
        for (const Wheel& wheel : wheels) {
            sum += wheel.force;
        }
        return sum;
    }
    return type == LoadType::plate ? pressure * std::numbers::pi * radius * radius : force;
}

double Case::depth() const {
    double depth = 0.0;
    for (const Layer& layer : layers) {
        depth += layer.thickness;
    }
    return depth;
}

bool Case::relaxes() const {
    return std::any_of(layers.begin(), layers.end(), [](const Layer& l) { return l.law->relaxes(); });
}

bool Case::turns() const {
    return std::any_of(layers.begin(), layers.end(), [](const Layer& l) { return l.law->turns(); });
}

bool Case::has_energy() const {
    return std::any_of(layers.begin(), layers.end(), [](const Layer& l) { return l.law->energy() != nullptr; });
}

bool Case::is_hyperelastic() const {
    return has_energy() && std::all_of(layers.begin(), layers.end(), [](const Layer& l) {
               return l.law->energy() != nullptr || !l.law->stress_dependent();
           });
}

double Case::default_extent(double depth) const {
    // Under a pulse the wall absorbs waves, but none that meet it aslant: they come back later from farther.
    const bool moves = std::any_of(loads.begin(), loads.end(), [](const Load& load) { return load.is_pulse(); });
    double extent = std::max(moves ? 8.0 : 4.0, 2.0 * depth);
    for (const Sensor& sensor : sensors) {
        extent = std::max(extent, 2.0 * reach_of(sensor));
    }
    return extent;
}

std::vector<int> path_of_each(const Case& c) {
    std::vector<int> path(c.loads.size());
    std::iota(path.begin(), path.end(), 0);
    const bool has_path =
        std::any_of(c.layers.begin(), c.layers.end(), [](const Layer& layer) { return layer.law->stress_dependent(); });
    if (!has_path || c.is_hyperelastic() || !c.settings.shares_paths ||
        c.settings.integration != Integration::incremental || c.relaxes() || !c.effects.empty() ||
        !c.corrections.empty()) {
        return path;
    }
    for (std::size_t l = 0; l < path.size(); ++l) {
        const bool by_deflections = std::all_of(c.sensors.begin(), c.sensors.end(), [&](const Sensor& s) {
            return s.load != static_cast<int>(l) || s.quantity == Quantity::deflection;
        });
        Load load = c.loads[l];
        if (!by_deflections || load.type != LoadType::plate || load.is_pulse() || load.inertia) {
            continue;
        }
        for (std::size_t other = 0; other < path.size(); ++other) {
            load.name = c.loads[other].name;
            load.pressure = c.loads[other].pressure;
            if (load == c.loads[other] && load.pressure > c.loads[static_cast<std::size_t>(path[l])].pressure) {
                path[l] = static_cast<int>(other);
            }
        }
    }
    return path;
}

} // namespace pave::pavement
