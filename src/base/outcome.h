// The result of a computation that may have no answer: a value, or a Failure with a status and a reason.
#pragma once

#include <cassert>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace pave {

// How a forward run ended (the four states a run can have; only `converged` has responses).
enum class Status { converged, no_equilibrium, invalid_parameters, failed };

inline constexpr Status all_statuses[] = {Status::converged, Status::no_equilibrium, Status::invalid_parameters,
                                          Status::failed};

constexpr std::string_view to_string(Status status) {
    switch (status) {
    case Status::converged: return "converged";
    case Status::no_equilibrium: return "no-equilibrium";
    case Status::invalid_parameters: return "invalid-parameters";
    case Status::failed: break;
    }
    return "failed";
}

struct Failure {
    Status status = Status::failed;
    std::string reason; // a sentence a pavement engineer understands
};

template <class T>
class Outcome {
public:
    Outcome(T value) : content_(std::move(value)) {}
    Outcome(Failure failure) : content_(std::move(failure)) {}

    explicit operator bool() const { return std::holds_alternative<T>(content_); }
    Status status() const { return *this ? Status::converged : failure().status; }
    const T& value() const& { return std::get<T>(content_); }
    T&& value() && { return std::get<T>(std::move(content_)); }
    const T& operator*() const { return value(); }
    const T* operator->() const { return &value(); }
    const Failure& failure() const { return std::get<Failure>(content_); }

private:
    std::variant<T, Failure> content_;
};

} // namespace pave
