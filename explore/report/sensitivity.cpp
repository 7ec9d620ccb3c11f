#include "report/sensitivity.h"

#include "analysis/explore/build.h"
#include "base/text.h"
#include "report/text.h"
#include "run/program.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

namespace explore::report {
namespace {

using analysis::SensitivityResult;
using pave::figure;

// Of a response.
double percent_change(std::size_t response, const problem::Evaluation& e, const problem::Evaluation& own) {
    const double from = own.responses[response];
    return e.converged() && from != 0.0 ? 100.0 * (e.responses[response] / from - 1.0)
                                        : std::numeric_limits<double>::quiet_NaN();
}

std::string signed_figure(double value, int digits) {
    return std::isfinite(value) ? fmt::format("{:+.{}f}", value, digits) : "-";
}

Json curves_json(const SensitivityResult& s) {
    const problem::ParameterSpace& space = s.study.space;
    Json json = Json::array();
    for (const auto& curve : s.curves) {
        Json points = Json::array();
        for (std::size_t p = 0; p < curve.points.size(); ++p) {
            const auto& e = curve.points[p];
            Json point = {{"change_percent", s.changes[p]},
                          {"value", e.parameters[curve.parameter]},
                          {"status", std::string(to_string(e.status))}};
            if (e.converged()) {
                for (const std::size_t response : s.responses) {
                    point["responses_change_percent"].push_back(percent_change(response, e, s.own));
                }
            } else {
                point["reason"] = e.reason;
            }
            points.push_back(std::move(point));
        }
        json.push_back({{"parameter", space.axes[curve.parameter].name}, {"points", std::move(points)}});
    }
    return json;
}

Json estimate_json(const landscape::Estimate& e) {
    return {{"value", e.value}, {"low", e.low}, {"high", e.high}};
}

Json global_json(const SensitivityResult& s) {
    const problem::ParameterSpace& space = s.study.space;
    Json indices = Json::array();
    for (std::size_t i = 0; i < s.global.responses.size(); ++i) {
        const auto& g = s.global.responses[i];
        const data::Reading& response = s.study.readings[s.responses[i]];
        Json first = Json::object();
        Json total = Json::object();
        for (std::size_t k = 0; k < space.axes.size(); ++k) {
            first[space.axes[k].name] = estimate_json(g.first[k]);
            total[space.axes[k].name] = estimate_json(g.total[k]);
        }
        indices.push_back({{"response", response.label()},
                           {"unit", std::string(response.unit.name)},
                           {"mean", response.in_unit(g.mean)},
                           {"standard_deviation", response.in_unit(std::sqrt(g.variance))},
                           {"first_order", std::move(first)},
                           {"total", std::move(total)},
                           {"interactions", estimate_json(g.interactions)}});
    }
    const auto rows = static_cast<double>(std::max<std::size_t>(s.global.rows, 1));
    return {{"rows", s.global.rows},
            {"complete_rows", s.global.complete},
            {"dropped_share", static_cast<double>(s.global.rows - s.global.complete) / rows},
            {"statuses", status_counts(s.sample)},
            {"confidence", 0.95},
            {"indices", std::move(indices)}};
}

std::string elasticities_text(const SensitivityResult& s) {
    const study::Study& study = s.study;
    Table table(with_axes({"response", "value", "unit"}, study.space));
    std::vector<std::string> values{"value of the parameter", "", ""};
    for (const auto& axis : study.space.axes) {
        values.push_back(figure(axis.start));
    }
    table.add(std::move(values));
    for (const std::size_t i : s.responses) {
        const data::Reading& r = study.readings[i];
        std::vector<std::string> row{r.label(), figure(r.in_unit(s.own.responses[i])), std::string(r.unit.name)};
        for (Eigen::Index k = 0; k < s.elasticity.cols(); ++k) {
            row.push_back(signed_figure(s.elasticity(static_cast<Eigen::Index>(i), k), 3));
        }
        table.add(std::move(row));
    }
    return fmt::format("\nAt the study's own values: % of the response for 1 % of the parameter\n  {}\n{}",
                       signs(s.study), table.text());
}

std::string curves_text(const SensitivityResult& s) {
    const problem::ParameterSpace& space = s.study.space;
    std::vector<std::string> header{"response", "parameter"};
    for (const double change : s.changes) {
        header.push_back(fmt::format("{:+.4g} %", change));
    }
    header.emplace_back("shape");
    Table table(header);
    for (const std::size_t r : s.responses) {
        for (const auto& curve : s.curves) {
            std::vector<std::string> row{&curve == s.curves.data() ? s.study.readings[r].label() : "",
                                         space.axes[curve.parameter].name};
            std::vector<double> changes;
            for (const auto& e : curve.points) {
                changes.push_back(percent_change(r, e, s.own));
                row.push_back(signed_figure(changes.back(), 1));
            }
            row.push_back(sparkline(changes));
            table.add(std::move(row));
        }
    }
    std::string text =
        fmt::format("\nChange of the response in % when one parameter is changed by so much, the others held\n"
                    "  percentages of the study's own value: + takes a negative one further from zero\n{}",
                    table.text());
    for (const auto& curve : s.curves) {
        for (std::size_t p = 0; p < curve.points.size(); ++p) {
            const auto& e = curve.points[p];
            if (!e.converged()) {
                text += fmt::format("  no answer at {} {:+.4g} % ({}): {}: {}\n", space.axes[curve.parameter].name,
                                    s.changes[p], figure(e.parameters[curve.parameter]), to_string(e.status), e.reason);
            }
        }
    }
    return text;
}

std::string global_text(const SensitivityResult& s) {
    const problem::ParameterSpace& space = s.study.space;
    Table table(
        {"response", "mean", "std. dev.", "unit", "parameter", "alone", "95 % interval", "in all", "95 % interval"});
    const auto interval = [](const landscape::Estimate& e) {
        return std::isfinite(e.value) ? fmt::format("{:.3f} to {:.3f}", e.low, e.high) : "-";
    };
    const auto share = [](const landscape::Estimate& e) {
        return std::isfinite(e.value) ? fmt::format("{:.3f}", e.value) : "-";
    };
    for (std::size_t i = 0; i < s.global.responses.size(); ++i) {
        const auto& g = s.global.responses[i];
        const data::Reading& r = s.study.readings[s.responses[i]];
        std::vector<std::string> head{r.label(), figure(r.in_unit(g.mean)), figure(r.in_unit(std::sqrt(g.variance))),
                                      std::string(r.unit.name)};
        for (const std::size_t k : analysis::ranked(g)) {
            std::vector<std::string> row = std::move(head);
            head.assign(4, "");
            row.insert(row.end(), {space.axes[k].name, share(g.first[k]), interval(g.first[k]), share(g.total[k]),
                                   interval(g.total[k])});
            table.add(std::move(row));
        }
    }
    std::string text = fmt::format(
        "\nOver the box (each parameter uniform between its bounds, in the logarithm where its scale is log): share "
        "of the variance\n  that a parameter makes alone (first order) and in all, with its interactions "
        "(total); {} rows of {} runs\n",
        s.global.rows, space.dimension() + 2);
    const Json statuses = status_counts(s.sample);
    for (const auto& [status, count] : statuses.items()) {
        if (status != "converged" && count.get<std::int64_t>() > 0) {
            text += fmt::format("    {} of these runs: {}\n", count.get<std::int64_t>(), status);
        }
    }
    return text + table.text() + "\nWhat this means\n" + sentences(findings(s));
}

} // namespace

Json sensitivity_json(const SensitivityResult& s, const analysis::RunOptions& run) {
    if (s.failed()) {
        return {{"status", std::string(to_string(s.own.status))}, {"reason", s.reason()}};
    }
    const problem::ParameterSpace& space = s.study.space;
    Json json = {{"study", study_json(s.study)},    {"version", analysis::version}, {"seed", run.seed},
                 {"computed", s.tally.computed},    {"kept", s.tally.kept},         {"run", run.folder},
                 {"parameters", space_json(space)}, {"responses", Json::array()},   {"range_percent", s.options.range},
                 {"curves", curves_json(s)}};
    for (std::size_t k = 0; k < space.axes.size(); ++k) {
        json["parameters"][k]["value"] = space.axes[k].start;
    }
    for (const std::size_t i : s.responses) {
        const data::Reading& r = s.study.readings[i];
        Json elasticity = Json::object();
        for (std::size_t k = 0; k < space.axes.size(); ++k) {
            elasticity[space.axes[k].name] = s.elasticity(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
        }
        json["responses"].push_back({{"name", r.label()},
                                     {"unit", std::string(r.unit.name)},
                                     {"value", r.in_unit(s.own.responses[i])},
                                     {"elasticities", std::move(elasticity)}});
    }
    if (s.options.samples > 0) {
        json["global"] = global_json(s);
        json["findings"] = findings(s);
    }
    json["warnings"] = warnings_json(s.own);
    json["answer"] = sensitivity_answer(s, run).verdict;
    return json;
}

// A row a response, a column a parameter: of its variance over the box the share that the parameter makes in all, or
// where no sample was computed its elasticity.
Answer sensitivity_answer(const SensitivityResult& s, const analysis::RunOptions& run) {
    Answer answer;
    const auto& axes = s.study.space.axes;
    const bool is_global = s.options.samples > 0 && s.global.complete >= 2;
    std::vector<double> largest(axes.size(), 0.0); // of all responses
    std::vector<std::size_t> leads(axes.size(), 0);
    answer.header = with_axes({""}, s.study.space);
    std::size_t varying = 0;
    for (std::size_t i = 0; i < s.responses.size(); ++i) {
        std::vector<std::string> row{s.study.readings[s.responses[i]].label()};
        std::size_t lead = 0;
        double most = -1.0;
        for (std::size_t k = 0; k < axes.size(); ++k) {
            const double value =
                is_global ? s.global.responses[i].total[k].value
                          : s.elasticity(static_cast<Eigen::Index>(s.responses[i]), static_cast<Eigen::Index>(k));
            row.push_back(!std::isfinite(value) ? "-"
                          : is_global           ? fmt::format("{:.0f} %", std::min(100.0, 100.0 * std::max(0.0, value)))
                                                : fmt::format("{:+.2f}", value));
            if (std::abs(value) > most) {
                most = std::abs(value);
                lead = k;
            }
            largest[k] = std::max(largest[k], std::isfinite(value) ? std::abs(value) : 0.0);
        }
        if (most > 0.0) {
            ++leads[lead];
            ++varying;
        }
        answer.rows.push_back(std::move(row));
    }
    std::vector<std::size_t> order(axes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return leads[a] > leads[b]; });
    std::string others; // that lead somewhere
    for (std::size_t i = 1; i < order.size() && leads[order[i]] > 0; ++i) {
        others += fmt::format(", {} on {}", axes[order[i]].name, leads[order[i]]);
    }
    const std::string over = is_global ? "within the ranges of the study" : "near the study's own values";
    answer.verdict = varying == 0 ? "No parameter moves any of these responses " + over + "."
                     : axes.size() == 1
                         ? fmt::format("{} moves {} of {} {}.", axes[0].name, varying,
                                       pave::counted(s.responses.size(), "response", "responses"), over)
                         : fmt::format("{} has the largest influence on {} of {}{}{} {}.", axes[order[0]].name,
                                       leads[order[0]], pave::counted(s.responses.size(), "response", "responses"),
                                       others, others.empty() ? "" : ",", over);
    answer.heading = is_global ? "Share of the variance over these ranges, with interactions"
                               : "% of the response for 1 % of the parameter";
    std::vector<std::string> idle;
    constexpr double little = 0.05;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        if (varying > 0 && largest[k] < little && (is_global || axes[k].start != 0.0)) {
            idle.push_back(axes[k].name);
        }
    }
    if (is_global) {
        answer.notes = findings(s);
        std::erase_if(answer.notes, [](const std::string& words) { // what the table says already
            return words.find(" is governed by ") != std::string::npos;
        });
    } else if (s.options.samples > 0) {
        answer.notes = findings(s);
    }
    for (const auto& axis : axes) {
        if (axis.start == 0.0) {
            answer.notes.push_back(fmt::format("{} is 0 in the study: it has no percentage.", axis.name));
        }
    }
    std::size_t holes = 0;
    for (const auto& curve : s.curves) {
        holes += static_cast<std::size_t>(
            std::count_if(curve.points.begin(), curve.points.end(), [](const auto& e) { return !e.converged(); }));
    }
    if (holes > 0) {
        answer.notes.push_back(fmt::format("{} of the curves {} no answer (--verbose says why).",
                                           pave::counted(holes, "point", "points"), holes == 1 ? "has" : "have"));
    }
    answer.next = (idle.empty() ? ""
                                : fmt::format("hold {} at a known value: these responses do not determine {}\n",
                                              pave::join(idle), idle.size() == 1 ? "it" : "them")) +
                  "Picture: pavescape report " + run::shell_word(run.folder);
    return answer;
}

std::string sensitivity_text(const SensitivityResult& s, const analysis::RunOptions& run) {
    const run::Tally& tally = s.tally;
    std::string text = fmt::format(
        "{}  {} computed in {} ({:.1f} runs/s), {} kept from before\n", study_summary(s.study),
        pave::counted(static_cast<std::size_t>(tally.computed), "run", "runs"), run::duration_words(tally.seconds),
        tally.seconds > 0.0 ? static_cast<double>(tally.computed) / tally.seconds : 0.0, tally.kept);
    text += warning_lines(s.own) + elasticities_text(s);
    if (!s.curves.empty()) {
        text += curves_text(s);
    }
    for (const auto& axis : s.study.space.axes) {
        if (axis.start == 0.0) {
            text += fmt::format("  {} is 0 in the study: it has no percentage.\n", axis.name);
        }
    }
    if (s.options.samples > 0) {
        text += global_text(s);
    }
    return text +
           fmt::format("\n  results: {}/sensitivity.json; every run: pavescape export {} --command sensitivity{}\n",
                       run.folder, run::shell_word(run.folder),
                       s.options.samples > 0 ? " (or sensitivity-curves)" : "-curves");
}

} // namespace explore::report
