// pavescape plot: figures of a run as files.
#include "cli/commands.h"
#include "report/figures.h"
#include "report/run_folder.h"
#include "run/files.h"
#include "run/program.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::cli {
namespace {

struct PlotArguments {
    std::string folder, out;
    std::vector<std::string> figures, pair;
    report::FigureFormat format = report::FigureFormat::svg;
};

void check_gnuplot() {
    if (!run::run_program({"gnuplot", "--version"}).found) {
        throw pave::Error({}, "gnuplot draws the figures, and it is not installed", {},
                          "the package gnuplot-nox (Debian: apt-get install gnuplot-nox)");
    }
}

int plot(const PlotArguments& options) {
    const report::RunFolder folder = report::read_run_folder(options.folder, keepers_of_runs());
    const report::FolderContents contents{folder.results, folder.evaluations};
    std::vector<std::string> known;
    std::vector<report::Figure> figures;
    try {
        known = report::figures_of(contents);
        if (known.empty()) {
            throw pave::Error({.file = options.folder, .key = "RUN"}, "this run has no figures", {},
                              "the folder of a finished run");
        }
        for (const std::string& name : options.figures) {
            if (std::find(known.begin(), known.end(), name) == known.end()) {
                throw pave::Error({.file = options.folder, .key = "FIGURE"}, "this run has no such figure", name,
                                  pave::join(known));
            }
        }
        if (!options.pair.empty()) {
            figures = report::pair_figures(contents, {options.pair[0], options.pair[1]});
            known.clear();
        }
        for (const std::string& name : known) {
            const auto& wanted = options.figures;
            if (wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end()) {
                figures.push_back(report::make_figure(contents, name));
            }
        }
    } catch (const report::Json::exception& e) {
        throw pave::Error({.file = options.folder, .key = "RUN"},
                          "a result of this run is not as this program writes it", e.what(),
                          "results of this version: run the command again");
    }
    check_gnuplot();
    const std::string out = options.out.empty() ? options.folder + "/figures" : options.out;
    const std::string data = out + "/data";
    const std::string ending(report::figure_format_names[static_cast<int>(options.format)]);
    for (const report::Figure& figure : figures) {
        for (const report::DataTable& table : figure.tables) {
            run::write_file(data, table.name + ".csv", report::csv_text(table));
        }
        const std::string file = fmt::format("{}/{}.{}", out, figure.name, ending);
        run::write_file(data, figure.name + ".gnuplot", report::gnuplot_script(figure, options.format, file));
        const run::ProgramEnd end = run::run_program({"gnuplot", fmt::format("{}/{}.gnuplot", data, figure.name)});
        if (end.status != 0) {
            throw std::runtime_error(fmt::format("gnuplot could not draw {}: {}", file, end.output));
        }
        fmt::print("{}\n", file);
    }
    fmt::print("{}: the numbers of each figure (CSV) and its gnuplot script\n", data);
    return done;
}

} // namespace

void add_plot(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("plot", "figures of a run as files, for a paper, with their numbers as CSV");
    auto options = std::make_shared<PlotArguments>();
    command->add_option("RUN", options->folder, "folder of the run")->required();
    command->add_option("FIGURE", options->figures,
                        "landscape, landscape-close, profiles, fit, residuals, candidates, corrections, sensitivity, "
                        "posterior, deflections, back-calculation (default: all that the run has)");
    command
        ->add_option("--pair", options->pair, "two parameters, X,Y: their landscape large, also as a surface (unique)")
        ->delimiter(',')
        ->expected(2)
        ->type_name("X,Y");
    add_choice(*command, "--format", options->format, report::figure_format_names, "svg, pdf, png");
    command->add_option("--out", options->out, "folder for the figures (default: RUN/figures)")->type_name("DIR");
    command->footer("Example: pavescape plot output/captif-p1-unique-fwd landscape --format pdf");
    command->callback([=, &action] { action = [=] { return plot(*options); }; });
}

} // namespace explore::cli
