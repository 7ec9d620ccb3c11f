#include "report/effects.h"

#include "pavement/effects/catalog.h"
#include "report/table.h"

#include <fmt/format.h>

namespace explore::report {
namespace {

std::string options_of(const pave::pavement::Effect& effect) {
    std::vector<std::string> names;
    for (const auto& [takes, name] : {std::pair{effect.layer != pave::pavement::LayerRole::none, "layer"},
                                      {effect.takes_load, "load"},
                                      {effect.takes_quantity, "quantity"},
                                      {effect.takes_reading, "reading"},
                                      {effect.takes_thickness, "thickness_mm"},
                                      {effect.takes_offsets, "offsets_mm"}}) {
        if (takes) {
            names.emplace_back(name);
        }
    }
    return pave::join(names);
}

} // namespace

Json effects_json() {
    Json json = Json::array();
    for (const auto* effect : pave::pavement::effects()) {
        json.push_back({{"name", std::string(effect->name)},
                        {"unit", std::string(effect->unit)},
                        {"null", effect->null},
                        {"low", effect->low},
                        {"high", effect->high},
                        {"scale", effect->log_scale ? "log" : "linear"},
                        {"typical", effect->typical},
                        {"acts_on", std::string(effect->acts_on)},
                        {"options", options_of(*effect)},
                        {"mechanism", std::string(effect->mechanism)},
                        {"source", std::string(effect->source)}});
    }
    return json;
}

Answer effects_answer() {
    Answer answer;
    answer.lines = all_lines;
    const auto& all = pave::pavement::effects();
    answer.verdict = fmt::format("{} effects can be added to a study, each with a size.", all.size());
    answer.heading = "Effects";
    answer.header = {"name", "unit of size", "none", "typical", "acts on"};
    for (const auto* effect : all) {
        answer.rows.push_back({std::string(effect->name), std::string(effect->unit), fmt::format("{:g}", effect->null),
                               fmt::format("{:g}", effect->typical), std::string(effect->acts_on)});
    }
    answer.next =
        "[[effects]] with name and size in a study; diagnose tries them all. Mechanisms, ranges and sources:\n"
        "pavescape effects --verbose";
    return answer;
}

std::string effects_text() {
    Table table({"name", "unit of size", "no effect", "from", "to", "typical", "acts on", "options"});
    std::string words;
    for (const auto* effect : pave::pavement::effects()) {
        const auto number = [](double value) { return fmt::format("{:g}", value); };
        table.add({std::string(effect->name), std::string(effect->unit), number(effect->null), number(effect->low),
                   number(effect->high), number(effect->typical), std::string(effect->acts_on), options_of(*effect)});
        words += fmt::format("\n{}\n  {}\n  Source: {}\n", effect->name, effect->mechanism, effect->source);
    }
    return table.text() + words;
}

} // namespace explore::report
