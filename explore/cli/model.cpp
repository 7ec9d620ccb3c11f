#include "cli/model.h"

#include "run/parallel.h"
#include "run/progress.h"
#include "search/design.h"
#include "study/reduced_function.h"

#include <filesystem>
#include <fmt/format.h>
#include <stdexcept>

namespace explore::cli {
namespace {

// Cases that a reduced model is built and judged from; the full model answers a part of them.
constexpr int samples = 512;
// Their own: not those of a run, which are to be new to the model.
constexpr std::uint64_t sample_seed = 0x5eed0fca5e5;

} // namespace

void add_model(CLI::App& app, ModelOptions& options, bool alone) {
    std::string text = "full; ";
    if (alone) {
        text += "reduced: a projection of the full model that is built for the study's ranges first and estimates its "
                "own error; auto: the reduced one explores, what is reported comes from the full one";
    } else {
        text += "auto: a projection of it that is built for the study's ranges first explores, what is reported comes "
                "from the full model";
    }
    app.add_option("--model", options.model, text)
        ->check(alone ? CLI::IsMember({"full", "reduced", "auto"}) : CLI::IsMember({"full", "auto"}))
        ->capture_default_str();
    app.add_option("--model-error", options.limit_percent,
                   "estimated error of a reading [%] above which the full model runs in place of the reduced one")
        ->check(within(0.01, 100.0))
        ->capture_default_str();
}

std::optional<ReducedProblem> reduced_problem(const problem::Problem& fitted, const study::Study& study,
                                              const ModelOptions& options, const std::string& folder, int threads) {
    if (const std::string why = study::why_no_reduced_model(study); !why.empty()) {
        throw pave::Error({.file = study.file}, "this study has no reduced model", why, "--model full");
    }
    const std::string key = study::reduced_key(study, samples);
    const std::string file = (std::filesystem::path(folder) / "reduced.bin").string();
    auto loads = study::load_reduced(file, key);
    const bool built = !loads;
    if (built) {
        tbb::task_arena arena(run::usable_threads(threads));
        run::Progress progress("build the reduced model", 0);
        const pave::reduced::ForEach for_each = [&](std::size_t n, const std::function<void(std::size_t)>& body) {
            run::for_each_index(arena, n, [&](std::size_t i) {
                body(i);
                progress.add(1, true);
            });
            if (run::interrupted()) {
                throw run::Interrupted();
            }
        };
        std::optional<pave::Outcome<study::ReducedLoads>> outcome;
        try {
            outcome = study::build_reduced(study, search::sobol(study.space, samples, sample_seed).points, for_each);
        } catch (const run::Interrupted&) {
            return std::nullopt;
        }
        if (!*outcome) {
            throw std::runtime_error(outcome->failure().reason);
        }
        loads = std::move(*outcome).value();
        std::filesystem::create_directories(folder);
        study::save_reduced(file, key, *loads);
    }
    ReducedProblem result{.problem = study::with_reduced_model(fitted, study, *loads, options.limit_percent / 100.0),
                          .settings = fmt::format(", reduced model {}, {} %", key, options.limit_percent),
                          .json = {{"loads", report::Json::array()}},
                          .words = {},
                          .built = built};
    for (std::size_t l = 0; l < loads->size(); ++l) {
        if (!(*loads)[l]) {
            continue;
        }
        const auto& name = study.model.loads[l].name;
        const auto& r = (*loads)[l]->report;
        result.words += fmt::format("  reduced model of load {}: {} modes, {} points, from {} full runs{}; errors at "
                                    "new points below {:.2g} % in 95 of 100\n",
                                    name, r.modes, r.points, r.full_runs, built ? "" : " before", 100.0 * r.error_95);
        result.json["loads"].push_back({{"load", name},
                                        {"modes", r.modes},
                                        {"points", r.points},
                                        {"full_runs", r.full_runs},
                                        {"error_95", r.error_95}});
    }
    return result;
}

} // namespace explore::cli
