// pavescape new: a commented study to start from, with readings to replace.
#include "analysis/studies/new_study.h"
#include "cli/commands.h"
#include "run/files.h"
#include "run/program.h"

#include <filesystem>
#include <fmt/format.h>

namespace explore::cli {
namespace {

struct NewArguments {
    std::string file, from, station, columns, layers;
    bool pulses = false;
    analysis::NewOptions study;
};

// Of a station, unless it is named.
std::string file_of(const NewArguments& options) {
    return options.file.empty() ? analysis::plain_name(std::filesystem::path(options.from).stem().string() +
                                                       (options.station.empty() ? "" : "-" + options.station)) +
                                      ".toml"
                                : options.file;
}

int write_study(const NewArguments& options) {
    analysis::NewOptions wanted = options.study;
    if (!options.layers.empty()) {
        wanted.layers = analysis::new_layers(options.layers);
    }
    const std::string file = file_of(options);
    const std::filesystem::path path(file);
    if (path.extension() != ".toml") {
        throw pave::Error({.file = file}, "not a name of a study", "\"" + path.extension().string() + "\"",
                          "NAME.toml");
    }
    const std::string stem = path.stem().string();
    if (stem != analysis::plain_name(stem)) { // it stands in the study
        throw pave::Error({.file = file}, "not a name of a study", "\"" + stem + "\"", "letters, digits, . _ -");
    }
    const std::string folder = path.has_parent_path() ? path.parent_path().string() : ".";
    const auto make = [&] {
        if (options.from.empty()) {
            return analysis::example_study(stem, wanted);
        }
        const data::FwdFile read = data::read_fwd(
            options.from, options.columns.empty() ? data::ColumnMap{} : data::read_column_map(options.columns));
        const auto study = options.pulses ? analysis::study_of_pulses : analysis::study_of_station;
        return study(stem, read, options.from, options.station, wanted);
    };
    const auto keep = [&](const std::string& name) {
        const auto there = std::filesystem::path(folder) / name;
        if (std::filesystem::exists(there)) {
            throw pave::Error({.file = there.string()}, "this file is there already", {}, "a name that is free");
        }
    };
    keep(stem + ".toml");
    keep(stem + ".csv");
    const analysis::NewStudy made = make();
    for (const auto& [name, text] : made.histories) {
        keep(name);
    }
    for (const auto& [name, text] : made.histories) {
        run::write_file(folder, name, text);
    }
    run::write_file(folder, stem + ".csv", made.readings);
    run::write_file(folder, stem + ".toml", made.study);
    fmt::print("written: {0}/{1}.toml and {0}/{1}.csv\nnext:    {2}pavescape check {3}\n", folder, stem,
               options.from.empty() || !wanted.layers.empty() ? "" : "state the layers of your road in it, then ",
               run::shell_word(fmt::format("{}/{}.toml", folder, stem)));
    return done;
}

} // namespace

void add_new(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("new", "writes a commented study to start from");
    auto options = std::make_shared<NewArguments>();
    auto* file = command->add_option("FILE", options->file, "NAME.toml; the readings go to NAME.csv beside it");
    auto* from = command
                     ->add_option("--from", options->from,
                                  "FWD file, of any format that survey reads: the study and the readings of a station")
                     ->type_name("FILE");
    command->add_option("--station", options->station, "its name or chainage (default: the first that can be used)")
        ->needs(from);
    command->add_option("--columns", options->columns, "names of the columns of a table, as for survey")->needs(from);
    command->add_flag("--pulses", options->pulses, "the time histories of its drops in place of their peaks")
        ->needs(from);
    command->add_option("--layers", options->layers,
                        "the layers from the top down with their mm, the last without: \"asphalt 120, base 300, "
                        "subgrade\"");
    command->add_flag("--linear", options->study.is_linear, "granular layers are linear, not stress-dependent");
    command
        ->add_option("--gauges", options->study.gauges_mm,
                     "strain gauges under a wheel in place of a deflection bowl: their depths [mm], z1,z2,...")
        ->delimiter(',')
        ->check(within(37.5, 20000.0))
        ->excludes(from);
    command->footer("Example: pavescape new road.toml\n"
                    "         pavescape new station.toml --from grids/road-north.f25 --layers \"asphalt 90, base 280, "
                    "subgrade\" --linear");
    command->callback([=, &action] {
        if (file->count() == 0 && from->count() == 0) {
            throw CLI::RequiredError("FILE.toml, or --from FILE");
        }
        action = [=] { return write_study(*options); };
    });
}

} // namespace explore::cli
