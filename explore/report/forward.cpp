#include "report/forward.h"

#include "base/text.h"
#include "data/csv.h"
#include "report/text.h"
#include "run/program.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {

using pave::counted;
using pave::figure;
using pave::pavement::Response;

Json forward_json(const study::Study& study, const pave::pavement::ForwardModel* model,
                  const pave::Outcome<Response>& outcome, const std::vector<study::NamedValue>& values) {
    Json json = {{"status", std::string(to_string(outcome.status()))}};
    for (const auto& [name, value] : values) {
        json["set"][name] = value;
    }
    if (!outcome) {
        json["reason"] = outcome.failure().reason;
        return json;
    }
    const Response& response = *outcome;
    const auto& s = response.statistics;
    json["responses"] = responses_json(study, response.values);
    if (model != nullptr) {
        json["newton_steps"] = s.newton_steps;
        json["load_steps"] = s.load_steps;
        json["factorizations"] = s.factorizations;
        json["iterations"] = s.iterations;
        json["unknowns"] = model->unknowns();
        json["residual_relative"] = s.residual_relative;
    }
    json["warnings"] = response.warnings;
    if (response.jacobian.cols() > 0) {
        Json names = Json::array();
        Json rows = Json::array();
        for (const auto& axis : study.space.axes) {
            names.push_back(axis.name);
        }
        for (std::size_t i = 0; i < response.values.size(); ++i) {
            Json row = Json::array();
            for (Eigen::Index k = 0; k < response.jacobian.cols(); ++k) {
                row.push_back(response.jacobian(static_cast<Eigen::Index>(i), k) / study.readings[i].unit.to_si);
            }
            rows.push_back(std::move(row));
        }
        json["jacobian"] = {{"parameters", std::move(names)}, {"rows", std::move(rows)}};
    }
    return json;
}

Answer forward_answer(const study::Study& study, const Response& response, const std::vector<study::NamedValue>& values,
                      const std::vector<std::string>& fields) {
    Answer answer;
    answer.lines = all_lines;
    double squares = 0.0;
    double largest = 0.0;
    std::size_t compared = 0;
    std::string where;
    const bool has_derivatives = response.jacobian.cols() > 0;
    const bool is_measured = std::any_of(study.readings.begin(), study.readings.end(),
                                         [](const data::Reading& r) { return r.is_measured(); });
    answer.header = has_derivatives ? with_axes({"", "model", "unit"}, study.space)
                    : is_measured   ? std::vector<std::string>{"", "measured", "model", "unit", "difference"}
                                    : std::vector<std::string>{"", "model", "unit"};
    for (std::size_t i = 0; i < response.values.size(); ++i) {
        const data::Reading& r = study.readings[i];
        const double model = r.in_unit(response.values[i]);
        std::vector<std::string> row{r.is_measured() ? r.label() : r.output};
        if (has_derivatives) {
            row.insert(row.end(), {figure(model), std::string(r.unit.name)});
            for (Eigen::Index k = 0; k < response.jacobian.cols(); ++k) {
                row.push_back(figure(r.in_unit(response.jacobian(static_cast<Eigen::Index>(i), k))));
            }
        } else if (!is_measured) {
            row.insert(row.end(), {figure(model), std::string(r.unit.name)});
        } else {
            row.insert(row.end(),
                       {r.is_measured() ? fmt::format("{}{}", data::sign_of(r.censored), figure(r.value)) : "",
                        figure(model), std::string(r.unit.name)});
        }
        if (r.is_measured() && r.value != 0.0 && r.censored == data::Censored::no) {
            const double off = 100.0 * (model / r.value - 1.0);
            squares += off * off;
            ++compared;
            if (!(std::abs(off) <= std::abs(largest))) {
                largest = off;
                where = r.label();
            }
            if (!has_derivatives) {
                row.push_back(fmt::format("{:+.1f} %", off));
            }
        }
        row.resize(answer.header.size());
        answer.rows.push_back(std::move(row));
    }
    std::vector<std::string> set;
    for (const auto& [name, value] : values) {
        set.push_back(fmt::format("{} = {}", name, value));
    }
    const std::string place = set.empty() ? "At the study's own values" : "At " + pave::join(set);
    answer.verdict =
        compared > 0
            ? fmt::format("{} the model is {:.3g} % off the {} (root mean square), at most {:+.3g} % at {}.", place,
                          std::sqrt(squares / static_cast<double>(compared)), counted(compared, "reading", "readings"),
                          largest, where)
            : fmt::format("{} the model gives {}.", place, counted(response.values.size(), "response", "responses"));
    answer.heading = has_derivatives ? "Responses, and derivatives by the parameters" : "Responses";
    answer.notes = response.warnings;
    answer.notes.emplace_back(signs(study));
    answer.notes.back()[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(answer.notes.back()[0])));
    answer.notes.back() += ".";
    for (const std::string& file : fields) {
        answer.notes.push_back("Fields for ParaView: " + file);
    }
    if (compared > 0 && !study.parameters.empty() && !has_derivatives) {
        answer.next = "pavescape fit " + run::shell_word(study.file);
    }
    return answer;
}

