#include "report/best_so_far.h"

#include "base/text.h"
#include "report/table.h"
#include "run/progress.h"

#include <fmt/format.h>

namespace explore::report {

using pave::counted;
using pave::figure;

Json best_so_far_json(const study::Study& study, const analysis::BestSoFar& found, double seconds) {
    Json best = nullptr;
    if (found.best) {
        best = {{"misfit", found.best->misfit},
                {"parameters", parameters_json(study.space, found.best->parameters)},
                {"status", std::string(pave::to_string(found.best->status))}};
        if (found.chi2) {
            best["chi2"] = *found.chi2;
            best["dof"] = found.degrees_of_freedom;
        }
    }
    return {{"study", study_json(study)},
            {"complete", false},
            {"reason", "the time was over before the analysis was finished"},
            {"time_s", seconds},
            {"evaluations", found.evaluations},
            {"answered", found.answered},
            {"explored", found.is_explored},
            {"best", std::move(best)}};
}

std::string best_so_far_text(const study::Study& study, const analysis::BestSoFar& found, double seconds,
                             std::string_view command, const std::string& folder) {
    std::string text =
        fmt::format("NOT FINISHED: the time of {} for {} is over. {}", run::duration_words(seconds), command,
                    found.evaluations == 0
                        ? std::string("No point has been computed yet.\n")
                        : fmt::format("{} computed so far{}.\n",
                                      counted(static_cast<std::size_t>(found.evaluations), "point is", "points are"),
                                      found.is_explored ? ", by what explores in place of the study's own model" : ""));
    if (found.best) {
        text += fmt::format("The best of them, with a misfit of {}{}; it may be no minimum, and nothing is said of its "
                            "errors:\n",
                            figure(found.best->misfit),
                            found.chi2
                                ? fmt::format(" (chi2 = {} with {})", figure(*found.chi2),
                                              counted(static_cast<std::size_t>(std::max(0, found.degrees_of_freedom)),
                                                      "degree of freedom", "degrees of freedom"))
                                : "");
        Table table({"parameter", "value"});
        for (std::size_t k = 0; k < study.space.axes.size(); ++k) {
            table.add({study.space.axes[k].name, figure(found.best->parameters[k])});
        }
        text += table.text();
    } else if (found.evaluations > 0) {
        text += "None of them has an answer that meets the constraints.\n";
    }
    return text + fmt::format("All of it is kept in {}: the same command goes on from there.\n", folder);
}

} // namespace explore::report
