// pavescape twin: synthetic data from the study, in the layout of its own measurements.
#include "base/random.h"
#include "base/text.h"
#include "cli/common.h"
#include "data/csv.h"
#include "pavement/effects/effect.h"
#include "run/message.h"

#include <charconv>
#include <fmt/format.h>

namespace explore::cli {
namespace {

// "NAME=SIZE"
study::Study with_effect(study::Study study, const std::string& text) {
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
    return study::with_effect(std::move(study), text.substr(0, equals), size, place);
}

int twin(const CommonOptions& options, double noise, const std::vector<std::string>& effects) {
    study::Study study = study::load_study(options.study);
    for (const std::string& effect : effects) {
        study = with_effect(std::move(study), effect);
    }
    if (study.measurements.empty()) {
        throw pave::Error({.file = study.file, .key = "data"}, "a twin needs a layout of sensors", {},
                          "[data] files = [...]: their values are replaced, their places kept");
    }
    const pave::pavement::ForwardModel model(study.model);
    const auto outcome = model.run(study.model, {}, *model.make_workspace());
    if (!outcome) {
        if (options.json) {
            fmt::print("{}\n", report::json_text({{"status", std::string(to_string(outcome.status()))},
                                                  {"reason", outcome.failure().reason}}));
        }
        run::message("pavescape: {}: {}\n", to_string(outcome.status()), outcome.failure().reason);
        return computation_failed;
    }
    const pave::RandomStream random(options.seed, 1);
    std::string text = fmt::format("# Synthetic: {}, noise {:g} of each value, seed {}\n"
                                   "# {}\n",
                                   pave::printable(study.title), noise, options.seed, sign_convention);
    for (const auto& applied : study.model.effects) {
        text += fmt::format("# effect: {} = {} [{}]\n", applied.effect->name, applied.size, applied.effect->unit);
    }
    text += fmt::format("{}\n", data::measurement_header());
    report::Json rows = report::Json::array();
    for (std::size_t i = 0; i < study.measurements.size(); ++i) {
        const auto& m = study.measurements[i];
        const double exact = outcome->values[i] / m.unit.to_si;
        const double value = exact * (1.0 + noise * random.normal(i));
        const double sigma = noise * std::abs(exact);
        text += fmt::format("{},{},{},{},{},{},{},{},{}\n", data::csv_cell(m.load), m.quantity, m.x_mm, m.y_mm,
                            m.depth_mm, m.gauge_mm, value, m.unit.name, noise > 0.0 ? fmt::format("{}", sigma) : "");
        rows.push_back({{"load", m.load},
                        {"quantity", m.quantity},
                        {"x_mm", m.x_mm},
                        {"y_mm", m.y_mm},
                        {"depth_mm", m.depth_mm},
                        {"gauge_mm", m.gauge_mm},
                        {"value", value},
                        {"exact", exact},
                        {"unit", std::string(m.unit.name)}});
    }
    const std::string folder = options.folder(study);
    write_file(folder, "twin.csv", text);
    if (options.json) {
        fmt::print("{}\n", report::json_text({{"file", folder + "/twin.csv"}, {"measurements", rows}}));
    } else {
        fmt::print("{}", text);
        run::message("written to {}/twin.csv\n", folder);
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
