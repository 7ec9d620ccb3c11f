// How much each parameter moves each response: at one point (elasticities) and over the whole box (Sobol's indices).
#pragma once

#include "problem/problem.h"

#include <cstdint>

namespace explore::landscape {

// d ln(response) / d ln(parameter) = parameter / response * d(response)/d(parameter) of an evaluation with jacobian:
// percent of the response for one percent of the parameter. Responses x parameters; not a number where the response or
// the parameter is zero.
Eigen::MatrixXd elasticities(const problem::Evaluation& evaluation);

// An estimate with the 95 % interval of its bootstrap.
struct Estimate {
    double value = 0.0;
    double low = 0.0;
    double high = 0.0;
};

// Of one response y over the box, its parameters independent and uniform in unit coordinates:
//   first[i] = Var(E[y | parameter i]) / Var(y): the share of the variance that parameter i makes alone;
//   total[i] = E[Var(y | all but i)] / Var(y): that share with every interaction that parameter i has part in;
//   interactions = 1 - sum first[i]: the share that no parameter makes alone.
// Not numbers when the response does not vary.
struct SobolIndices {
    double mean = 0.0;     // SI
    double variance = 0.0; // SI squared
    std::vector<Estimate> first, total;
    Estimate interactions;
};

struct GlobalSensitivity {
    std::size_t rows = 0;
    std::size_t complete = 0;            // rows whose every run has an answer; the others are left out whole
    std::vector<SobolIndices> responses; // empty with fewer than two complete rows
};

// From the evaluations of search::radial (row j: A_j, B_j, A_j with coordinate i of B_j), for the responses with these
// indices. With y centred by its mean and V its variance over A and B (Saltelli et al. 2010, Computer Physics
// Communications 181, table 2):
//   first[i] = 1/N sum y(B)_j (y(AB_i)_j - y(A)_j) / V       formula (b), Saltelli et al. (2010)
//   total[i] = 1/(2N) sum (y(A)_j - y(AB_i)_j)^2 / V         formula (f), Jansen (1999, same journal, 117)
// The intervals are percentiles of 1000 resamples of whole rows. They take the rows for independent; rows of a Sobol
// sequence are spread better than that, so they are on the wide side.
GlobalSensitivity sobol_indices(const std::vector<problem::Evaluation>& evaluations, std::size_t dimension,
                                const std::vector<std::size_t>& responses, std::uint64_t seed);

} // namespace explore::landscape
