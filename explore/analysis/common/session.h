// A session of a run: its folder and store, the threads, the seed, and which model answers. Made once a command.
#pragma once

#include "reduced/build_settings.h"
#include "run/engine.h"
#include "study/problems.h"

namespace explore::analysis {

struct RunOptions {
    std::string folder{}; // of the results; empty: nothing is kept
    int threads = 0;      // 0: as many as the machine has
    std::uint64_t seed = 1;
    bool show_progress = true;             // on a terminal
    std::vector<std::string> arguments{};  // of the command line, for the store
    std::vector<data::InputFile> inputs{}; // that are read besides the studies, for the store
};

enum class ModelUse {
    full,
    reduced,  // a projection of the full model answers, which runs where that is not sure enough
    automatic // the reduced model explores, what is reported comes from the full one
};
inline constexpr std::string_view model_names[] = {"full", "reduced", "auto"};

struct ModelOptions {
    ModelUse use = ModelUse::full;
    double limit_percent = 3.0; // estimated error of a reading above which the full model runs

    bool reduced() const { return use != ModelUse::full; }
    bool alone() const { return use == ModelUse::reduced; }
    bool confirmed() const { return use == ModelUse::automatic; }
    std::string_view name() const { return model_names[static_cast<int>(use)]; }
};

// A problem whose function is a reduced model, and what is to be said of that.
struct ReducedProblem {
    struct Load {
        std::string name;
        pave::reduced::BuildReport report;
    };
    problem::Problem problem;
    std::string settings; // what to add to those of a run
    std::vector<Load> loads;
    bool built = false; // now, not before
};

class Session {
public:
    explicit Session(RunOptions options);

    const RunOptions& options() const { return options_; }
    const std::string& folder() const { return options_.folder; }
    run::Store* store() { return store_ ? &*store_ : nullptr; }

    // The run of the store with these responses, name and settings: the one begun before or a new one. It becomes the
    // newest. settings: everything that fixes the evaluations, but not how many there are of a sequence: more of them
    // continue the run.
    int begin(const study::Study& study, const std::string& name, const std::string& settings);
    run::EngineSettings engine_settings() const;
    // The engine that computes a problem and keeps it in that run, which must outlive the engine.
    run::Engine engine(const problem::Problem& problem, int run);

    // The problem with its reduced model: that of the run's folder when it is still the right one, else built and kept
    // there, in NAME.bin. fitted: the study's fitted readings. Nothing: interrupted, or the full model is requested.
    // Throws pave::Error for a study that has none, std::runtime_error where the full model has too few answers.
    std::optional<ReducedProblem> reduced(const problem::Problem& fitted, const study::Study& study,
                                          const ModelOptions& model, const std::string& name = "reduced",
                                          const pave::reduced::BuildSettings& build = {});

    // A whole result as JSON: in NAME.json of the folder, and with the newest run of the store.
    void keep(const std::string& name, const std::string& json);

private:
    RunOptions options_;
    std::optional<run::Store> store_;
    std::shared_ptr<const external::Model> external_; // of the study begun last, where it has one
    int newest_ = 0;
};

} // namespace explore::analysis
