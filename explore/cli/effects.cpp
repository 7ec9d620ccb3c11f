// pavescape effects: the catalogue of effects that a study may lack.
#include "cli/commands.h"
#include "pavement/effects/catalog.h"
#include "report/table.h"

#include <fmt/format.h>

namespace explore::cli {
namespace {

std::string options_of(const pave::pavement::Effect& effect) {
    std::vector<std::string> names;
    for (const auto& [takes, name] : {std::pair{effect.layer != pave::pavement::LayerRole::none, "layer"},
                                      {effect.takes_load, "load"},
                                      {effect.takes_quantity, "quantity"},
                                      {effect.takes_reading, "reading"},
                                      {effect.takes_thickness, "thickness_mm"}}) {
        if (takes) {
            names.emplace_back(name);
        }
    }
    return pave::join(names);
}

int list_effects(bool as_json) {
    report::Json json = report::Json::array();
    report::Table table({"name", "unit of size", "no effect", "from", "to", "typical", "acts on", "options"});
    std::string words;
    for (const auto* effect : pave::pavement::effects()) {
        const std::string name(effect->name);
        const auto number = [](double value) { return fmt::format("{:g}", value); };
        const std::string acts_on(effect->acts_on);
        const std::string options = options_of(*effect);
        if (as_json) {
            json.push_back({{"name", name},
                            {"unit", std::string(effect->unit)},
                            {"null", effect->null},
                            {"low", effect->low},
                            {"high", effect->high},
                            {"scale", effect->log_scale ? "log" : "linear"},
                            {"typical", effect->typical},
                            {"acts_on", acts_on},
                            {"options", options},
                            {"mechanism", std::string(effect->mechanism)},
                            {"source", std::string(effect->source)}});
        } else {
            table.add({name, std::string(effect->unit), number(effect->null), number(effect->low), number(effect->high),
                       number(effect->typical), acts_on, options});
            words += fmt::format("\n{}\n  {}\n  Source: {}\n", name, effect->mechanism, effect->source);
        }
    }
    if (as_json) {
        fmt::print("{}\n", report::json_text(json));
    } else {
        fmt::print("{}{}", table.text(), words);
    }
    return done;
}

} // namespace

void add_effects(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("effects", "the physical effects that a study may add to its model");
    auto json = std::make_shared<bool>(false);
    command->add_flag("--json", *json, "print one JSON array and nothing else");
    command->footer("Example: pavescape effects");
    command->callback([=, &action] { action = [=] { return list_effects(*json); }; });
}

} // namespace explore::cli
