// Prints docs/reference/keys.md: every key of a study, from the tables that the program reads studies by.
// usage: study_keys > docs/reference/keys.md
#include "material/catalog.h"
#include "pavement/effects/catalog.h"
#include "pavement/effects/effect.h"
#include "pavement/parameter.h"
#include "report/answer.h"
#include "study/keys.h"

#include <cmath>
#include <fmt/format.h>

namespace {

using namespace pave;

// As tools/check/columns wraps a page.
std::string in_lines(const std::string& text) {
    constexpr std::size_t columns = 120;
    return join(explore::report::wrapped(text, columns, 0), "\n");
}

std::string range(double low, double high, bool low_is_open) {
    return fmt::format("{} {:g}, up to {:g}", low_is_open ? "above" : "from", low, high);
}

std::string fallback(const std::optional<double>& value, const std::vector<std::string_view>& choices) {
    if (!value) {
        return "must be given";
    }
    if (!choices.empty()) {
        return fmt::format("`{}`", choices[static_cast<std::size_t>(*value)]);
    }
    return std::isnan(*value) ? "follows from the others" : fmt::format("{:g}", *value);
}

void table(const auto& keys) {
    fmt::print("| key | range | default | meaning |\n|---|---|---|---|\n");
    for (const auto& key : keys) {
        fmt::print("| `{}` | {} | {} | {} |\n", key.key, range(key.low, key.high, key.low_is_open),
                   fallback(key.default_value, {}), key.meaning);
    }
}

std::string range(const explore::study::Key& key) {
    if (!key.allowed.empty()) {
        return std::string(key.allowed);
    }
    return key.choices.empty() ? range(key.low, key.high, key.low_is_open)
                               : fmt::format("`{}`", fmt::join(key.choices, "`, `"));
}

// The keys of a study's own tables.
void study_tables() {
    std::string_view heading = "-";
    for (const auto& key : explore::study::study_keys()) {
        if (key.table != heading) {
            heading = key.table;
            fmt::print("\n### {}\n\n| key | what may stand there | default | meaning |\n|---|---|---|---|\n",
                       heading.empty() ? "Above all tables" : fmt::format("`{}`", heading));
        }
        fmt::print("| `{}` | {} | {} | {} |\n", key.key, range(key),
                   key.without.empty() ? fallback(key.default_value, {key.choices.begin(), key.choices.end()})
                                       : std::string(key.without),
                   key.meaning);
    }
}

} // namespace

int main() {
    fmt::print(
        "# Keys of a study\n\n"
        "Made from the program's own tables by `build/release/tools/keys/study_keys`; a test fails when this page is "
        "stale. The\nunit of a key is the end of its name.\n\n## Tables\n");
    study_tables();
    fmt::print("\n## Layers\n\nThe numbers of a layer, whatever its law.\n\n");
    table(pavement::layer_keys());
    fmt::print("\n## Laws\n\nThe usual range is where `pavescape compare` looks for what a study does not bound.\n");
    for (const material::Law* law : material::laws()) {
        fmt::print("\n### `{}`\n\n{}\n\n| key | range | default | usual range | meaning |\n|---|---|---|---|---|\n",
                   law->name(), in_lines(fmt::format("{}.", law->summary())));
        for (const auto& info : law->parameters()) {
            std::string allowed = range(info.low, info.high, info.low_is_open);
            if (!info.choices.empty()) {
                allowed = fmt::format("`{}`", fmt::join(info.choices, "`, `"));
            }
            fmt::print("| `{}` | {} | {} | {} | {} |\n", info.key, allowed, fallback(info.default_value, info.choices),
                       info.usual ? fmt::format("{:g} to {:g}{}", info.usual->low, info.usual->high,
                                                info.usual->log ? ", by equal ratios" : "")
                                  : "",
                       info.meaning);
        }
    }
    fmt::print("\n## Loads\n");
    const std::pair<const char*, std::pair<pavement::LoadType, pavement::Patch>> loads[] = {
        {"plate", {pavement::LoadType::plate, pavement::Patch::circle}},
        {"wheel", {pavement::LoadType::wheel, pavement::Patch::rectangle}},
        {"dual-wheel", {pavement::LoadType::dual_wheel, pavement::Patch::rectangle}},
        {"gear", {pavement::LoadType::gear, pavement::Patch::circle}}};
    for (const auto& [name, kind] : loads) {
        fmt::print("\n### `{}`\n\n", name);
        table(pavement::load_keys(kind.first, kind.second));
        if (kind.first != pavement::LoadType::gear) {
            fmt::print("\nWith a `history` (the {} is its largest):\n\n",
                       kind.first == pavement::LoadType::plate ? "pressure" : "force or the pressure");
            table(pavement::load_keys(kind.first, kind.second, true));
        }
    }
    fmt::print("\n## Corrections\n\nThe paths of their factors are LAYER-CHANNEL.factor_1, _2, ..., or "
               "readings-CHANNEL.factor_1, ...\n\n| channel | places | what it multiplies | places are |\n"
               "|---|---|---|---|\n");
    for (const pavement::ChannelInfo& channel : pavement::channels()) {
        fmt::print("| `{}` | `at_{}` | {} | {} |\n", channel.name, channel.unit,
                   channel.of_layer ? "the modulus of the layer" : "readings", channel.meaning);
    }
    fmt::print("\n## Effects\n\n| effect | unit of `size` | range | no effect | typical | what it is |\n"
               "|---|---|---|---:|---:|---|\n");
    for (const pavement::Effect* effect : pavement::effects()) {
        fmt::print("| `{}` | {} | {:g} to {:g} | {:g} | {:g} | {} |\n", effect->name, effect->unit, effect->low,
                   effect->high, effect->null, effect->typical, effect->mechanism);
    }
}
