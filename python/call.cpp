#include "call.h"

#include "run/interrupt.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <fmt/format.h>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>

namespace python {
namespace {

// An int, a NumPy integer, whatever says that it is a whole number. Nothing: beyond 64 bits.
std::optional<long long> index_of(const py::object& value) {
    const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
    if (!number) {
        throw py::error_already_set(); // TypeError
    }
    int overflow = 0;
    const long long whole = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
    return overflow == 0 ? std::optional(whole) : std::nullopt;
}

std::string shown(const py::object& value) {
    return py::repr(value).cast<std::string>();
}

int checked(const py::object& value, const char* name, const allowed::Whole& range, const char* none) {
    const auto number = index_of(value);
    if (number && none != nullptr && *number == 0) {
        return 0;
    }
    if (!number || *number < range.low || *number > range.high) {
        throw py::value_error(fmt::format("{} = {}; allowed: {}{} to {}", name, shown(value),
                                          none != nullptr ? std::string(none) + ", " : "", range.low, range.high));
    }
    return static_cast<int>(*number);
}

} // namespace

int whole(const py::object& value, const char* name, const allowed::Whole& range) {
    return checked(value, name, range, nullptr);
}

int whole_or_none(const py::object& value, const char* name, const allowed::Whole& range, const char* none) {
    return checked(value, name, range, none);
}

double real(const py::object& value, const char* name, const allowed::Real& range) {
    const double number = PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred() != nullptr) {
        throw py::error_already_set();
    }
    if (!(number >= range.low && number <= range.high)) {
        throw py::value_error(fmt::format("{} = {}; allowed: {:g} to {:g}", name, shown(value), range.low, range.high));
    }
    return number;
}

double time_of(const py::object& value) {
    if (value.is_none()) {
        return 0.0;
    }
    if (!py::isinstance<py::str>(value)) {
        return real(value, "time", allowed::budget);
    }
    const auto seconds = explore::run::budget_of(value.cast<std::string>());
    if (!seconds) {
        throw py::value_error(fmt::format("time = {}; allowed: {}", shown(value), explore::run::budget_words));
    }
    return *seconds;
}

std::uint64_t seed_of(const py::object& value) {
    const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
    if (!number) {
        throw py::error_already_set();
    }
    const unsigned long long seed = PyLong_AsUnsignedLongLong(number.ptr());
    if (PyErr_Occurred() != nullptr) {
        PyErr_Clear();
        throw py::value_error(fmt::format("seed = {}; allowed: a whole number from 0 to {}", shown(value),
                                          std::numeric_limits<std::uint64_t>::max()));
    }
    return seed;
}

explore::analysis::RunOptions run_options(const std::string& out, const py::object& threads, const py::object& seed) {
    return {.folder = out,
            .threads = whole_or_none(threads, "threads", allowed::threads, "0 (all)"),
            .seed = seed_of(seed),
            .show_progress = false};
}

explore::analysis::ModelOptions model_of(const std::string& name, const py::object& error) {
    return {.use = static_cast<explore::analysis::ModelUse>(one_of(name, explore::analysis::model_names, "model")),
            .limit_percent = real(error, "model_error", allowed::model_error)};
}

namespace {

// Analyses of several threads share the flag of the interrupt: it is forgotten when none of them runs.
class Running {
public:
    Running() {
        const std::scoped_lock lock(mutex);
        if (count++ == 0) {
            explore::run::forget_interrupt();
        }
    }
    ~Running() {
        const std::scoped_lock lock(mutex);
        if (--count == 0) {
            explore::run::forget_interrupt();
        }
    }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

private:
    static inline std::mutex mutex;
    static inline int count = 0;
};

} // namespace

void call(const std::function<bool()>& body) {
    const Running running;
    bool whole_answer = false;
    bool ended = false;
    std::exception_ptr thrown;
    std::mutex mutex;
    std::condition_variable condition;
    std::thread thread([&] {
        try {
            whole_answer = body();
        } catch (...) {
            thrown = std::current_exception();
        }
        const std::scoped_lock lock(mutex);
        ended = true;
        condition.notify_all();
    });
    std::optional<py::error_already_set> raised;
    const auto wait = [&] {
        const py::gil_scoped_release release;
        std::unique_lock lock(mutex);
        constexpr std::chrono::milliseconds patience{50};
        return condition.wait_for(lock, patience, [&] { return ended; });
    };
    while (!wait()) {
        // Handlers run in the main thread only; a second Ctrl-C has nothing to add.
        if (PyErr_CheckSignals() != 0) {
            py::error_already_set error;
            if (!raised) {
                raised.emplace(std::move(error));
                explore::run::request_interrupt();
            }
        }
    }
    {
        const py::gil_scoped_release release;
        thread.join();
    }
    if (raised) {
        throw std::move(*raised);
    }
    if (thrown) {
        std::rethrow_exception(thrown);
    }
    if (!whole_answer) { // by the interrupt of another thread
        PyErr_SetNone(PyExc_KeyboardInterrupt);
        throw py::error_already_set();
    }
}

} // namespace python
