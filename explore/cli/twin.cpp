// pavescape twin: synthetic data from the study, in the layout of its own measurements.
#include "report/twin.h"
#include "cli/commands.h"
#include "run/files.h"
#include "run/message.h"

#include <charconv>
#include <fmt/format.h>

namespace explore::cli {
namespace {

// "NAME=SIZE"
std::pair<std::string, double> effect_of(const std::string& text) {
    const pave::Place place{.key = "--effect"};
    const auto equals = text.find('=');
    double size = 0.0;
    const char* const end = text.data() + text.size();
    const char* const begin = equals == std::string::npos ? end : text.data() + equals + 1;
    const auto read = std::from_chars(begin, end, size);
    if (read.ec != std::errc() || read.ptr != end) {
        throw pave::Error(place, "an effect is its name and its size", "\"" + text + "\"",
                          "NAME=SIZE, such as weak-subgrade-top=0.7; `pavescape effects` lists them");
    }
    return {text.substr(0, equals), size};
}

int twin(const CommonOptions& options, double noise, const std::vector<std::string>& effects) {
    analysis::TwinOptions asked{.noise = noise, .effects = {}, .seed = options.seed};
    const study::Study study = study::load_study(options.study);
    for (const std::string& effect : effects) {
        asked.effects.push_back(effect_of(effect));
    }
    const std::string folder = options.folder(study);
    const analysis::TwinResult result = analysis::twin(study, asked);
    const std::string file = folder + "/twin.csv";
    const report::Json json = report::twin_json(result, file);
    if (result.status != pave::Status::converged) {
        return hand_over_failure(options, json, std::string(to_string(result.status)) + ": " + result.reason);
    }
    const std::string text = report::twin_csv(result);
    run::write_file(folder, "twin.csv", text);
    if (options.json) {
        fmt::print("{}\n", report::json_text(json));
    } else {
        fmt::print("{}", text);
        run::message("written to {}\n", file);
    }
    return done;
}

} // namespace

void add_twin(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("twin", "synthetic data from the study, in the layout of its measurements");
    auto options = std::make_shared<CommonOptions>();
    auto noise = std::make_shared<double>(0.0);
    auto effects = std::make_shared<std::vector<std::string>>();
    add_common(*command, *options);
    command
        ->add_option(
            "--effect", *effects,
            "NAME=SIZE: the data come from a section with this effect (repeatable; `pavescape effects` lists them)")
        ->expected(1)
        ->take_all();
    command->add_option("--noise", *noise, "standard deviation as a share of each value")->check(within(0.0, 10.0));
    command->footer("Example: pavescape twin grids/captif-p1-fwd.toml --noise 0.02 --seed 7");
    command->callback([=, &action] { action = [=] { return twin(*options, *noise, *effects); }; });
}

} // namespace explore::cli
