// The answer of each command, out of what it keeps.
#include "base/error.h"
#include "base/text.h"
#include "landscape/minima.h"
#include "report/answer.h"
#include "run/program.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace explore::report {
namespace {

using pave::counted;
using pave::p_words;

const Json nothing;

const Json& at(const Json& json, const char* key) {
    return json.is_object() && json.contains(key) ? json[key] : nothing;
}

std::string number(const Json& json) {
    return json.is_number() ? pave::figure(json.get<double>()) : "-";
}

std::string words(const Json& json) {
    return json.is_string() ? json.get<std::string>() : "";
}

std::vector<std::string> list(const Json& json) {
    return json.is_array() ? json.get<std::vector<std::string>>() : std::vector<std::string>();
}

// The first sentence that says what to measure next is taken out of the notes.
std::string take_next(std::vector<std::string>& notes) {
    constexpr std::string_view opening = "Best next measurement";
    const auto found = std::find_if(notes.begin(), notes.end(), [&](const auto& s) { return s.starts_with(opening); });
    if (found == notes.end()) {
        return "";
    }
    std::string sentence = found->substr(opening.size()); // ": READING ..." or " for THAT: READING ..."
    notes.erase(found);
    const std::size_t colon = sentence.find(": ");
    return "measure" + (colon == 0 ? "" : "," + sentence.substr(0, colon) + ",") + " the " + sentence.substr(colon + 2);
}

std::string take_first(std::vector<std::string>& notes) {
    if (notes.empty()) {
        return "";
    }
    std::string first = notes.front();
    notes.erase(notes.begin());
    return first;
}

std::string shell(const Json& word) {
    return run::shell_word(words(word));
}

std::string page_of(const Json& json) {
    return "pavescape report " + shell(at(json, "run"));
}

Answer fit_answer(const Json& json) {
    Answer answer;
    answer.notes = list(at(json, "findings"));
    const Json& best = at(json, "best");
    const Json& noise = at(json, "noise");
    const auto on_bound = list(at(best, "at_bounds"));
    const auto unknown = list(at(best, "not_determined"));
    const auto is_cut = [&](const Json& axis) {
        return at(at(best, "ranges_95"), words(at(axis, "name")).c_str()).is_array();
    };
    const bool has_cut = std::any_of(at(json, "parameters").begin(), at(json, "parameters").end(), is_cut);
    answer.heading = has_cut ? "Best fit (standard error or 95 % range; the study allows from ... to)"
                             : "Best fit (standard errors; the study allows from ... to)";
    answer.header = {"parameter", "value", has_cut ? "error, range" : "std. error", "from", "to", ""};
    for (const Json& axis : at(json, "parameters")) {
        const std::string name = words(at(axis, "name"));
        const Json& error = at(at(best, "std_error"), name.c_str());
        const Json& range = at(at(best, "ranges_95"), name.c_str());
        const bool is_on_bound = std::find(on_bound.begin(), on_bound.end(), name) != on_bound.end();
        answer.rows.push_back({name, number(at(at(best, "parameters"), name.c_str())),
                               is_on_bound        ? "at bound"
                               : range.is_array() ? number(range[0]) + "-" + number(range[1])
                               : error.is_null()  ? "unknown"
                                                  : number(error),
                               number(at(axis, "min")), number(at(axis, "max")), ""});
    }
    for (const Json& response : at(json, "responses")) {
        if (!response.contains("measured")) {
            answer.rows.push_back(
                {words(at(response, "name")), number(at(response, "value")), "", "", "", words(at(response, "unit"))});
        }
    }
    const auto readings = counted(at(json, "readings").get<std::size_t>(), "reading", "readings");
    const bool is_contradicted = at(noise, "widened") == true;
    const char* const their = at(json, "readings") == 1 ? "its" : "their";
    if (at(best, "converged") != true) {
        answer.verdict = take_first(answer.notes);
    } else {
        answer.verdict =
            at(noise, "p_value").is_null()
                ? fmt::format("Fitted {}, which state no {}noise to judge the model by", readings,
                              at(noise, "source") == "sought" ? "size of their " : "")
            : at(noise, "degrees_of_freedom").get<int>() <= 0 && !is_contradicted
                ? fmt::format("Fitted {} with {}, too few readings to judge the model by", readings,
                              counted(at(json, "parameters").size(), "parameter", "parameters"))
            : at(json, "contradicts_constraints") == true
                ? fmt::format("A constraint keeps the model from fitting the {}; without it the model fits "
                              "({})",
                              readings, p_words(at(noise, "p_value").get<double>()))
            : is_contradicted ? fmt::format("The model does NOT fit the {} within {} noise ({})", readings, their,
                                            p_words(at(noise, "p_value").get<double>()))
                              : fmt::format("The model fits the {} within {} noise ({})", readings, their,
                                            p_words(at(noise, "p_value").get<double>()));
        std::vector<std::string> flaws;
        if (!unknown.empty()) {
            flaws.push_back("does not determine " + pave::join(unknown));
        }
        if (!on_bound.empty()) {
            flaws.push_back("ends on a bound with " + pave::join(on_bound));
        }
        if (const Json& priors = json.value("priors", Json());
            priors.is_object() && priors["degrees_of_freedom"] > 0 && priors["p_value"] < landscape::contradicted) {
            flaws.push_back(fmt::format("contradicts a prior ({})", p_words(priors["p_value"].get<double>())));
        }
        answer.verdict += flaws.empty() ? "." : "; the fit " + pave::join(flaws, " and ") + ".";
    }
    const std::string study = shell(at(at(json, "study"), "file"));
    answer.next =
        fmt::format("pavescape {} {}\nPicture: {}", is_contradicted ? "diagnose" : "unique", study, page_of(json));
    return answer;
}

// A row with low and high of an output, of its two ranges the wider one, as on the page; unless the data contradict the
// model, a row below with the other. before: cells left of the ranges.
void add_output(const Json& output, std::vector<std::string> before, bool is_contradicted, Answer& answer) {
    const Json& low = at(output, "low");
    const Json& high = at(output, "high");
    const Json& wide = at(output, "if_wrong");
    std::array<std::string, 2> own{number(low), number(high)};
    std::array<std::string, 2> shown = own;
    if (low.is_number() && high.is_number() && at(wide, "low").is_number() && at(wide, "high").is_number()) {
        shown = {number(std::min(low.get<double>(), at(wide, "low").get<double>())),
                 number(std::max(high.get<double>(), at(wide, "high").get<double>()))};
    }
    std::vector<std::string> below(before.size());
    below[0] = "  if the model is right";
    const auto add = [&](std::vector<std::string> row, const auto& range, const std::string& unit) {
        row.insert(row.end(), {range[0], range[1], unit});
        row.resize(answer.header.size());
        answer.rows.push_back(std::move(row));
    };
    add(std::move(before), shown, words(at(output, "unit")));
    if (shown != own && !is_contradicted) {
        add(std::move(below), own, "");
    }
}

Answer unique_answer(const Json& json) {
    Answer answer;
    answer.verdict_and_notes(list(at(json, "findings")));
    answer.heading = "What the data accept (95 %)";
    answer.header = {"", "best", "low", "high", "unit", ""};
    for (const Json& p : at(json, "profiles")) {
        const std::string kind = words(at(p, "kind"));
        answer.rows.push_back({words(at(p, "name")), number(at(p, "best")), number(at(p, "low")), number(at(p, "high")),
                               "",
                               kind == "flat"                  ? "whole range"
                               : kind == "bounded"             ? ""
                               : kind == "bounded on one side" ? "to a bound"
                                                               : kind});
    }
    const bool is_contradicted = at(at(json, "acceptance"), "widened") == true;
    for (const Json& o : at(json, "outputs")) {
        add_output(o, {words(at(o, "name")), number(at(o, "best"))}, is_contradicted, answer);
    }
    if (answer.rows.empty()) {
        answer.header.clear();
    }
    // Sentences that the table says already.
    std::erase_if(answer.notes, [](const std::string& s) {
        return s.starts_with("The data accept ") || s.find(" lies between ") != std::string::npos;
    });
    answer.next = take_next(answer.notes);
    if (is_contradicted) { // what a further reading narrows is of a model that is wrong
        answer.next = "pavescape diagnose " + shell(at(at(json, "study"), "file"));
    }
    answer.next += (answer.next.empty() ? "" : "\nPicture: ") + page_of(json);
    return answer;
}

Answer diagnose_answer(const Json& json) {
    Answer answer;
    answer.lines = 30;
    answer.verdict_and_notes(list(at(json, "findings")));
    const bool is_extended = words(at(at(json, "extended"), "study")) != words(at(at(json, "baseline"), "study"));
    answer.heading = is_extended ? "Before and after (95 %)" : "Values (95 %)";
    answer.header = {"", "before", "after", "from", "to", "unit"};
    const bool is_contradicted = words(at(json, "verdict")) != "adequate";
    for (const auto& [name, p] : at(at(json, "extended"), "parameters").items()) {
        answer.rows.push_back({name, number(at(at(at(at(json, "baseline"), "parameters"), name.c_str()), "value")),
                               number(at(p, "value")), number(at(p, "low")), number(at(p, "high")), ""});
    }
    for (const Json& o : at(json, "outputs")) {
        add_output(o, {words(at(o, "name")), number(at(o, "before")), number(at(o, "after"))}, is_contradicted, answer);
    }
    if (!is_extended) { // the same before and after
        const auto drop = [](std::vector<std::string>& row) { row.erase(row.begin() + 1); };
        answer.header[1] = answer.header[2] = "value";
        drop(answer.header);
        std::for_each(answer.rows.begin(), answer.rows.end(), drop);
    }
    answer.next = take_next(answer.notes);
    if (is_extended && words(at(json, "verdict")) != "ambiguous") { // one of several is no model to go on with
        answer.next += fmt::format("{}pavescape unique {}",
                                   answer.next.empty() ? "" : "\nThen: ", shell(at(at(json, "extended"), "study")));
    } else if (answer.next.empty()) {
        answer.next = page_of(json);
    }
    return answer;
}

void add_station_rows(const Json& json, Answer& answer) {
    std::vector<std::string> names;
    constexpr std::size_t shown = 3; // parameters
    for (const Json& station : at(json, "stations")) {
        for (const auto& [name, value] : at(station, "parameters").items()) {
            if (names.size() < shown && std::find(names.begin(), names.end(), name) == names.end()) {
                names.push_back(name);
            }
        }
    }
    answer.heading = "Stations (D0 in um as measured; ?: not determined)";
    answer.header = {"station", "chainage m", "status", "D0"};
    answer.header.insert(answer.header.end(), names.begin(), names.end());
    for (const Json& station : at(json, "stations")) {
        std::vector<std::string> row{words(at(station, "station")), number(at(station, "chainage_m")),
                                     words(at(station, "status")), number(at(station, "D0_um"))};
        for (const std::string& name : names) {
            const Json& p = at(at(station, "parameters"), name.c_str());
            row.push_back(p.is_null() ? "" : number(at(p, "value")) + (at(p, "determined") == true ? "" : " ?"));
        }
        answer.rows.push_back(std::move(row));
    }
}

// Of a road without a weak station.
std::string judged_words(const Json& json) {
    return at(json, "weak_stations").is_null() ? "" : "No station is far weaker than the others. ";
}

Answer survey_answer(const Json& json) {
    Answer answer;
    answer.lines = 30;
    answer.notes = list(at(json, "findings"));
    std::erase_if(answer.notes, [](const std::string& s) { // how it was computed
        return s.find(" searched by one reduced model") != std::string::npos;
    });
    const Json& counts = at(json, "counts");
    const auto count = [&](const char* key) { return at(counts, key).get<std::size_t>(); };
    const std::size_t without = counts.value("no_ratio", std::size_t{0}); // a result of an earlier program says nothing
    const std::string counted_words = fmt::format(
        "{}: {} pass the deflection ratio, {} fail, {}{} rejected", counted(count("stations"), "station", "stations"),
        count("pass"), count("fail"),
        without > 0 ? fmt::format("{} {} none, ", without, without == 1 ? "has" : "have") : "", count("rejected"));
    answer.verdict = !answer.notes.empty() && answer.notes[0].starts_with("Weak station")
                         ? take_first(answer.notes) + " "
                         : judged_words(json);
    answer.verdict += counted_words + ".";
    // A section or sensors that are wrong come before how drops repeat.
    std::stable_partition(answer.notes.begin(), answer.notes.end(), [](const std::string& s) {
        return s.starts_with("The model is off") || s.starts_with("Tried at ") ||
               s.starts_with("With the sensors at ") || s.starts_with("The sensor at ");
    });
    add_station_rows(json, answer);
    answer.next = page_of(json);
    return answer;
}

Answer road_answer(const Json& json) {
    Answer answer;
    answer.lines = 30;
    answer.notes = list(at(json, "findings"));
    const bool is_weak = !answer.notes.empty() && answer.notes[0].starts_with("Weak station");
    std::erase_if(answer.notes, [](const std::string& s) { // what the table says already
        return s.find(", 95 % range ") != std::string::npos ||
               s.find(" is not determined even by ") != std::string::npos;
    });
    constexpr std::size_t named = 3;
    std::vector<std::string> outliers;
    for (const Json& outlier : at(json, "outliers")) {
        outliers.push_back(words(at(outlier, "station")));
    }
    const std::string left_out =
        outliers.empty()
            ? "none left out as an outlier"
            : fmt::format("{} left out as {}",
                          outliers.size() <= named ? pave::join(outliers) : std::to_string(outliers.size()),
                          outliers.size() == 1 ? "an outlier" : "outliers");
    answer.verdict =
        (is_weak ? take_first(answer.notes) + " " : judged_words(json)) +
        fmt::format("{} as one experiment, {}.", counted(at(json, "stations").size(), "station", "stations"), left_out);
    answer.heading = "What the stations have in common (95 %; ?: not determined)";
    answer.header = {"", "value", "from", "to", "times narrower"};
    for (const char* level : {"shared", "section_parameters"}) {
        for (const Json& p : at(json, level)) {
            const Json& section = at(p, "section");
            answer.rows.push_back(
                {words(at(p, "name")) +
                     (section.is_number() ? fmt::format(" (section {})", section.get<std::size_t>() + 1) : ""),
                 number(at(p, "value")) + (at(p, "determined") == true ? "" : " ?"), number(at(p, "low")),
                 number(at(p, "high")), number(at(p, "narrower"))});
        }
    }
    answer.next = page_of(json);
    return answer;
}

Answer sample_answer(const Json& json) {
    Answer answer;
    answer.verdict_and_notes(list(at(json, "findings")));
    answer.heading = "Posterior";
    answer.header = {"", "mean", "sd", "2.5 %", "97.5 %", "unit"};
    for (const char* kind : {"parameters", "outputs"}) {
        for (const Json& m : at(json, kind)) {
            answer.rows.push_back({words(at(m, "name")), number(at(m, "mean")), number(at(m, "sd")),
                                   number(at(m, "q025")), number(at(m, "q975")), words(at(m, "unit"))});
        }
    }
    answer.next = take_next(answer.notes);
    answer.next += (answer.next.empty() ? "" : "\nPicture: ") + page_of(json);
    return answer;
}

} // namespace

Answer answer_of(const std::string& command, const Json& json) {
    Answer answer = command == "fit"        ? fit_answer(json)
                    : command == "unique"   ? unique_answer(json)
                    : command == "diagnose" ? diagnose_answer(json)
                    : command == "survey"   ? survey_answer(json)
                    : command == "road"     ? road_answer(json)
                                            : sample_answer(json);
    if (words(at(json, "model")) == "reduced") {
        answer.verdict += " By the reduced model alone: --model auto refines it with the full one.";
    }
    return answer;
}

} // namespace explore::report
