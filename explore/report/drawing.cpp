#include "report/drawing.h"

#include "base/error.h"
#include "base/text.h"
#include "run/files.h"
#include "run/program.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace explore::report {
namespace {

void check_gnuplot() {
    if (!run::run_program({"gnuplot", "--version"}).found) {
        throw pave::Error({}, "gnuplot draws the figures, and it is not installed", {},
                          "the package gnuplot-nox (Debian: apt-get install gnuplot-nox)");
    }
}

std::vector<Figure> wanted_figures(const FolderContents& contents, const DrawingOptions& options) {
    const std::vector<std::string> known = figures_of(contents);
    if (known.empty()) {
        throw pave::Error({.file = options.of, .key = "RUN"}, "this run has no figures", {},
                          "the folder of a finished run");
    }
    const auto has = [](const std::vector<std::string>& names, const std::string& name) {
        return std::find(names.begin(), names.end(), name) != names.end();
    };
    for (const std::string& name : options.figures) {
        if (!has(known, name)) {
            throw pave::Error({.file = options.of, .key = "FIGURE"}, "this run has no such figure", name,
                              pave::join(known));
        }
    }
    std::vector<Figure> figures;
    if (options.pair) {
        figures = pair_figures(contents, *options.pair);
    }
    for (const std::string& name : known) {
        if (!options.pair && (options.figures.empty() || has(options.figures, name))) {
            figures.push_back(make_figure(contents, name));
        }
    }
    return figures;
}

// At once: whoever reads the file meets the old picture or the new one, never a part.
void draw(const Figure& figure, FigureFormat format, const std::string& file) {
    const run::TemporaryFolder place;
    const std::string drawn = place.path() + "/drawn";
    run::write_file(place.path(), "script", gnuplot_script(figure, format, drawn));
    const run::ProgramEnd end = run::run_program({"gnuplot", place.path() + "/script"});
    std::ifstream picture(drawn, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(picture), {}};
    if (end.status != 0 || bytes.empty()) {
        throw std::runtime_error(fmt::format("gnuplot could not draw {}: {}", file, end.output));
    }
    const std::filesystem::path path(file);
    run::write_file(path.parent_path().string(), path.filename().string(), bytes);
}

} // namespace

std::vector<std::string> draw_figures(const FolderContents& contents, const DrawingOptions& options) {
    std::vector<Figure> figures;
    try {
        figures = wanted_figures(contents, options);
    } catch (const Json::exception& e) {
        throw pave::Error({.file = options.of, .key = "RUN"}, "a result of this run is not as this program writes it",
                          e.what(), "results of this version: run the command again");
    }
    check_gnuplot();
    const std::string data = options.out + "/data";
    const std::string ending(figure_format_names[static_cast<int>(options.format)]);
    std::vector<std::string> files;
    for (const Figure& figure : figures) {
        for (const DataTable& table : figure.tables) {
            run::write_file(data, table.name + ".csv", csv_text(table));
        }
        const std::string file = fmt::format("{}/{}.{}", options.out, figure.name, ending);
        run::write_file(data, figure.name + ".gnuplot", gnuplot_script(figure, options.format, file));
        draw(figure, options.format, file);
        files.push_back(file);
    }
    return files;
}

} // namespace explore::report
