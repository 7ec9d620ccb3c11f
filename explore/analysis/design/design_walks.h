// Walks over the sets that the data accept, to the shortest and the longest life of each criterion.
//
// A step needs the misfit and the strains under the axle, whose run may cost a thousand times that of the readings. So
// strains are interpolated between a few complete runs (inference/kriging.h, with slopes): first at the minima and at
// the ends of the parameters' ranges, then at the ends that walks find, until these runs confirm the lives that were
// expected. An end that is reported comes from a complete run.
#pragma once

#include "analysis/common/session.h"
#include "analysis/design/design_life.h"
#include "landscape/uniqueness.h"

namespace explore::analysis {

// One end of a range of lives, and the sets on the way to it.
struct LifeEnd {
    double log_life = 0.0;
    double strain = 0.0;                                     // microstrain
    std::vector<std::pair<double, std::vector<double>>> way; // root of the rise of chi2, unit coordinates
    std::vector<double> log_lives;                           // along it

    // The set where the rise is that of this deviate, between those that were walked.
    std::vector<double> at(double deviate, double threshold) const;
};

struct LifeWalks {
    std::vector<LifeEnd> shortest, longest; // of each life
    std::size_t between = 0;                // complete runs between which strains were interpolated
    double off = 0.0;                       // largest error of the interpolation in ln(life) at an end
    std::int64_t computed = 0, kept = 0;    // by engines of its own
};

struct LifeWalkTask {
    Session& session;
    const landscape::Uniqueness& answer; // with an acceptance
    const CriticalPlaces& places;
    const std::vector<Life>& lives;
    const problem::Problem& fitted;     // the misfit's, without the places
    const problem::Problem& everything; // with them
    std::string settings;               // of the store
};

// best: of everything, at the best minimum. Nothing: interrupted.
std::optional<LifeWalks> walk_lives(const LifeWalkTask& task, const problem::Evaluation& best);

} // namespace explore::analysis