std::string forward_text(const study::Study& study, const Response& response,
                         const std::vector<study::NamedValue>& values, const std::vector<std::string>& fields) {
    const auto& s = response.statistics;
    std::string text = study_summary(study);
    for (const auto& [name, value] : values) {
        text += fmt::format("  at {} = {}\n", name, value);
    }
    text += study.has_own_model
                ? "\n"
                : fmt::format("  converged: {}, {}{}, unbalanced force {:.0e} of the load\n\n",
                              study.model.settings.integration == pave::pavement::Integration::secant
                                  ? counted(static_cast<std::size_t>(s.newton_steps), "Newton step", "Newton steps")
                                  : counted(static_cast<std::size_t>(s.load_steps), "load step", "load steps"),
                              counted(static_cast<std::size_t>(s.factorizations), "factorisation", "factorisations"),
                              s.iterations > 0 ? fmt::format(", {} conjugate gradient steps", s.iterations) : "",
                              s.residual_relative);
    text += response_table(study, response.values);
    for (const std::string& warning : response.warnings) {
        text += fmt::format("  warning: {}\n", warning);
    }
    for (const std::string& file : fields) {
        text += fmt::format("  fields for ParaView: {}\n", file);
    }
    return text;
}

std::string points_csv(const study::Study& study, const analysis::ComputedPoints& computed) {
    std::string text = "# " + std::string(signs(study)) + "\n";
    for (const std::string& name : computed.points.names) {
        text += data::csv_cell(name) + ",";
    }
    text += "status";
    for (const data::Reading& reading : study.readings) {
        text += "," + data::csv_cell(reading.label_with_unit());
    }
    text += ",reason\n";
    for (std::size_t i = 0; i < computed.responses.size(); ++i) {
        const auto& outcome = computed.responses[i];
        for (const double value : computed.points.values[i]) {
            text += fmt::format("{},", value);
        }
        text += to_string(outcome.status());
        for (std::size_t r = 0; r < study.readings.size(); ++r) {
            text += outcome ? fmt::format(",{}", study.readings[r].in_unit(outcome.value()[r])) : ",";
        }
        text += "," + (outcome ? std::string() : data::csv_cell(outcome.failure().reason)) + "\n";
    }
    return text;
}

Json points_json(const study::Study& study, const analysis::ComputedPoints& computed) {
    Json points = Json::array();
    for (std::size_t i = 0; i < computed.responses.size(); ++i) {
        const auto& outcome = computed.responses[i];
        Json point = {{"parameters", Json::object()}, {"status", std::string(to_string(outcome.status()))}};
        for (std::size_t k = 0; k < computed.points.names.size(); ++k) {
            point["parameters"][computed.points.names[k]] = computed.points.values[i][k];
        }
        if (outcome) {
            point["responses"] = responses_json(study, outcome.value());
            if (!computed.warnings[i].empty()) {
                point["warnings"] = computed.warnings[i];
            }
        } else {
            point["reason"] = outcome.failure().reason;
        }
        points.push_back(std::move(point));
    }
    return {{"points", std::move(points)}};
}

std::string jacobian_text(const study::Study& study, const Response& response) {
    Table table(with_axes({"d(response)/d(parameter)"}, study.space));
    for (std::size_t i = 0; i < response.values.size(); ++i) {
        const data::Reading& reading = study.readings[i];
        std::vector<std::string> row{reading.label_with_unit()};
        for (Eigen::Index k = 0; k < response.jacobian.cols(); ++k) {
            row.push_back(fmt::format("{:.5g}", reading.in_unit(response.jacobian(static_cast<Eigen::Index>(i), k))));
        }
        table.add(std::move(row));
    }
    return "\n" + table.text();
}

} // namespace explore::report
