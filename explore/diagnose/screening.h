// The share of the residuals that each candidate could explain, before anything is fitted again.
#pragma once

#include "diagnose/workbench.h"
#include "inference/max_statistic.h"
#include "inference/nuisance.h"

namespace explore::diagnose {

struct Screened {
    std::string impossible; // why it cannot be judged; empty: it can
    Shift shift;            // of the model with it, at the null size
    // Of the residuals by the unit coordinate of the size, as far as no parameter follows it: the derivative at the
    // null size, or where that is none, and for a second effect, the difference to the typical one.
    Eigen::VectorXd change;
    int sense = 0;             // +1: only larger sizes than null exist, -1: only smaller
    double score = 0.0;        // > 0: the data want a larger size [standard deviations]
    double p_familywise = 1.0; // of the score among all candidates
    // Beside an earlier candidate of the same effect: the same in every reading; the same as far as no parameter
    // follows it, so that linear theory cannot tell the two apart.
    bool identical = false;
    bool duplicate = false;
    // Starts for a fit, by the sum of squares predicted there: unit coordinates with the size.
    struct Start {
        std::vector<double> unit;
        double predicted = 0.0;
    };
    std::vector<Start> starts;
    double predicted = 0.0; // lowest sum of squares
};

struct Screening {
    OnCoarse base;
    std::vector<Screened> items; // one a candidate; those among the base's members have no change
    double threshold = 0.0;      // what the largest |score| exceeds in 5 % of cases under noise alone
    double p_familywise = 1.0;   // of the largest score
    std::optional<inference::MaxStatistic> family;
};

// All on the coarse mesh. base: what the candidates are added to. variance: of a residual. scanned: so many candidates,
// those whose derivative and typical size promise most, are computed at several sizes, where fits may start. number: of
// the first evaluation that is kept; those up to number + 20 are its own. first: the screening of the baseline, where
// the base is another model. Nothing: interrupted.
std::optional<Screening> screen(Workbench& bench, const Model& base, const std::vector<Candidate>& candidates,
                                double variance, bool estimated, std::uint64_t seed, std::size_t scanned, int number,
                                const Screening* first = nullptr);

// The members of a model with one candidate more, in increasing order.
Members with_member(Members members, std::size_t candidate);
// A point of a model with a size more at this index.
std::vector<double> with_size(std::vector<double> unit, std::size_t at, double size);
// Index of a candidate's size among the parameters of a model.
std::size_t size_index(Workbench& bench, const Members& members, std::size_t candidate);

} // namespace explore::diagnose
