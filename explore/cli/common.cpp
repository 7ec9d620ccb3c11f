#include "cli/common.h"

#include "analysis/common/run_cost.h"
#include "run/message.h"
#include "run/parallel.h"
#include "run/progress.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace explore::cli {

CLI::Validator within(double low, double high) {
    return {[=](std::string& text) {
                double value = NAN;
                return CLI::detail::lexical_cast(text, value) && value >= low && value <= high
                           ? std::string()
                           : fmt::format("{} is not a number from {} to {}", text, low, high);
            },
            fmt::format("{} - {}", low, high)};
}

namespace {

// CLI11 reads -1 as the largest number there is.
CLI::Validator whole_number() {
    return {[](std::string& text) {
                std::uint64_t value = 0;
                const char* end = text.data() + text.size();
                const auto read = std::from_chars(text.data(), end, value);
                return read.ec == std::errc() && read.ptr == end
                           ? std::string()
                           : fmt::format("{} is not a whole number from 0 to {}", text,
                                         std::numeric_limits<std::uint64_t>::max());
            },
            "UINT"};
}

std::vector<std::string> command_line; // one a process

} // namespace

analysis::RunOptions CommonOptions::run(const study::Study& s) const {
    const auto& loads = s.model.loads;
    if (!std::all_of(loads.begin(), loads.end(), [](const auto& load) { return load.is_axisymmetric(); })) {
        constexpr double long_seconds = 20.0;
        const auto cost = analysis::affordable_cost(s, run::usable_threads(threads));
        if (cost.seconds > long_seconds) {
            run::message("a run of this study asks for some {} a thread and takes some {}; check estimates the "
                         "whole, --threads and [mesh] refine lessen it\n",
                         run::memory_words(cost.memory), run::duration_words(cost.seconds));
        }
    }
    return run(folder(s));
}

analysis::RunOptions CommonOptions::run(std::string folder) const {
    return {.folder = std::move(folder), .threads = threads, .seed = seed, .arguments = command_line};
}

void add_run_options(CLI::App& app, CommonOptions& options, const std::string& default_folder) {
    app.add_option("--out", options.out, "folder for the results (default: " + default_folder + ")")->type_name("DIR");
    app.add_option("--threads", options.threads, "number of threads (default: one a core)")
        ->check(within(analysis::allowed::threads));
    app.add_option("--seed", options.seed, "fixes what is random")->check(whole_number())->capture_default_str();
    app.add_flag("--json", options.json, "print one JSON object and nothing else");
}

void add_common(CLI::App& app, CommonOptions& options) {
    app.add_option("STUDY", options.study, "study file (TOML)")->required();
    add_run_options(app, options, "output/<study name>");
}

void add_columns(CLI::App& app, std::string& columns) {
    app.add_option("--columns", columns,
                   "names of the columns of a table: \"load_kN = Force, D0_um = D1, radius_mm = 150\", or a file of "
                   "such lines")
        ->type_name("TEXT|FILE");
}

void add_model(CLI::App& app, analysis::ModelOptions& options, bool alone) {
    std::string text = "full; ";
    if (alone) {
        text += "reduced: a projection of the full model that is built for the study's ranges first and estimates its "
                "own error; auto: the reduced one explores, what is reported comes from the full one";
    } else {
        text += "auto: a projection of it that is built for the study's ranges first explores, what is reported comes "
                "from the full model";
    }
    auto* option = add_choice(app, "--model", options.use, analysis::model_names, text);
    if (!alone) {
        option->check(CLI::IsMember({"full", "auto"}));
    }
    app.add_option("--model-error", options.limit_percent,
                   "estimated error of a reading [%] above which the full model runs in place of the reduced one")
        ->check(within(analysis::allowed::model_error))
        ->capture_default_str();
}

void remember_command_line(int argc, const char* const* argv) {
    command_line.assign(argv + 1, argv + argc);
}

int hand_over(analysis::Session& session, const CommonOptions& options, std::string_view name, const report::Json& json,
              const std::function<std::string()>& page) {
    const std::string text = report::json_text(json);
    session.keep(std::string(name), text);
    fmt::print("{}", options.json ? text + "\n" : page());
    return done;
}

int hand_over_failure(const CommonOptions& options, const report::Json& json, std::string_view reason) {
    if (options.json) {
        fmt::print("{}\n", report::json_text(json));
    }
    complain(reason);
    return computation_failed;
}

int report_interrupt(const std::string& folder) {
    run::message("interrupted: what was computed is kept in {}; the same command continues\n", folder);
    return was_interrupted;
}

} // namespace explore::cli
