// The share of the residuals that each candidate could explain, before anything is fitted again.
#pragma once

#include "diagnose/workbench.h"

#include <functional>

namespace explore::diagnose {

// Of the range of a parameter or a size: closer to an end it is at it.
constexpr double at_end = 1e-4;
// Whether a fit presses a coordinate against an end of its range. pull: of the sum of squares, which falls against it.
inline bool is_pressed(double unit, double pull) {
    return (unit < at_end && pull > 0.0) || (unit > 1.0 - at_end && pull < 0.0);
}

// Directions that parameters follow, to first order: the span of the residuals' derivatives. Those that crossing the
// whole box moves by less than one standard deviation are not in it, nor are parameters that the fit presses against a
// bound.
class Mimicry {
public:
    // jacobian: residuals in standard deviations by unit coordinates.
    Mimicry(const Eigen::MatrixXd& jacobian, const std::vector<double>& unit, const Eigen::VectorXd& residuals);

    // The part that no parameter can follow.
    Eigen::VectorXd beyond(const Eigen::VectorXd& change) const;
    // The point of the cube at which the parameters make the best of these residuals.
    std::vector<double> best_response(const std::vector<double>& unit, const Eigen::VectorXd& residuals) const;
    int rank() const { return static_cast<int>(base_.cols()); }

private:
    Eigen::MatrixXd base_;    // orthonormal
    Eigen::MatrixXd inverse_; // parameters by residuals
};

// How large the largest of several statistics gets when there is nothing but noise.
class Family {
public:
    // directions: unit vectors, one column a statistic: minus their product with the residuals. Only the sign of
    // `sense` counts, where it is not 0. estimated: the noise is that of the residuals, beyond `mimicry`.
    // rows_of: residuals in standard deviations by standard normal deviates; without: the deviates.
    Family(const Eigen::MatrixXd& directions, const std::vector<int>& sense, const Mimicry& mimicry, bool estimated,
           std::uint64_t seed, const std::function<Eigen::VectorXd(Eigen::VectorXd)>& rows_of = {});

    // The chance that the largest statistic of the family reaches this under noise alone. Simulated with 10,000 draws;
    // below their reach by the bound of Bonferroni, which is close there.
    double p_value(double statistic) const;
    // The limit that the largest statistic exceeds with this probability.
    double threshold(double p) const;

private:
    std::vector<double> largest_; // descending
    std::vector<int> sense_;
};

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
    std::optional<Family> family;
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
