#include "report/noise.h"

#include "base/text.h"
#include "report/text.h"

#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::NoiseModel;

// As [data.noise] calls them, in its units.
struct PartWords {
    NoiseModel::Part part;
    const char* key;
    const char* unit;
};
constexpr PartWords words[] = {{NoiseModel::relative, "relative", ""},
                               {NoiseModel::common, "common_relative", ""},
                               {NoiseModel::absolute, "absolute", "um"},
                               {NoiseModel::correlation, "correlation_mm", "mm"}};

} // namespace

std::string noise_block(const analysis::NoiseResult& result) {
    std::string text = "[data.noise]\n";
    for (const auto& [part, key, unit] : words) {
        const double value = part == NoiseModel::absolute ? result.stated_absolute_um() : result.model.value[part];
        if (value > 0.0) {
            text += part == NoiseModel::absolute ? fmt::format("{} = {{ {} = {:.3g} }}\n", key, unit, value)
                                                 : fmt::format("{} = {:.3g}\n", key, value);
        }
    }
    return text + "of_drops = 1\n";
}

Json noise_json(const analysis::NoiseResult& result) {
    Json json = {{"stations", result.stations}, {"groups", result.groups},
                 {"drops", result.drops},       {"degrees_of_freedom", result.degrees},
                 {"noise", Json::object()},     {"block", noise_block(result)},
                 {"sensors", Json::array()},    {"left_out", result.left_out},
                 {"findings", findings(result)}};
    for (const auto& [part, key, unit] : words) {
        const std::string name = part == NoiseModel::absolute ? "absolute_um" : key;
        json["noise"][name] = {
            {"value", result.model.value[part]}, {"low", result.model.low[part]}, {"high", result.model.high[part]}};
    }
    for (const auto& s : result.sensors) {
        json["sensors"].push_back({{"x_mm", s.offset_mm},
                                   {"deflection_um", s.deflection_um},
                                   {"degrees_of_freedom", s.degrees},
                                   {"scatter", s.scatter},
                                   {"scatter_of_model", s.scatter_of_model},
                                   {"with_next", optional_json(s.with_next)},
                                   {"with_next_of_model", optional_json(s.with_next_of_model)},
                                   {"with_first", optional_json(s.with_first)},
                                   {"with_first_of_model", optional_json(s.with_first_of_model)}});
    }
    return json;
}

Answer noise_answer(const analysis::NoiseResult& result) {
    Answer answer;
    answer.lines = 30;
    answer.verdict_and_notes(findings(result));
    answer.heading = "Noise of one drop (95 %)";
    answer.header = {"part", "value", "from", "to", "unit"};
    for (const auto& [part, key, unit] : words) {
        const bool is_known = result.model.value[part] > 0.0;
        const auto number = [&](double value) { return is_known ? fmt::format("{:.3g}", value) : std::string("-"); };
        answer.rows.push_back({key, number(result.model.value[part]), number(result.model.low[part]),
                               number(result.model.high[part]), unit});
    }
    answer.next = "put this into the study:";
    answer.block = noise_block(result);
    return answer;
}

std::string noise_text(const analysis::NoiseResult& result) {
    std::string text = fmt::format(
        "{}, {} of repeated drops, {} in them\n\nScatter of ln(deflection / pressure) of one drop, and its "
        "correlation: of the drops (of the model below)\n",
        pave::counted(result.stations, "station", "stations"), pave::counted(result.groups, "group", "groups"),
        pave::counted(static_cast<std::size_t>(result.drops), "drop", "drops"));
    Table sensors({"sensor mm", "deflection um", "scatter %", "with next", "with first"});
    const auto both = [](const std::optional<double>& drops, const std::optional<double>& model) {
        return drops && model ? fmt::format("{:.2f} ({:.2f})", *drops, *model) : std::string();
    };
    for (const auto& s : result.sensors) {
        sensors.add({fmt::format("{:g}", s.offset_mm), fmt::format("{:.0f}", s.deflection_um),
                     fmt::format("{:.2f} ({:.2f})", 100.0 * s.scatter, 100.0 * s.scatter_of_model),
                     both(s.with_next, s.with_next_of_model), both(s.with_first, s.with_first_of_model)});
    }
    text += sensors.text() + "\nNoise of one drop\n";
    Table parts({"part", "value", "95 % range", "unit"});
    for (const auto& [part, key, unit] : words) {
        const double value = result.model.value[part];
        parts.add({key, value > 0.0 ? fmt::format("{:.3g}", value) : "not determined",
                   value > 0.0 ? fmt::format("{:.3g} to {:.3g}", result.model.low[part], result.model.high[part]) : "",
                   unit});
    }
    return text + parts.text() + "\nWhat this means\n" + sentences(findings(result)) + "\nFor a study:\n\n" +
           noise_block(result);
}

} // namespace explore::report
