#include "analysis/common/curves.h"

#include "base/units.h"
#include "pavement/forward.h"
#include "study/pavement_function.h"
#include "study/readings.h"

#include <algorithm>

namespace explore::analysis {
namespace {

constexpr std::size_t least_places = 3;
constexpr int points = 48; // of a curve, besides those of the readings

// Without values. Rows: readings of one group.
std::vector<Curve> lines_of(const study::Study& study, const study::Group& group) {
    std::vector<Curve> lines;
    for (const bool by_depth : {false, true}) {
        for (const std::size_t row : group.rows) {
            const data::Reading& r = study.readings[row];
            if (r.time_ms) { // it stands in a history
                continue;
            }
            const auto on_line = [&](const Curve& c) {
                return c.by_depth == by_depth && c.y_mm == r.y_mm && c.gauge_mm == r.gauge_mm &&
                       (by_depth ? c.x_mm == r.x_mm : c.depth_mm == r.depth_mm);
            };
            auto line = std::find_if(lines.begin(), lines.end(), on_line);
            if (line == lines.end()) {
                lines.push_back({.load = r.load,
                                 .quantity = r.quantity,
                                 .by_depth = by_depth,
                                 .x_mm = r.x_mm,
                                 .y_mm = r.y_mm,
                                 .depth_mm = r.depth_mm,
                                 .gauge_mm = r.gauge_mm,
                                 .unit = std::string(r.unit.name),
                                 .at_mm = {},
                                 .values = {}});
                line = lines.end() - 1;
            }
            line->at_mm.push_back(by_depth ? r.depth_mm : r.x_mm);
        }
    }
    std::erase_if(lines, [](Curve& line) {
        std::sort(line.at_mm.begin(), line.at_mm.end());
        line.at_mm.erase(std::unique(line.at_mm.begin(), line.at_mm.end()), line.at_mm.end());
        return line.at_mm.size() < least_places;
    });
    for (Curve& line : lines) {
        const double first = line.at_mm.front();
        const double last = line.at_mm.back();
        for (int i = 1; i < points; ++i) {
            line.at_mm.push_back(first + (last - first) * i / points);
        }
        std::sort(line.at_mm.begin(), line.at_mm.end());
        line.at_mm.erase(std::unique(line.at_mm.begin(), line.at_mm.end()), line.at_mm.end());
    }
    return lines;
}

} // namespace

std::vector<Curve> curves(const study::Study& study, const std::vector<double>& parameters) {
    if (study.has_own_model) { // it reads at its own places
        return {};
    }
    std::vector<Curve> lines;
    std::vector<bool> loads(study.model.loads.size(), false);
    for (const study::Group& group : study.groups) {
        for (Curve& line : lines_of(study, group)) {
            loads[static_cast<std::size_t>(study::find_load(study.model, line.load, {}))] = true;
            lines.push_back(std::move(line));
        }
    }
    auto at = study::case_at(study.model, study.parameters, parameters);
    if (lines.empty() || !at) {
        return {};
    }
    pave::pavement::Case between = std::move(at).value();
    for (const Curve& line : lines) {
        for (const double place : line.at_mm) {
            pave::pavement::Sensor sensor;
            sensor.load = study::find_load(study.model, line.load, {});
            sensor.quantity = study::find_quantity(line.quantity, {});
            sensor.x = (line.by_depth ? line.x_mm : place) * pave::unit::mm;
            sensor.y = line.y_mm * pave::unit::mm;
            sensor.depth = (line.by_depth ? place : line.depth_mm) * pave::unit::mm;
            sensor.gauge = line.gauge_mm * pave::unit::mm;
            between.sensors.push_back(sensor);
        }
    }
    const pave::pavement::ForwardModel model(study.model, loads);
    const auto response = model.run(between, {}, *model.make_workspace());
    if (!response) {
        return {};
    }
    std::size_t sensor = study.model.sensors.size();
    for (Curve& line : lines) {
        const double to_si = data::unit_named(line.unit).to_si;
        for (std::size_t i = 0; i < line.at_mm.size(); ++i) {
            line.values.push_back(response->values[sensor++] / to_si);
        }
    }
    return lines;
}

} // namespace explore::analysis
