// Figures of a run as files, drawn by gnuplot.
#pragma once

#include "report/figures.h"

namespace explore::report {

struct DrawingOptions {
    std::string of;                   // what messages call the run: its folder
    std::vector<std::string> figures; // names; empty: all that there are
    std::optional<NamedPair> pair{};  // this pair of parameters alone, large
    FigureFormat format = FigureFormat::svg;
    std::string out; // the folder of the files; their numbers and scripts go into data/ there
};
// Paths of the files. Throws pave::Error for a run without figures, an unknown name and where gnuplot is not installed.
std::vector<std::string> draw_figures(const FolderContents& contents, const DrawingOptions& options);

} // namespace explore::report
