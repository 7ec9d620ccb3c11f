// Readings that could be taken next, as the model predicts them.
#pragma once

#include "study/problems.h"

#include <Eigen/Core>

namespace explore::analysis {

// Expected information of one more reading about some unknowns, its noise normal (Lindley 1956, doi
// 10.1214/aoms/1177728069).
struct TellingReading {
    data::Reading reading; // value: as predicted; noise: assumed
    double bits = 0.0;
};

class CandidateReadings {
public:
    explicit CandidateReadings(const study::Study& study);

    // The responses of all candidates [SI] and, if requested, their derivatives by physical values.
    problem::Evaluation at(const std::vector<double>& unit, bool with_jacobian);
    // The responses at several points.
    std::vector<problem::Evaluation> at_many(std::span<const std::vector<double>> units);
    // With the values of `there` and the noise that is assumed of such values.
    std::vector<data::Reading> readings(const problem::Evaluation& there) const { return readings(there.responses); }
    std::vector<data::Reading> readings(const std::vector<double>& responses) const;
    // Derivatives of `there`, in standard deviations of these readings, by the unit coordinates: a row a candidate.
    Eigen::MatrixXd rows(const problem::Evaluation& there, const std::vector<double>& unit,
                         const std::vector<data::Reading>& readings) const;
    double forward_cpu_seconds() const { return forward_cpu_seconds_; }

private:
    study::Study list_;
    problem::Problem problem_;
    std::unique_ptr<problem::ForwardFunction::Workspace> workspace_;
    double forward_cpu_seconds_ = 0.0;
};

// Whether the study says that such a reading can be taken, or has taken one: such are proposed first.
bool is_at_hand(const study::Study& study, const data::Reading& reading);

// Each candidate's information on the unit coordinates but the first `others`, whatever those are, to first order about
// this point: ln(1 + s^2) / (2 ln 2) of all of them, s the standard deviation of its predicted value in units of the
// noise. Most bits first of those at hand, then of the others. Empty: no answer there. covariance: of all of them.
std::vector<TellingReading> telling_readings(const study::Study& study, const std::vector<double>& unit,
                                             const Eigen::MatrixXd& covariance, std::size_t others = 0);

// Each candidate's information on unknowns that are known by draws (inference/information_gain.h), in the same order.
// draws: a point of the unit cube a row, of equal weight; the model runs at 64 of them. Empty: interrupted, or it has
// no answer at more than half of those.
std::vector<TellingReading> telling_readings(const study::Study& study, const Eigen::MatrixXd& draws);

} // namespace explore::analysis
