#include "analysis/common/session.h"

#include "analysis/common/feasible.h"

#include "analysis/common/stand_in.h"
#include "analysis/explore/build.h"
#include "base/text.h"
#include "external/model.h"
#include "run/files.h"
#include "run/message.h"
#include "run/parallel.h"
#include "run/progress.h"
#include "search/design.h"
#include "study/reduced_function.h"

#include <filesystem>
#include <fmt/format.h>
#include <stdexcept>

namespace explore::analysis {
namespace {

// Cases that a reduced model is built and judged from; the full model answers a part of them.
constexpr int samples = 512;
// Their own: not those of a run, which are to be new to the model.
constexpr std::uint64_t sample_seed = 0x5eed0fca5e5;

// Nothing: interrupted.
std::optional<study::ReducedLoads> build(const study::Study& study, const RunOptions& options,
                                         const pave::reduced::BuildSettings& settings) {
    tbb::task_arena arena(run::usable_threads(options.threads));
    run::Progress progress("build the reduced model", options.show_progress ? 0 : -1);
    const pave::reduced::ForEach for_each = [&](std::size_t n, const std::function<void(std::size_t)>& body) {
        run::for_each_index(arena, n, [&](std::size_t i) {
            body(i);
            progress.add(1, true);
        });
        if (run::interrupted()) {
            throw run::Interrupted();
        }
    };
    try {
        auto outcome =
            study::build_reduced(study, search::sobol(study.space, samples, sample_seed).points, settings, for_each);
        if (!outcome) {
            throw std::runtime_error(outcome.failure().reason);
        }
        return std::move(outcome).value();
    } catch (const run::Interrupted&) {
        return std::nullopt;
    }
}

} // namespace

Session::Session(RunOptions options) : options_(std::move(options)) {}

int Session::begin(const study::Study& study, const std::string& name, const std::string& settings) {
    if (options_.folder.empty()) {
        return 0;
    }
    refuse_contradictions(study);
    if (!store_) { // not before there is something to keep: a study that is refused leaves no folder
        store_.emplace(options_.folder, run::Session{.version = version,
                                                     .libraries = library_words(),
                                                     .arguments = options_.arguments,
                                                     .directory = std::filesystem::current_path().string(),
                                                     .threads = run::concurrency(options_.threads)});
        store_->keep_inputs({}, options_.inputs);
    }
    if (study.external) {
        external_ = study.external;
        external_->simulator().keep_in((std::filesystem::path(options_.folder) / "runs").string());
    }
    if (study.inputs) {
        store_->keep_inputs(study.file_hash, *study.inputs);
    }
    run::RunHeader header;
    header.key = {name, study.hash, settings};
    if (study.load_steps == study::LoadSteps::chosen) {
        header.key.settings += fmt::format(", {} load steps", study.model.settings.solver.load_steps);
    }
    header.version = version;
    for (const auto& axis : study.space.axes) {
        header.parameters.push_back(axis.name);
    }
    for (const data::Reading& reading : study.readings) {
        header.responses.push_back(reading.label_with_unit());
        header.response_to_si.push_back(reading.unit.to_si);
    }
    newest_ = store_->begin(header);
    return newest_;
}

run::Engine Session::engine(const problem::Problem& problem, int run) {
    return {problem, store(), run, engine_settings()};
}

run::EngineSettings Session::engine_settings() const {
    return {.threads = options_.threads, .show_progress = options_.show_progress};
}

std::optional<ReducedProblem> Session::reduced(const problem::Problem& fitted, const study::Study& study,
                                               const ModelOptions& model, const std::string& name,
                                               const pave::reduced::BuildSettings& settings) {
    if (!model.reduced()) {
        return std::nullopt;
    }
    if (study.has_own_model) {
        return stand_in(*this, fitted, study, model);
    }
    if (const std::string why = study::why_no_reduced_model(study); !why.empty()) {
        throw pave::Error({.file = study.file}, "this study has no reduced model", why, "--model full");
    }
    const std::string key = study::reduced_key(study, samples, settings);
    const std::string file = (std::filesystem::path(options_.folder) / (name + ".bin")).string();
    auto loads = options_.folder.empty() ? std::nullopt : study::load_reduced(file, key);
    const bool built = !loads;
    if (built) {
        loads = build(study, options_, settings);
        if (!loads) {
            return std::nullopt;
        }
        if (!options_.folder.empty()) {
            std::filesystem::create_directories(options_.folder);
            study::save_reduced(file, key, *loads);
        }
    }
    ReducedProblem result{.problem = study::with_reduced_model(fitted, study, *loads, model.limit_percent / 100.0),
                          .settings = fmt::format(", reduced model {}, {} %", key, model.limit_percent),
                          .loads = {},
                          .built = built};
    for (std::size_t l = 0; l < loads->size(); ++l) {
        if ((*loads)[l]) {
            result.loads.push_back({study.model.loads[l].name, (*loads)[l]->report});
        }
    }
    return result;
}

void Session::keep(const std::string& name, const std::string& json) {
    if (store_) {
        store_->put_result(newest_, json);
        if (const std::size_t count = store_->over_time(); count > 0 && external_) {
            run::message(
                "{} had no answer for reasons that may pass and {} not kept: the same command tries {} again\n",
                pave::counted(count, "run", "runs"), count == 1 ? "is" : "are", count == 1 ? "it" : "them");
        } else if (count > 0) {
            run::message("{} took longer than [solver] time_limit_s allows and {} not kept: the same command tries {} "
                         "again\n",
                         pave::counted(count, "run", "runs"), count == 1 ? "is" : "are", count == 1 ? "it" : "them");
        }
    }
    if (external_) {
        if (const std::string words = external_->simulator().kept_words(); !words.empty()) {
            run::message("{}\n", words);
        }
    }
    if (!options_.folder.empty()) {
        run::write_file(options_.folder, name + ".json", json + "\n");
    }
}

} // namespace explore::analysis
