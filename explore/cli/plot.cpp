// pavescape plot: figures of a run as files.
#include "cli/commands.h"
#include "report/drawing.h"
#include "report/run_folder.h"

#include <fmt/format.h>

namespace explore::cli {
namespace {

struct PlotArguments {
    std::string folder;
    std::vector<std::string> pair;
    report::DrawingOptions drawing{};
};

int plot(const PlotArguments& options) {
    const report::RunFolder folder = report::read_run_folder(options.folder, keepers_of_runs());
    report::DrawingOptions drawing = options.drawing;
    drawing.of = options.folder;
    if (!options.pair.empty()) {
        drawing.pair = {options.pair[0], options.pair[1]};
    }
    if (drawing.out.empty()) {
        drawing.out = options.folder + "/figures";
    }
    for (const std::string& file : report::draw_figures({folder.results, folder.evaluations}, drawing)) {
        fmt::print("{}\n", file);
    }
    fmt::print("{}/data: the numbers of each figure (CSV) and its gnuplot script\n", drawing.out);
    return done;
}

} // namespace

void add_plot(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("plot", "figures of a run as files, for a paper, with their numbers as CSV");
    auto options = std::make_shared<PlotArguments>();
    command->add_option("RUN", options->folder, "folder of the run")->required();
    command->add_option("FIGURE", options->drawing.figures,
                        "landscape, landscape-close, profiles, fit, residuals, candidates, corrections, sensitivity, "
                        "posterior, predictive, prior-predictive, life, overlay, deflections, back-calculation "
                        "(default: all that the run has)");
    command
        ->add_option("--pair", options->pair, "two parameters, X,Y: their landscape large, also as a surface (unique)")
        ->delimiter(',')
        ->expected(2)
        ->type_name("X,Y");
    add_choice(*command, "--format", options->drawing.format, report::figure_format_names, "of the files");
    command->add_option("--out", options->drawing.out, "folder for the figures (default: RUN/figures)")
        ->type_name("DIR");
    command->footer("Example: pavescape plot output/captif-p1-unique-fwd landscape --format pdf");
    command->callback([=, &action] { action = [=] { return plot(*options); }; });
}

} // namespace explore::cli
