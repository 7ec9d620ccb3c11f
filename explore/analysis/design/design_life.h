// Criteria at the responses of a study: where their strains are read, and the life that those mean.
#pragma once

#include "problem/problem.h"
#include "study/criteria.h"
#include "study/seasons.h"

namespace explore::analysis {

// A study that reads, as outputs, every strain that its criteria may mean: under, beside and between the wheels; then
// the same in every season, which seasonal() computes.
struct CriticalPlaces {
    study::Study study;
    std::vector<study::Season> seasons;
    std::size_t first = 0;                            // of the readings that were added, behind the study's own
    std::size_t count = 0;                            // of those of a season; those of the next follow
    std::vector<std::vector<std::size_t>> candidates; // readings of each criterion; of a plate: the two deflections

    // Of a candidate in season s.
    std::size_t in_season(std::size_t candidate, std::size_t s) const { return candidate + (s + 1) * count; }
};
// Throws pave::Error.
CriticalPlaces critical_places(study::Study study, const std::vector<study::Criterion>& criteria);

// The problem of such a study with the responses of its seasons.
problem::Problem seasonal(problem::Problem problem, const CriticalPlaces& places);

// A criterion as a function of the parameters and the responses of such a study. The places must outlive it. With
// seasons its life is that at which the damage of all of them is 1 (Miner 1945, J. Appl. Mech. 12, A159):
// 1/N = sum of share/N of each.
class Life {
public:
    Life(const CriticalPlaces& places, const study::Criterion& criterion, std::vector<std::size_t> candidates);

    const study::Criterion& criterion() const { return criterion_; }
    // The candidate with the shortest life, which without seasons is that with the largest strain.
    std::size_t critical(const pave::pavement::Case& at, const std::vector<double>& responses) const;
    // At a candidate, at the time of the readings [microstrain], positive as the criterion means it; of a plate not a
    // number.
    double strain(std::size_t candidate, const std::vector<double>& responses) const;
    // ln of the allowable repetitions there; infinity: nothing strains it.
    double log_repetitions(std::size_t candidate, const pave::pavement::Case& at,
                           const std::vector<double>& responses) const;
    // The same with every strain there this many times as large.
    double log_repetitions(std::size_t candidate, const pave::pavement::Case& at, std::vector<double> responses,
                           double ratio) const;
    // At the worst candidate.
    double log_repetitions(const pave::pavement::Case& at, const std::vector<double>& responses) const {
        return log_repetitions(critical(at, responses), at, responses);
    }
    // Of those at a candidate by the unit coordinates. e: with jacobian.
    Eigen::VectorXd gradient(std::size_t candidate, const std::vector<double>& unit,
                             const problem::Evaluation& e) const;
    // The case at physical values of the parameters.
    pave::pavement::Case at(const std::vector<double>& parameters) const;
    double modulus(const pave::pavement::Case& at) const; // that its law reads [MPa]

private:
    // Its readings at a candidate, in all seasons.
    std::vector<std::size_t> reads(std::size_t candidate) const;
    // Of what is read at `strained`, or of the two deflections; softer: the asphalt's modulus over that of `at`.
    double log_repetitions_of(std::size_t candidate, std::size_t strained, double softer,
                              const pave::pavement::Case& at, const std::vector<double>& responses) const;

    const CriticalPlaces& places_;
    const study::Study& study_;
    study::Criterion criterion_;
    std::vector<std::size_t> candidates_;
};

} // namespace explore::analysis
