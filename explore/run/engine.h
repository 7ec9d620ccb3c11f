// Evaluations in parallel by run number, each kept as it comes; local searches in parallel by start.
//
// Results depend on the run alone, never on the number of threads or on what was there before: a run that is
// cut off and continued ends with the same bits.
#pragma once

#include "optimise/local_search.h"
#include "run/interrupt.h"
#include "run/store.h"
#include "search/design.h"

namespace explore::run {

struct EngineSettings {
    int threads = 0;           // 0: as many as the machine has
    bool show_progress = true; // on a terminal
};

// A finished local search.
struct Endpoint {
    int start = 0;            // its number
    std::vector<double> from; // unit coordinates
    optimise::SearchResult search;
    problem::Evaluation evaluation; // of search.unit, with jacobian
};

struct Tally {
    std::int64_t computed = 0; // by this process
    std::int64_t kept = 0;     // were in the store
    double seconds = 0.0;
    double forward_cpu_seconds = 0.0; // processor time of the forward runs, all threads of this process
};

// Evaluations that follow from each other: what a chain asks for next depends on what it was answered.
// A chain that was cut off is replayed: it asks for the same points again and is answered from the store until it gets
// to new ones.
class Chain {
public:
    virtual ~Chain() = default;
    // Throws Interrupted, and pave::Error when the store fails. Derivatives may be there unasked.
    virtual problem::Evaluation at(std::span<const double> unit, bool with_jacobian) = 0;
    problem::Evaluation at(std::span<const double> unit) { return at(unit, true); }
};

class Engine {
public:
    // store may be nullptr: nothing is kept. Both must outlive the engine.
    Engine(const problem::Problem& problem, Store* store, int run, EngineSettings settings);
    ~Engine();

    // Evaluations of the design's points from number `first` on, in run order. Nothing: interrupted (what was finished
    // is in the store).
    std::optional<std::vector<problem::Evaluation>> evaluate(const search::Design& design, bool with_jacobian = false,
                                                             std::size_t first = 0);

    // Local searches from these points of the unit cube; search i is start first + i, and kept as that or, where it is
    // given, as start kept_as[i]. Nothing: interrupted.
    std::optional<std::vector<Endpoint>> search(const std::vector<std::vector<double>>& starts,
                                                const optimise::Method& method,
                                                const optimise::SearchSettings& settings, int first = 0,
                                                const std::vector<int>& kept_as = {});

    // body(i, chain) for i in [0, count), in parallel; what chain i asks for is kept as start first + i. They go in
    // step (run/in_step.h), however many they are. False: interrupted.
    bool chains(const std::string& what, int first, std::size_t count,
                const std::function<void(std::size_t i, Chain& chain)>& body);

    // The same of one that is always by itself: its points are computed one by one.
    bool chain(const std::string& what, int number, const std::function<void(Chain& chain)>& body);

    // One evaluation with derivatives, not kept.
    problem::Evaluation evaluate_one(std::span<const double> unit);

    const Tally& tally() const { return tally_; }

private:
    struct Implementation;
    bool follow(const std::string& what, const std::function<int(std::size_t)>& start, std::size_t count, bool in_step,
                const std::function<void(std::size_t i, Chain& chain)>& body);

    std::unique_ptr<Implementation> implementation_;
    Tally tally_;
};

// The lowest points of a design that are not near each other: by increasing misfit, each at least `distance` from those
// taken before (Euclid, unit cube), at most `count`. Returns indices.
std::vector<std::size_t> distinct_starts(const search::Design& design,
                                         const std::vector<problem::Evaluation>& evaluations, int count,
                                         double distance);

// Why searches from these points lead to no minimum: none has an answer, or no search met the constraints.
std::string why_no_minimum(const problem::Problem& problem, const std::vector<problem::Evaluation>& evaluations);

} // namespace explore::run
