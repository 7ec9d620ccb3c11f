#include "analysis/common/starts.h"

#include "analysis/studies/point_list.h"
#include "base/error.h"
#include "run/store.h"
#include "search/design.h"
#include "study/values.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <numeric>

namespace explore::analysis {
namespace {

std::vector<std::string> names_of(const study::Study& study) {
    std::vector<std::string> names;
    for (const problem::Axis& axis : study.space.axes) {
        names.push_back(axis.name);
    }
    return names;
}

std::vector<double> own_values(const study::Study& study) {
    std::vector<double> values;
    for (const problem::Axis& axis : study.space.axes) {
        values.push_back(std::clamp(axis.start, axis.low, axis.high));
    }
    return values;
}

bool is_inside(const study::Study& study, const std::vector<double>& values) {
    for (std::size_t k = 0; k < values.size(); ++k) {
        if (!(values[k] >= study.space.axes[k].low && values[k] <= study.space.axes[k].high)) {
            return false;
        }
    }
    return true;
}

// Of the newest run in the folder that varied parameters of this study.
PointList points_of_run(const study::Study& study, const std::string& folder) {
    const run::Store store(folder);
    const std::vector<std::string> known = names_of(study);
    PointList list;
    for (const run::RunHeader& header : store.runs()) {
        std::vector<std::size_t> columns;
        list = {};
        for (std::size_t c = 0; c < header.parameters.size(); ++c) {
            if (std::find(known.begin(), known.end(), header.parameters[c]) != known.end()) {
                columns.push_back(c);
                list.names.push_back(header.parameters[c]);
            }
        }
        if (columns.empty()) {
            continue;
        }
        store.each(header.id, [&](run::RunNumber, const problem::Evaluation& e) {
            if (e.converged() && std::isfinite(e.misfit)) {
                std::vector<double>& row = list.values.emplace_back();
                for (const std::size_t c : columns) {
                    row.push_back(e.parameters[c]);
                }
                list.misfit.push_back(e.misfit);
            }
        });
        if (!list.values.empty()) {
            return list;
        }
    }
    throw pave::Error({.file = folder, .key = "--from"}, "this run has no point with an answer for this study", {},
                      "a run that varied " + pave::join(known));
}

} // namespace

std::vector<double> start_of(const study::Study& study, const std::string& text) {
    std::vector<double> values = own_values(study);
    const std::vector<std::string> names = names_of(study);
    for (const auto& [name, value] : study::named_values(text, {.key = "--start"})) {
        const pave::Place place{.key = "--start " + name};
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end()) {
            const std::string near = pave::nearest_name(name, names);
            throw pave::Error(place,
                              near.empty() ? "the study varies no such parameter"
                                           : "the study varies no such parameter, did you mean \"" + near + "\"?",
                              "\"" + name + "\"", pave::join(names));
        }
        const auto k = static_cast<std::size_t>(found - names.begin());
        const problem::Axis& axis = study.space.axes[k];
        if (!(value >= axis.low && value <= axis.high)) {
            throw pave::Error(place, "a search begins within the bounds", fmt::format("{}", value),
                              fmt::format("{} to {}", axis.low, axis.high));
        }
        values[k] = value;
    }
    return study.space.unit(values);
}

std::vector<std::vector<double>> starts_from(const study::Study& study, const std::string& folder_or_file,
                                             std::size_t most) {
    const std::vector<std::string> known = names_of(study);
    const PointList list = std::filesystem::is_directory(folder_or_file) ? points_of_run(study, folder_or_file)
                                                                         : read_points(folder_or_file, known);
    std::vector<std::vector<double>> inside;
    std::vector<double> misfit;
    for (std::size_t i = 0; i < list.values.size(); ++i) {
        std::vector<double> values = own_values(study);
        for (std::size_t c = 0; c < list.names.size(); ++c) {
            const auto k = std::find(known.begin(), known.end(), list.names[c]) - known.begin();
            values[static_cast<std::size_t>(k)] = list.values[i][c];
        }
        if (is_inside(study, values) && (list.misfit.empty() || std::isfinite(list.misfit[i]))) {
            inside.push_back(study.space.unit(values));
            misfit.push_back(list.misfit.empty() ? 0.0 : list.misfit[i]);
        }
    }
    if (inside.empty()) {
        throw pave::Error({.file = folder_or_file, .key = "--from"}, "no point of it lies within the study's bounds",
                          fmt::format("{} points", list.values.size()), "points between min and max");
    }
    std::vector<std::size_t> order(inside.size());
    if (list.misfit.empty()) { // one after the other from all parts of the list
        const std::size_t stride = (inside.size() + most - 1) / most;
        std::size_t next = 0;
        for (std::size_t first = 0; first < stride; ++first) {
            for (std::size_t i = first; i < inside.size(); i += stride) {
                order[next++] = i;
            }
        }
    } else {
        std::iota(order.begin(), order.end(), 0);
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return misfit[a] < misfit[b]; });
    }
    constexpr double apart = 0.05; // of the box
    std::vector<std::vector<double>> starts;
    for (std::size_t i = 0; i < order.size() && starts.size() < most; ++i) {
        const auto& point = inside[order[i]];
        if (std::all_of(starts.begin(), starts.end(),
                        [&](const auto& other) { return search::squared_distance(point, other) >= apart * apart; })) {
            starts.push_back(point);
        }
    }
    return starts;
}

} // namespace explore::analysis
