// Is the answer unique? Everything that is computed to say so.
#pragma once

#include "landscape/conflict.h"
#include "landscape/directions.h"
#include "landscape/merge_tree.h"
#include "landscape/prior_influence.h"
#include "landscape/profile.h"
#include "landscape/unseen.h"

namespace explore::landscape {

// Chains of an engine that are none of the analysis' own have start numbers from here on.
inline constexpr int first_start_of_others = 100'000'000;

struct UniquenessTask {
    // Residuals in units of their noise where it is stated. The first computes what is fitted, the second every
    // response.
    const problem::Problem& fitted;
    const problem::Problem& everything;
    run::Engine& fitted_engine;
    run::Engine& everything_engine;
    std::vector<std::size_t> outputs;             // responses whose range is wanted
    std::vector<std::vector<std::size_t>> groups; // terms of the misfit of each group of data
    std::uint64_t seed = 1;
    // Of a quicker model of what is fitted: the sample and the searches are its, then searches by fitted_engine begin
    // at what it found. nullptr: all are fitted_engine's.
    run::Engine* explorer = nullptr;
    bool outputs_cost_more = false; // a run of everything costs far more than one of what is fitted
};

struct UniquenessSettings {
    int explore = 128; // points of the sample, with derivatives
    int verify = 24;   // independent starts without a new minimum
    int max_searches = 400;
    int max_evaluations = 80; // of one search
};

// How a local search ended.
enum class EndKind {
    interior,  // a minimum inside the box
    bound,     // a minimum on a bound
    valley,    // in a flat valley: further along it the misfit is the same within the noise
    unfinished // no answer at the start, or the limit of evaluations
};
inline constexpr std::string_view end_kind_names[] = {"interior minimum", "minimum on a bound", "valley", "unfinished"};

struct ClassifiedEnd {
    int start = 0;
    EndKind kind = EndKind::unfinished;
    std::vector<BoundMet> bounds; // that it lies on
    std::string unfinished;       // why it ended before a minimum
    int minimum = -1;             // index of the minimum it belongs to
    int evaluations = 0;
};

// The values of a parameter or an output over every parameter set the data accept.
struct Range {
    double low = 0.0, high = 0.0; // parameter: physical; output: SI
    std::vector<Branch> branches; // down and up from every distinct minimum the data accept
    WalkEnd low_end = WalkEnd::limit, high_end = WalkEnd::limit;
    std::vector<BoundMet> low_bounds, high_bounds;    // parameters that lie on a bound at the ends
    std::vector<std::size_t> low_limits, high_limits; // limits that hold back there
    std::vector<double> low_set, high_set;            // parameters of the sets at the ends, physical
};

enum class ProfileKind { bounded, one_sided, flat, incomplete };
inline constexpr std::string_view profile_kind_names[] = {"bounded", "bounded on one side", "flat", "incomplete"};
ProfileKind kind_of(const Range& range);

// Two minima and the pass between them: at most this far above the best minimum.
struct MinimaPass {
    std::size_t a = 0, b = 0;
    Pass pass;
};

// The lowest sample of every cell of a pair of parameters: the others give way.
struct Projection {
    std::size_t x = 0, y = 0;
    int cells = 0;              // along each axis
    std::vector<double> misfit; // cells x cells, x fastest; not a number: no answer there, or not visited
};

enum class Verdict { unique, non_unique, undecided };
inline constexpr std::string_view verdict_names[] = {"unique", "non-unique", "undecided"};

struct Uniqueness {
    Verdict verdict = Verdict::undecided;
    bool alternatives = false; // minima apart that the data accept
    // A continuous set that reaches over more than half of a parameter's range, or over a fifth between bounds.
    bool valley = false;
    std::vector<std::size_t> wide;    // parameters that alone make it so, though the data end their range on both sides
    std::vector<std::string> missing; // why undecided

    search::Design sample;
    std::vector<problem::Evaluation> explored;
    std::vector<SampledMinimum> tree;
    std::vector<Minimum> minima; // best first
    std::vector<ClassifiedEnd> ends;
    Unseen unseen;
    std::string confirmation; // what a second method says of the minima, in words
    std::optional<Acceptance> acceptance;
    std::vector<std::size_t> accepted; // indices of the minima the data accept
    std::vector<std::size_t>
        alternative_of;             // accepted minima that no acceptable way joins to a lower one (first of each)
    std::vector<MinimaPass> passes; // between accepted minima
    Directions directions;          // at the best minimum
    std::vector<Branch> traces;     // two, along the flattest direction; empty: none is flat
    std::vector<Range> parameters;
    std::vector<Range> outputs;
    std::optional<PriorInfluence> priors; // with priors
    std::optional<Conflict> conflict;     // with two groups of data or more
    std::vector<Projection> projections;
};

// Nothing: interrupted.
std::optional<Uniqueness> uniqueness(const UniquenessTask& task, const UniquenessSettings& settings);

} // namespace explore::landscape
