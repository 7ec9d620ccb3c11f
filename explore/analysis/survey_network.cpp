#include "analysis/survey_network.h"

#include "landscape/batch.h"
#include "landscape/minima.h"
#include "run/progress.h"
#include "study/laws.h"
#include "study/network.h"

#include <algorithm>
#include <fmt/format.h>
#include <mutex>

namespace explore::analysis {
namespace {

constexpr double worth_confirming = 1.1; // times the lowest misfit: what the reduced model may take one for the other

using Group = std::vector<StationSearch*>;

std::map<std::vector<double>, Group> layouts_of(std::vector<StationSearch>& searches) {
    std::map<std::vector<double>, Group> groups;
    for (StationSearch& search : searches) {
        groups[layout_key(search.task->layout())].push_back(&search);
    }
    return groups;
}

study::Study study_of(const SurveyResult& result, const Group& group) {
    constexpr double margin = 1.01; // the range is one of positive length where all pressures are the same
    double low = std::numeric_limits<double>::infinity();
    double high = 0.0;
    for (const StationSearch* search : group) {
        for (const data::DeflectionBowl* bowl : search->task->bowls()) {
            low = std::min(low, bowl->pressure_kPa);
            high = std::max(high, bowl->pressure_kPa);
        }
    }
    return study::network_study(*result.study, group[0]->task->layout(), low / margin, high * margin);
}

problem::Problem problem_of(const StationTask& task, const std::shared_ptr<const problem::ForwardFunction>& network) {
    const data::DeflectionBowl layout = task.layout();
    std::vector<study::NetworkLevel> levels;
    for (const data::DeflectionBowl* bowl : task.bowls()) {
        levels.push_back({bowl->pressure_kPa, sensors_of(*bowl, layout)});
    }
    return study::with_network(task.problem, network, std::move(levels));
}

// False: interrupted.
bool search_group(Session& session, SurveyResult& result, const Group& group, const ReducedProblem& network,
                  const landscape::MultistartSettings& settings) {
    std::vector<landscape::BatchItem> items;
    items.reserve(group.size());
    for (const StationSearch* search : group) {
        const int run = session.begin(search->task->study, "survey", search->settings + network.settings);
        items.push_back({problem_of(*search->task, network.problem.function), run, search->starts});
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
    landscape::search_batch(items, session.store(), *optimise::find_method(settings.method), settings.search,
                            session.options().threads, keep);
    result.networks.push_back({group.size(), network.loads[0].report});
    return finished == items.size();
}

} // namespace

bool search_by_networks(Session& session, SurveyResult& result, std::vector<StationSearch>& searches,
                        const landscape::MultistartSettings& settings) {
    if (study::stress_dependent_layers(*result.study).empty() || !result.study->constraints.empty()) {
        return true; // the layered engine is as quick; constraints may be on outputs, which the network does not read
    }
    for (const auto& [key, group] : layouts_of(searches)) {
        if (group.size() < network_stations) {
            continue;
        }
        const study::Study study = study_of(result, group);
        if (!study::why_no_reduced_model(study).empty()) {
            continue;
        }
        const std::string name =
            result.networks.empty() ? "reduced" : fmt::format("reduced-{}", result.networks.size());
        std::optional<ReducedProblem> network;
        try {
            network = session.reduced(study::make_problem(study), study, {.use = ModelUse::automatic}, name);
        } catch (const pave::Error&) {
            throw;
        } catch (const std::runtime_error&) {
            continue; // the full model has too few answers in the box to learn from
        }
        if (!network || !search_group(session, result, group, *network, settings)) {
            return false;
        }
    }
    return true;
}

} // namespace explore::analysis
