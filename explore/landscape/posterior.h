// The posterior of a calibration problem by tempered sequential Monte Carlo (Del Moral, Doucet, Jasra 2006, Journal of
// the Royal Statistical Society B 68), with its evidence.
//
// The prior is uniform over the box on the scales of its axes. Populations of particles, independent of each other,
// begin as draws from it; the power of the likelihood rises from 0 to 1 in steps that keep a share of effective
// weights, and after each the particles are drawn anew by their weights (systematic resampling) and moved by kernels
// that leave prior x likelihood^power as it is. The evidence is the product of the mean weights.
//
// Particles move in x = Phi^-1(unit coordinate): the prior is the standard normal there, and no bound is left. With
// residuals r, their derivatives J by x and the power b, the Gaussian around the Gauss-Newton step of a particle,
//     precision G = b J'J + 1,   centre m = x - G^-1 (b J'r + x),
// is the target itself where the problem is linear. A proposal keeps the share a of the way from the centre,
//     x' ~ N(m + a (x - m), (1 - a^2) G^-1),
// from the particle itself (the stochastic Newton step of Martin et al. 2012, SIAM Journal on Scientific Computing 34,
// for a = 0), or from another one, drawn from the half of the population that does not move: with the mean of the
// proposal densities of that half this is an independence kernel that crosses between modes and knows the shape of
// each. Both are corrected by the rule of Metropolis and Hastings. Points without an answer have no likelihood.
#pragma once

#include "landscape/allowed_share.h"
#include "landscape/marginals.h"
#include "run/engine.h"

namespace explore::landscape {

struct PosteriorSettings {
    int populations = 4;
    int particles = 500; // of each, even
    int rounds = 1;      // draws of each particle, moved at the power 1 until they have forgotten the one before
    double keep = 0.7;   // share of effective weights that a step of the power leaves
    int most_sweeps = 8; // of moves at one power
    int most_last = 40;  // at the power 1
    bool show_progress = true;
};

// Aims of a sample.
inline constexpr double most_rhat = 1.05;
inline constexpr double least_ess = 200.0;

struct Draw {
    std::vector<double> unit;
    std::vector<double> responses;
    double log_likelihood = 0.0;
};

struct Posterior {
    std::vector<Draw> draws;                             // by round and population; none: no answer in the box
    Descent descent;                                     // of the draws
    double log_evidence = 0.0, log_evidence_error = 0.0; // its standard error, from the populations
    std::vector<double> log_evidences;                   // of each population
    double answered = 0.0;                               // share of the prior that has an answer
    // The part of the prior that constraints leave, by the first draws, which are of the box: for constraints that read
    // responses. Nothing: no limit, or next to no draw meets them.
    std::optional<AllowedShare> allowed{};
    int powers = 0;            // steps, of the population that took most
    int sweeps = 0;            // of moves, of the same
    double accepted_own = 0.0; // share of proposals, from the particle itself, at the power 1
    double accepted_other = 0.0;
    std::string reason; // without draws
};

// problem: its log_density is the likelihood. The engine is that of the problem; its evaluations are those of one
// growing design, so a run that was cut off is continued. Nothing: interrupted.
std::optional<Posterior> posterior(run::Engine& engine, const problem::Problem& problem,
                                   const PosteriorSettings& settings, std::uint64_t seed);

} // namespace explore::landscape
