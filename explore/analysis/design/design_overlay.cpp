#include "analysis/design/design_overlay.h"

#include "pavement/forward.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace explore::analysis {
namespace {

using namespace pave::pavement;

constexpr double near_enough = 0.5; // mm

// margin: of what is added [mm], ln of the life over what is required, of the criterion that is shortest; the top is
// so thick [mm].
std::optional<double> thinnest_that_lasts(const std::function<double(double)>& margin, double top) {
    // Down to what lasts no more, or up to what lasts.
    const double at_present = margin(0.0);
    double lasts = 0.0;
    double fails = 0.0;
    double of_fails = at_present;
    double of_lasts = at_present;
    if (at_present >= 0.0) {
        const double thinnest = std::min(0.0, thinnest_top - top);
        for (const double share : {0.25, 0.5, 1.0}) {
            of_fails = margin(share * thinnest);
            fails = share * thinnest;
            if (of_fails < 0.0) {
                break;
            }
            lasts = fails;
            of_lasts = of_fails;
        }
        if (of_fails >= 0.0) {
            return lasts;
        }
    } else {
        for (const double added : {30.0, 60.0, 100.0, 150.0, 200.0, 300.0, thickest_overlay}) {
            of_lasts = margin(added);
            lasts = added;
            if (of_lasts >= 0.0) {
                break;
            }
            fails = added;
            of_fails = of_lasts;
        }
        if (of_lasts < 0.0) {
            return std::nullopt;
        }
    }
    // Between the two by false position, by halves where that goes slowly; the end that lasts is the answer.
    for (int i = 0; std::abs(lasts - fails) > near_enough && i < 20; ++i) {
        const double share = i % 3 == 2 || !std::isfinite(of_fails) || !std::isfinite(of_lasts)
                                 ? 0.5
                                 : std::clamp(of_lasts / (of_lasts - of_fails), 0.02, 0.98);
        const double tried = lasts + share * (fails - lasts);
        const double now = margin(tried);
        (now >= 0.0 ? lasts : fails) = tried;
        (now >= 0.0 ? of_lasts : of_fails) = now;
    }
    return lasts;
}

} // namespace

std::vector<double> lives_with_overlay(const CriticalPlaces& places, const std::vector<Life>& all,
                                       const std::vector<double>& parameters, double added_mm) {
    Case c = all[0].at(parameters);
    c.sensors.resize(places.first + places.count);
    c.sensors.erase(c.sensors.begin(), c.sensors.begin() + static_cast<std::ptrdiff_t>(places.first));
    const double added = 1e-3 * added_mm;
    c.layers[0].thickness += added;
    std::vector<bool> loads(c.loads.size(), false);
    for (Sensor& sensor : c.sensors) {
        sensor.depth += sensor.depth > 0.0 ? added : 0.0;
        loads[static_cast<std::size_t>(sensor.load)] = true;
    }
    if (c.settings.wall_follows) {
        c.settings.extent = c.default_extent();
    }
    std::vector<double> responses(places.first, 0.0); // that nobody reads
    for (std::size_t s = 0; s <= places.seasons.size(); ++s) {
        Case then = c;
        if (s > 0) {
            study::soften(then, places.seasons[s - 1]);
        }
        const ForwardModel model(then, loads);
        const auto response = model.run(then, {}, *model.make_workspace());
        if (!response) {
            return {};
        }
        responses.insert(responses.end(), response->values.begin(), response->values.end());
    }
    std::vector<double> lives;
    for (const Life& life : all) {
        lives.push_back(life.log_repetitions(c, responses));
    }
    return lives;
}

std::vector<std::optional<double>> overlays_needed(const CriticalPlaces& places, const std::vector<Life>& lives,
                                                   const std::vector<std::vector<double>>& required,
                                                   const std::vector<double>& parameters) {
    std::map<double, std::vector<double>> known; // lives by what is added
    const double top = 1e3 * lives[0].at(parameters).layers[0].thickness;
    std::vector<std::optional<double>> needed;
    for (const std::vector<double>& demand : required) {
        const auto margin = [&](double added) {
            auto at = known.find(added);
            if (at == known.end()) {
                at = known.emplace(added, lives_with_overlay(places, lives, parameters, added)).first;
            }
            double least = at->second.empty() ? -INFINITY : INFINITY;
            for (std::size_t i = 0; i < at->second.size(); ++i) {
                least = std::min(least, at->second[i] - std::log(demand[i]));
            }
            return least;
        };
        needed.push_back(thinnest_that_lasts(margin, top));
    }
    return needed;
}

} // namespace explore::analysis
