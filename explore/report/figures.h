// The figures of a run's folder, for a paper.
#pragma once

#include "report/figure.h"
#include "report/json.h"

namespace explore::report {

inline constexpr double none = std::numeric_limits<double>::quiet_NaN();
// Of JSON; none where it is not a number.
double number_or_none(const Json& value);

// The content of a folder. results: {command: its JSON}; evaluations: as in report/page.h, or null.
struct FolderContents {
    Json results;
    Json evaluations;
};

// Names of the figures that can be made of it, in their order: "landscape", "landscape-close", "profiles", "fit",
// "residuals", "candidates", "corrections", "sensitivity", "posterior", "predictive", "prior-predictive", "life",
// "overlay", "deflections", "back-calculation".
std::vector<std::string> figures_of(const FolderContents& contents);
// One of them. Throws Json::exception for results that are not those of this program.
Figure make_figure(const FolderContents& contents, const std::string& name);

// Two parameters, either first.
struct NamedPair {
    std::string a, b;
    bool is(const std::string& x, const std::string& y) const { return (a == x && b == y) || (a == y && b == x); }
};
// The corner figure: every pair of parameters below the diagonal, each alone on it. close: around what the data accept,
// not the whole box; only: this pair alone, large.
Figure profiled_landscape_figure(const Json& unique, bool close, const std::optional<NamedPair>& only = {});
// Whether what the data accept is so small a part of the box that it is drawn once more, close.
bool has_close_landscape(const Json& unique);
// The landscape of one pair as a surface over it: the rise of chi2, cut off well above what the data accept.
Figure surface_figure(const Json& unique, const NamedPair& pair);
// One pair of the landscape of `unique` large: its contours, and the surface. Throws pave::Error (its place filled by
// the caller) where there is none.
std::vector<Figure> pair_figures(const FolderContents& contents, const NamedPair& pair);
// The same of points that were computed: the lowest misfit in the cells of each pair. minima: [{"parameters"}].
Figure sampled_landscape_figure(const Json& evaluations, const Json& parameters, const Json& minima);
// The posterior of `sample`: the draws over every pair with the region that holds 95 % of them, each parameter with
// its prior.
Figure posterior_figure(const Json& sample);
// The distribution of every life of `design`, with what is required of it dashed; the overlay against the reliability.
Figure life_figure(const Json& design);
Figure overlay_figure(const Json& design);
// The readings against the ranges in which draws predict them. readings: as report/predictive.h writes them.
Figure predictive_figure(const Json& readings, const std::string& name);
// Along the road of `survey` or `road`: deflections and indices of every station; parameters and outputs with their 95
// % ranges, and how well they fit. Above them what is worth a look: stations without a result, outliers, remarks.
Figure deflections_figure(const Json& survey);
Figure back_calculation_figure(const Json& survey);
// Rises of chi2 along every parameter and output.
Figure profiles_figure(const Json& unique);

// Readings with the values of one model or two: {"load", "quantity", "x_mm", "y_mm", "depth_mm", "measured", "unit"}
// and where known "sigma", "held_out"; values and residuals (standard deviations) in the order of the readings.
struct ComparedModel {
    std::string name;
    std::vector<double> values, residuals; // not a number: none
    // Between the readings, as in report/curves.h; where there is none, bowls are joined by a monotone cubic (Steffen
    // 1990, Astronomy and Astrophysics 239), which the legend says, other readings by straight lines.
    Json curves = Json::array();
};
// The gain of each effect alone, and corrections over their places, of a diagnosis.
Figure candidates_figure(const Json& diagnose);
Figure corrections_figure(const Json& diagnose);
// Sobol's indices of every response, with their 95 % intervals.
Figure sensitivity_figure(const Json& sensitivity);

// layers: {"name", "thickness_mm"}, top down, whose borders are drawn where readings stand over the depth.
Figure fit_figure(const Json& readings, const std::vector<ComparedModel>& models, const Json& layers = Json::array());
Figure residuals_figure(const Json& readings, const std::vector<ComparedModel>& models);

} // namespace explore::report
