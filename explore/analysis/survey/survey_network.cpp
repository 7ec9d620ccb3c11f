#include "analysis/survey/survey_network.h"

#include "landscape/batch.h"
#include "landscape/minima.h"
#include "run/progress.h"
#include "study/laws.h"
#include "study/network.h"
#include "study/reduced_function.h"

#include <algorithm>
#include <fmt/format.h>
#include <mutex>

namespace explore::analysis {
namespace {

constexpr double worth_confirming = 1.1; // times the lowest misfit: what the reduced model may take one for the other

// Every answer is fitted by the full model from where this one's searches end: half of what is built elsewhere will do.
constexpr pave::reduced::BuildSettings build_settings{.most_runs = 150, .calibration = 50};

// The full model takes its place where it may err by more than this: seldom, for it answers in the end.
constexpr double limit_percent = 10.0;

using Group = std::vector<const StationTask*>;

study::Study study_of(const SurveyResult& result, const Group& group) {
    constexpr double margin = 1.01; // the range is one of positive length where all pressures are the same
    double low = std::numeric_limits<double>::infinity();
    double high = 0.0;
    for (const StationTask* task : group) {
        for (const data::DeflectionBowl* bowl : task->bowls()) {
            low = std::min(low, bowl->pressure_kPa);
            high = std::max(high, bowl->pressure_kPa);
        }
    }
    return study::network_study(*result.study, group[0]->layout(), low / margin, high * margin);
}

// False: interrupted.
bool search_group(Session& session, const std::vector<StationSearch*>& group, const ReducedProblem& network,
                  const landscape::MultistartSettings& settings) {
    std::vector<landscape::BatchItem> items;
    items.reserve(group.size());
    for (const StationSearch* search : group) {
        const int run = session.begin(search->task->study, "survey", search->settings + network.settings);
        const StationTask& task = *search->task;
        items.push_back({on_network(task.problem, network, task.bowls(), task.layout()), run, search->starts});
    }
    run::Progress progress("search by the reduced model",
                           session.options().show_progress ? static_cast<std::int64_t>(items.size()) : -1,
                           {"stations/min", 60.0});
    std::mutex mutex;
    std::size_t finished = 0;
    const auto keep = [&](std::size_t i, const std::vector<run::Endpoint>& ends, const run::Tally& tally) {
        progress.add(1, tally.computed > 0);
        const auto minima = landscape::distinct_minima(ends, items[i].problem);
        const std::scoped_lock lock(mutex);
        ++finished;
        if (minima.empty()) {
            return; // the full model may have an answer where this has none
        }
        StationSearch& search = *group[i];
        search.members = minima[0].members;
        search.minima = minima.size();
        search.searched = ends.size();
        search.settings += network.settings + ", confirmed";
        search.starts.clear();
        for (const landscape::Minimum& m : minima) {
            if (m.evaluation.misfit <= worth_confirming * minima[0].evaluation.misfit) {
                search.starts.push_back(m.unit);
            }
        }
    };
    auto search = settings.search;
    search.misfit_tolerance = 1e-4; // the full model goes on from there
    landscape::search_batch(items, session.store(), *optimise::find_method(settings.method), search,
                            session.options().threads, keep);
    return finished == items.size();
}

} // namespace

problem::Problem on_network(problem::Problem problem, const ReducedProblem& network,
                            const std::vector<const data::DeflectionBowl*>& bowls, const data::DeflectionBowl& layout) {
    std::vector<study::NetworkLevel> levels;
    levels.reserve(bowls.size());
    for (const data::DeflectionBowl* bowl : bowls) {
        levels.push_back({bowl->pressure_kPa, sensors_of(*bowl, layout)});
    }
    return study::with_network(std::move(problem), network.problem.function, std::move(levels));
}

bool Networks::build(const std::vector<StationTask>& tasks) {
    if (study::stress_dependent_layers(*result_.study).empty() || !result_.study->constraints.empty()) {
        return true; // the layered engine is as quick; constraints may be on outputs, which the network does not read
    }
    if (std::any_of(tasks.begin(), tasks.end(), [](const auto& t) { return !t.station->station.layers.empty(); })) {
        return true; // one section is not that of all stations
    }
    std::map<std::vector<double>, Group> groups;
    for (const StationTask& task : tasks) {
        groups[layout_key(task.layout())].push_back(&task);
    }
    for (const auto& [key, group] : groups) {
        if (group.size() < network_stations) {
            continue;
        }
        const study::Study study = study_of(result_, group);
        if (!study::why_no_reduced_model(study).empty()) {
            continue;
        }
        const std::string name = networks_.empty() ? "reduced" : fmt::format("reduced-{}", networks_.size());
        try {
            auto network =
                session_.reduced(study::make_problem(study), study,
                                 {.use = ModelUse::automatic, .limit_percent = limit_percent}, name, build_settings);
            if (!network) {
                return false;
            }
            result_.networks.push_back({group.size(), network->loads[0].report});
            networks_.emplace(key, std::move(*network));
        } catch (const pave::Error&) {
            throw;
        } catch (const std::runtime_error&) {
            continue; // the full model has too few answers in the box to learn from
        }
    }
    return true;
}

const ReducedProblem* Networks::of(const data::DeflectionBowl& layout) const {
    const auto found = networks_.find(layout_key(layout));
    return found == networks_.end() ? nullptr : &found->second;
}

bool Networks::search(std::vector<StationSearch>& searches, const landscape::MultistartSettings& settings) {
    std::map<const ReducedProblem*, std::vector<StationSearch*>> groups;
    for (StationSearch& search : searches) {
        if (const ReducedProblem* network = of(search.task->layout())) {
            groups[network].push_back(&search);
        }
    }
    return std::all_of(groups.begin(), groups.end(),
                       [&](const auto& group) { return search_group(session_, group.second, *group.first, settings); });
}

} // namespace explore::analysis
