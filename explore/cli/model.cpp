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

void add_model(CLI::App& app, ModelOptions& options) {
    app.add_option("--model", options.model,
                   "full; reduced: a projection of the full model that is built for the study's ranges first and "
                   "estimates its own error; auto: the reduced one explores, what is reported comes from the full one")
        ->check(CLI::IsMember({"full", "reduced", "auto"}))
        ->capture_default_str();
    app.add_option("--model-error", options.limit_percent,
                   "estimated error of a reading [%] above which the full model runs in place of the reduced one")
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
}

std::optional<ReducedProblem> reduced_problem(const study::Study& study, const ModelOptions& options,
                                              const std::string& folder, int threads) {
    ReducedProblem result{study::make_problem(study, study::Scope::fitted), {}, {}, {}}; // complains of what is missing
    if (const std::string why = study::why_no_reduced_model(study); !why.empty()) {
        throw pave::Error({.file = study.file}, "this study has no reduced model", why, "--model full");
    }
    const std::string key = study::reduced_key(study, samples);
    const std::string file = (std::filesystem::path(folder) / "reduced.bin").string();
    auto bases = study::load_reduced(file, key);
    if (bases) {
        result.words = "  reduced model: built before\n";
        result.json = {{"built", false}};
    } else {
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
        result.json = {{"built", true}, {"loads", report::Json::array()}};
        std::optional<pave::Outcome<study::ReducedBases>> outcome;
        try {
            outcome = study::build_reduced(
                study, search::sobol(study.space, samples, sample_seed).points, for_each,
                [&](const std::string& load, const pave::reduced::BuildReport& r) {
                    result.words +=
                        fmt::format("  reduced model of load {}: {} modes, {} points, from {} full runs; errors "
                                    "at new points below {:.2g} % in 95 of 100\n",
                                    load, r.modes, r.points, r.full_runs, 100.0 * r.error_95);
                    result.json["loads"].push_back({{"load", load},
                                                    {"modes", r.modes},
                                                    {"points", r.points},
                                                    {"full_runs", r.full_runs},
                                                    {"error_95", r.error_95}});
                });
        } catch (const run::Interrupted&) {
            return std::nullopt;
        }
        if (!*outcome) {
            throw std::runtime_error(outcome->failure().reason);
        }
        bases = std::move(*outcome).value();
        std::filesystem::create_directories(folder);
        study::save_reduced(file, key, *bases);
    }
    result.settings = fmt::format(", reduced model {}, {} %", key, options.limit_percent);
    result.problem = study::make_reduced_problem(study, *bases, options.limit_percent / 100.0);
    return result;
}

} // namespace explore::cli
