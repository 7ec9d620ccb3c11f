// Chains in step: what they ask for one by one is computed together.
//
// Every chain runs on a thread of its own and waits for its answer. When all that have not ended wait, what they ask
// for is computed at once, as many points at a time as the model takes for about the price of one. An answer depends on
// its own point alone (ForwardFunction::evaluate_many), so it does not matter who asks beside whom.
#pragma once

#include "problem/problem.h"

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace explore::run {

class InStep {
public:
    // Answers in the order of the points; none: interrupted. Called on one thread at a time.
    using Answers = std::vector<std::optional<problem::Evaluation>>;
    using Compute = std::function<Answers(std::span<const std::vector<double>> units, bool with_jacobian)>;
    explicit InStep(Compute compute) : compute_(std::move(compute)) {}

    // body(i) for i in [0, count) on `threads` threads. The first exception of a body comes out here, after all have
    // ended; bodies not begun by then, or when the program is interrupted, are left out.
    void run(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& body);

    // For a body: waits until all others wait, too. Throws Interrupted, and what computing it threw.
    problem::Evaluation at(std::span<const double> unit, bool with_jacobian);

private:
    struct Request {
        std::vector<double> unit;
        bool with_jacobian = false;
        std::optional<problem::Evaluation> answer;
        std::exception_ptr failure;
        bool is_answered = false;
    };
    void answer(std::unique_lock<std::mutex>& lock);
    void compute(const std::vector<Request*>& requests, bool with_jacobian);

    Compute compute_;
    std::mutex mutex_;
    std::condition_variable answered_;
    std::vector<Request*> waiting_;
    std::size_t active_ = 0; // threads that have not ended
};

} // namespace explore::run
