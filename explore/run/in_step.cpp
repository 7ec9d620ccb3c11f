#include "run/in_step.h"

#include "run/interrupt.h"

#include <algorithm>
#include <thread>

namespace explore::run {

void InStep::run(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& body) {
    active_ = std::min(count, threads);
    std::size_t next = 0;
    std::exception_ptr failure;
    const auto work = [&] {
        std::unique_lock lock(mutex_);
        while (next < count && !failure && !interrupted()) {
            const std::size_t i = next++;
            lock.unlock();
            std::exception_ptr thrown;
            try {
                body(i);
            } catch (...) {
                thrown = std::current_exception();
            }
            lock.lock();
            failure = failure ? failure : thrown;
        }
        --active_;
        if (active_ > 0 && waiting_.size() == active_) { // the others wait for this one no longer
            answer(lock);
        }
    };
    {
        std::vector<std::jthread> all;
        all.reserve(active_);
        for (std::size_t t = std::min(count, threads); t > 0; --t) {
            all.emplace_back(work);
        }
    }
    if (failure) {
        std::rethrow_exception(failure);
    }
}

problem::Evaluation InStep::at(std::span<const double> unit, bool with_jacobian) {
    Request own{.unit = {unit.begin(), unit.end()}, .with_jacobian = with_jacobian, .answer = {}, .failure = {}};
    std::unique_lock lock(mutex_);
    waiting_.push_back(&own);
    if (waiting_.size() == active_) {
        answer(lock);
    } else {
        answered_.wait(lock, [&] { return own.is_answered; });
    }
    if (own.failure) {
        std::rethrow_exception(own.failure);
    }
    if (!own.answer) {
        throw Interrupted();
    }
    return std::move(*own.answer);
}

// All that wait. The others sleep meanwhile, so that none of them comes or goes.
void InStep::answer(std::unique_lock<std::mutex>& lock) {
    const std::vector<Request*> requests = std::exchange(waiting_, {});
    lock.unlock();
    compute(requests, false);
    compute(requests, true);
    lock.lock();
    for (Request* request : requests) {
        request->is_answered = true;
    }
    answered_.notify_all();
}

void InStep::compute(const std::vector<Request*>& requests, bool with_jacobian) {
    std::vector<Request*> own;
    std::vector<std::vector<double>> units;
    for (Request* request : requests) {
        if (request->with_jacobian == with_jacobian) {
            own.push_back(request);
            units.push_back(request->unit);
        }
    }
    if (own.empty()) {
        return;
    }
    try {
        auto answers = compute_(units, with_jacobian);
        for (std::size_t i = 0; i < own.size(); ++i) {
            own[i]->answer = std::move(answers[i]);
        }
    } catch (...) {
        for (Request* request : own) {
            request->failure = std::current_exception();
        }
    }
}

} // namespace explore::run
