// Criteria at the responses of a study: where their strains are read, and the life that those mean.
#pragma once

#include "problem/problem.h"
#include "study/criteria.h"

namespace explore::analysis {

// A study that reads, as outputs, every strain that its criteria may mean: under, beside and between the wheels.
struct CriticalPlaces {
    study::Study study;
    std::size_t first = 0;                            // of the readings that were added, behind the study's own
    std::vector<std::vector<std::size_t>> candidates; // readings of each criterion; of a plate: the two deflections
};
// Throws pave::Error.
CriticalPlaces critical_places(study::Study study, const std::vector<study::Criterion>& criteria);

// A criterion as a function of the parameters and the responses of such a study. The study must outlive it.
class Life {
public:
    Life(const study::Study& study, const study::Criterion& criterion, std::vector<std::size_t> candidates);

    const study::Criterion& criterion() const { return criterion_; }
    // The candidate with the largest strain.
    std::size_t critical(const std::vector<double>& responses) const;
    // At a candidate [microstrain], positive as the criterion means it; of a plate not a number.
    double strain(std::size_t candidate, const std::vector<double>& responses) const;
    // ln of the allowable repetitions there; infinity: nothing strains it.
    double log_repetitions(std::size_t candidate, const pave::pavement::Case& at,
                           const std::vector<double>& responses) const;
    // The same of a strain.
    double log_repetitions(double strain, const pave::pavement::Case& at) const;
    // At the worst candidate.
    double log_repetitions(const pave::pavement::Case& at, const std::vector<double>& responses) const {
        return log_repetitions(critical(responses), at, responses);
    }
    // Of those at a candidate by the unit coordinates. e: with jacobian.
    Eigen::VectorXd gradient(std::size_t candidate, const std::vector<double>& unit,
                             const problem::Evaluation& e) const;
    // The case at physical values of the parameters.
    pave::pavement::Case at(const std::vector<double>& parameters) const;

private:
    double modulus(const pave::pavement::Case& at) const;

    const study::Study& study_;
    study::Criterion criterion_;
    std::vector<std::size_t> candidates_;
};

} // namespace explore::analysis
