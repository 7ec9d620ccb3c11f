#include "analysis/design/design_next.h"

#include "analysis/common/candidate_readings.h"
#include "base/text.h"
#include "landscape/next_measurement.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Axes that a core tells: the modulus of a linear top layer above others.
std::vector<std::size_t> cored_axes(const study::Study& study) {
    std::vector<std::size_t> axes;
    for (std::size_t k = 0; k < study.parameters.size(); ++k) {
        const auto& p = study.parameters[k];
        const auto& law = *study.model.layers[0].law;
        if (p.law_index && p.owner == 0 && study.model.layers.size() > 1 && !law.stress_dependent() &&
            law.parameters()[*p.law_index].key == "modulus_MPa") {
            axes.push_back(k);
        }
    }
    return axes;
}

} // namespace

std::string NarrowingStep::words() const {
    return reading ? fmt::format("{} (noise {} {} assumed)", reading->words(),
                                 pave::figure(reading->in_unit(reading->noise.absolute)), reading->unit.name)
                   : fmt::format("a core that gives {} to {:.0f} %", parameter, 100.0 * core_error);
}

std::vector<NarrowingStep> narrowing_steps(const study::Study& study, const problem::Problem& fitted,
                                           const landscape::Acceptance& acceptance, const landscape::Minimum& best,
                                           const VectorXd& gradient) {
    CandidateReadings candidates(study);
    const auto here = candidates.at(best.unit, true);
    if (!here.converged()) {
        return {};
    }
    const std::vector<data::Reading> readings = candidates.readings(here);
    const MatrixXd of_readings = candidates.rows(here, best.unit, readings);
    const std::vector<std::size_t> cores = cored_axes(study);
    MatrixXd rows = MatrixXd::Zero(of_readings.rows() + static_cast<Index>(cores.size()), gradient.size());
    rows.topRows(of_readings.rows()) = of_readings;
    for (std::size_t c = 0; c < cores.size(); ++c) {
        const problem::Axis& axis = study.space.axes[cores[c]];
        const double unit = best.unit[cores[c]];
        rows(of_readings.rows() + static_cast<Index>(c), static_cast<Index>(cores[c])) =
            axis.d_physical(unit) / (core_error * axis.physical(unit));
    }
    std::vector<NarrowingStep> steps;
    for (const landscape::CandidateEffect& e :
         landscape::rank_candidates(fitted, acceptance, best, rows, gradient.transpose())) {
        NarrowingStep step{.left = e.predictions[0]};
        if (e.candidate < readings.size()) {
            step.reading = readings[e.candidate];
            step.is_at_hand = is_at_hand(study, *step.reading);
        } else {
            step.parameter = study.space.axes[cores[e.candidate - readings.size()]].name;
        }
        if (std::isfinite(step.left)) {
            steps.push_back(std::move(step));
        }
    }
    std::stable_sort(steps.begin(), steps.end(), [](const auto& a, const auto& b) { return a.left < b.left; });
    return steps;
}

} // namespace explore::analysis
