#include "run/store_difference.h"

#include <algorithm>
#include <bit>
#include <fmt/format.h>

namespace explore::run {
namespace {

std::string place_of(const RunHeader& run, RunNumber n) {
    return n.start < 0 ? fmt::format("{}, point {}", run.key.command, n.number)
                       : fmt::format("{}, search {}, evaluation {}", run.key.command, n.start, n.number);
}

// The first list entry whose bits differ, in words.
std::string difference_of(std::string_view what, const std::vector<std::string>& names, const double* then,
                          const double* now, std::size_t count, const Sides& sides) {
    for (std::size_t i = 0; i < count; ++i) {
        if (std::bit_cast<std::uint64_t>(then[i]) != std::bit_cast<std::uint64_t>(now[i])) {
            const std::string name = i < names.size() ? names[i] : std::to_string(i + 1);
            return fmt::format("{} {}: {} {}, {} {} (SI)", what, name, then[i], sides.first, now[i], sides.second);
        }
    }
    return {};
}

std::string difference_of(const RunHeader& run, const problem::Evaluation& then, const problem::Evaluation& now,
                          const Sides& sides) {
    if (then.status != now.status) {
        return fmt::format("status: {} {}, {} {}", to_string(then.status), sides.first, to_string(now.status),
                           sides.second);
    }
    if (then.parameters.size() != now.parameters.size() || then.responses.size() != now.responses.size() ||
        then.jacobian.rows() != now.jacobian.rows() || then.jacobian.cols() != now.jacobian.cols()) {
        return "another number of values";
    }
    std::string found = difference_of("parameter", run.parameters, then.parameters.data(), now.parameters.data(),
                                      now.parameters.size(), sides);
    if (found.empty()) {
        found = difference_of("response", run.responses, then.responses.data(), now.responses.data(),
                              now.responses.size(), sides);
    }
    if (found.empty()) {
        found = difference_of("derivative", {}, then.jacobian.data(), now.jacobian.data(),
                              static_cast<std::size_t>(now.jacobian.size()), sides);
    }
    return found;
}

} // namespace

std::string difference_of(const RunHeader& run, RunNumber number, const problem::Evaluation& first,
                          const problem::Evaluation& second, const Sides& sides) {
    const std::string words = difference_of(run, first, second, sides);
    return words.empty() ? words : place_of(run, number) + ": " + words;
}

StoreDifference difference_of(const Store& then_store, const Store& now_store) {
    StoreDifference d;
    const auto new_runs = now_store.runs();
    auto old_runs = then_store.runs();
    std::sort(old_runs.begin(), old_runs.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    for (const RunHeader& old_run : old_runs) {
        const auto same = std::find_if(new_runs.begin(), new_runs.end(),
                                       [&](const RunHeader& run) { return run.key == old_run.key; });
        if (same == new_runs.end()) {
            // One command may make many runs of one settings text: of other models of the study, or of other studies.
            const bool other_study = std::any_of(new_runs.begin(), new_runs.end(), [&](const RunHeader& run) {
                return run.key.command == old_run.key.command && run.key.settings == old_run.key.settings;
            });
            d.first = other_study ? fmt::format("{}: the study or its data have changed since", old_run.key.command)
                                  : fmt::format("{} ({}): not among what was repeated", old_run.key.command,
                                                old_run.key.settings);
            return d;
        }
        std::map<RunNumber, problem::Evaluation> now;
        now_store.each(same->id, [&](RunNumber n, const problem::Evaluation& e) { now.emplace(n, e); });
        ++d.runs;
        then_store.each(old_run.id, [&](RunNumber n, const problem::Evaluation& then) {
            if (!d.first.empty()) {
                return;
            }
            const auto found = now.find(n);
            d.first = found == now.end() ? place_of(old_run, n) + ": not computed now"
                                         : difference_of(old_run, n, then, found->second, {"then", "now"});
            ++d.evaluations;
            if (found != now.end()) {
                now.erase(found);
            }
        });
        if (d.first.empty() && !now.empty()) {
            d.first = place_of(old_run, now.begin()->first) + ": not computed then";
        }
        if (!d.first.empty()) {
            return d;
        }
    }
    return d;
}

} // namespace explore::run
