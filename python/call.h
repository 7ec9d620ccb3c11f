// How an analysis is called from Python: arguments checked, away from the interpreter's lock, ended by Ctrl-C.
#pragma once

#include "analysis/common/option_ranges.h"
#include "analysis/common/session.h"
#include "report/best_so_far.h"
#include "run/budget.h"
#include "run/files.h"

#include <functional>
#include <optional>
#include <pybind11/pybind11.h>
#include <stdexcept>

namespace python {

namespace py = pybind11;
namespace allowed = explore::analysis::allowed;

// A computation without an answer, in Python.
struct NoAnswer : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Raise ValueError with the name of the argument, what was given and the range; TypeError for what is no number.
int whole(const py::object& value, const char* name, const allowed::Whole& range);
// The same, and 0 for what the analysis chooses itself, in words: "0 (all)".
int whole_or_none(const py::object& value, const char* name, const allowed::Whole& range, const char* none);
double real(const py::object& value, const char* name, const allowed::Real& range);
std::uint64_t seed_of(const py::object& value);

template <class Words>
std::size_t one_of(const std::string& word, const Words& words, const char* name) {
    std::vector<std::string> list;
    for (const auto& known : words) {
        if (known == word) {
            return list.size();
        }
        list.emplace_back(known);
    }
    throw py::value_error(std::string(name) + " = \"" + word + "\"; allowed: " + pave::join(list));
}

// Seconds, or "30s", "10min", "2h"; None: 0, no limit.
double time_of(const py::object& value);

// Where and how an analysis runs. threads: 0 for all.
explore::analysis::RunOptions run_options(const std::string& out, const py::object& threads, const py::object& seed);
explore::analysis::ModelOptions model_of(const std::string& name, const py::object& error);

// Calls body in a thread of its own, without the interpreter's lock, while this one listens for signals: an exception
// that a handler raises, as that of Ctrl-C does, lets the evaluations that are running end, and goes on from here then.
// body: false where it was cut off.
void call(const std::function<bool()>& body);

// How long an analysis may take, and of which study the best answer so far is, where it takes longer.
struct TimeLimit {
    double seconds = 0.0; // 0: no limit
    const explore::study::Study* study = nullptr;
};

// analyse(session): an optional result; json(result, run). The JSON of the command as text, kept where it keeps it.
template <class Analyse, class Render>
std::string analysed(const explore::analysis::RunOptions& run, const char* name, const Analyse& analyse,
                     const Render& render, const TimeLimit& limit = {}) {
    std::string text;
    call([&] {
        explore::analysis::RunOptions options = run;
        std::optional<explore::run::TemporaryFolder> scratch; // what an answer so far is read from
        if (limit.seconds > 0.0 && options.folder.empty()) {
            options.folder = scratch.emplace().path();
        }
        const explore::run::Budget budget(limit.seconds);
        explore::analysis::Session session(options);
        const auto result = analyse(session);
        if (!result && budget.is_spent()) {
            text = explore::report::json_text(explore::report::best_so_far_json(
                *limit.study, explore::analysis::best_so_far(session, *limit.study, name), limit.seconds));
            return true;
        }
        if (!result) {
            return false;
        }
        const explore::report::Json json = render(*result, session.options());
        if (result->failed()) {
            throw NoAnswer(json.value("reason", "no answer"));
        }
        text = explore::report::json_text(json);
        session.keep(name, text);
        return true;
    });
    return text;
}

} // namespace python
