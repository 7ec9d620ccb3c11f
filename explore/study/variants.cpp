#include "study/variants.h"

#include "base/units.h"
#include "data/usual_layouts.h"
#include "pavement/effects/catalog.h"
#include "pavement/effects/effect.h"
#include "study/own_effects.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace explore::study {

using namespace pave::pavement;

problem::Axis size_axis(const Effect& effect) {
    return {.name = std::string(effect.name) + ".size",
            .low = effect.low,
            .high = effect.high,
            .scale = effect.log_scale ? problem::Scale::log : problem::Scale::linear,
            .start = effect.null};
}

namespace {

std::string quantity_name(const Study& study, Quantity quantity) {
    for (std::size_t i = 0; study.has_own_model && i < study.readings.size(); ++i) {
        if (study.model.sensors[i].quantity == quantity) {
            return study.readings[i].quantity;
        }
    }
    return std::string(info(quantity).name);
}

// The usual layouts of as many sensors as the study has on the surface, in which more than one stands elsewhere, none
// farther than the effect's range reaches.
std::vector<Variant> layouts(const Study& study, const Effect& effect) {
    std::vector<double> own; // mm
    for (std::size_t i = 0; i < study.measured().size(); ++i) {
        const Sensor& sensor = study.model.sensors[i];
        if (sensor.quantity == Quantity::deflection && sensor.depth == 0.0) {
            own.push_back(std::hypot(sensor.x, sensor.y) / pave::unit::mm);
        }
    }
    constexpr double same = 1.0; // mm
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end(), [](double a, double b) { return b - a < same; }), own.end());
    std::vector<Variant> list;
    for (const std::vector<double>& usual : data::usual_layouts()) {
        if (usual.size() != own.size()) {
            continue;
        }
        double largest = 0.0;
        int moved = 0;
        Variant variant{.applied = {.effect = &effect}, .on = "sensors at "};
        std::vector<std::string> places;
        for (std::size_t i = 0; i < own.size(); ++i) {
            const double move = std::abs(usual[i] - own[i]);
            largest = std::max(largest, move);
            moved += move >= same ? 1 : 0;
            variant.applied.offsets.push_back(pave::unit::mm * usual[i]);
            places.push_back(fmt::format("{:.0f}", usual[i]));
        }
        variant.on += pave::join(places) + " mm";
        variant.typical = largest;
        if (moved > 1 && largest <= effect.high) {
            list.push_back(std::move(variant));
        }
    }
    return list;
}

} // namespace

std::vector<Variant> variants(const Study& study, const std::vector<std::string>& without, bool is_one_of_many) {
    // The fitted readings and groups.
    std::vector<std::size_t> readings;
    std::vector<std::pair<int, Quantity>> groups;
    for (const Group& group : study.groups) {
        if (!group.held_out) {
            readings.insert(readings.end(), group.rows.begin(), group.rows.end());
            const Sensor& sensor = study.model.sensors[group.rows[0]];
            groups.emplace_back(sensor.load, sensor.quantity);
        }
    }
    std::vector<int> loads;
    std::vector<Quantity> quantities;
    for (const auto& [load, quantity] : groups) {
        if (std::find(loads.begin(), loads.end(), load) == loads.end()) {
            loads.push_back(load);
        }
        if (std::find(quantities.begin(), quantities.end(), quantity) == quantities.end()) {
            quantities.push_back(quantity);
        }
    }
    const auto load_name = [&](int load) { return study.model.loads[static_cast<std::size_t>(load)].name; };
    // The fitted readings that an effect of one instrument changes.
    const auto same_instrument = [&](const AppliedEffect& applied) {
        auto changed = readings_changed_alone(study.model, applied).sensors;
        std::erase_if(changed,
                      [&](std::size_t i) { return std::find(readings.begin(), readings.end(), i) == readings.end(); });
        std::sort(changed.begin(), changed.end());
        return changed;
    };
    // By its place, and by its loads where another instrument stands there.
    const auto instrument_words = [&](const std::vector<std::size_t>& own) {
        const std::string place = study.readings[own.front()].place_words();
        std::string words = "every " + place;
        const auto is_there = [&](std::size_t i) { return study.readings[i].place_words() == place; };
        if (std::count_if(readings.begin(), readings.end(), is_there) > static_cast<std::ptrdiff_t>(own.size())) {
            std::vector<std::string> under;
            for (const std::size_t i : own) {
                const std::string& load = study.readings[i].load;
                if (std::find(under.begin(), under.end(), load) == under.end()) {
                    under.push_back(load);
                }
            }
            words += " under " + pave::join(under);
        }
        return words;
    };
    std::vector<Variant> list;
    for (const Effect* effect : effects_of(study)) {
        const bool has_it = std::any_of(study.model.effects.begin(), study.model.effects.end(),
                                        [&](const AppliedEffect& applied) { return applied.effect == effect; });
        if (has_it || std::find(without.begin(), without.end(), effect->name) != without.end()) {
            continue;
        }
        const auto add = [&](AppliedEffect applied, std::string on) {
            applied.effect = effect;
            applied.size = effect->null;
            if (why_impossible(study.model, applied).empty()) {
                list.push_back({std::move(applied), std::move(on)});
            }
        };
        if (effect->takes_offsets && !study.has_own_model) {
            for (Variant& layout : layouts(study, *effect)) {
                if (why_impossible(study.model, layout.applied).empty()) {
                    list.push_back(std::move(layout));
                }
            }
        }
        // A reading with a name alone has no place: its instrument is not known by it.
        if (effect->takes_reading && (effect->is_error_of_reading || !study.has_own_model)) {
            for (const std::size_t i : readings) {
                AppliedEffect applied{.effect = effect, .reading = static_cast<int>(i)};
                if (effect->is_error_of_reading) {
                    add(std::move(applied), fmt::format("reading {}: {}", i + 1, study.readings[i].words()));
                    continue;
                }
                // An instrument is tried once, and not where an error of its only reading would be the same.
                const auto own = same_instrument(applied);
                if (own.size() > (is_one_of_many ? 0 : 1) && own.front() == i) {
                    add(std::move(applied), instrument_words(own));
                }
            }
        }
        if (effect->takes_quantity) {
            for (const auto& [load, quantity] : groups) {
                add({.load = load, .quantity = quantity},
                    fmt::format("{}, {}", load_name(load), quantity_name(study, quantity)));
            }
            // Instruments of different kinds have no gain in common: that would be the load.
            if (loads.size() > 1 && quantities.size() > 1) {
                for (const Quantity quantity : quantities) {
                    add({.quantity = quantity}, fmt::format("every {}", quantity_name(study, quantity)));
                }
            }
        } else if (!effect->takes_reading) {
            // An effect with a choice of its own is named by its load where it is that of one.
            for (std::size_t l = 0; effect->takes_load && study.model.loads.size() > 1 && l < loads.size(); ++l) {
                add({.load = loads[l]}, load_name(loads[l]));
            }
            add({}, "");
        }
    }
    return list;
}

Study with_free_effects(Study study, const std::vector<Variant>& variants) {
    for (const Variant& variant : variants) {
        const Effect& effect = *variant.applied.effect;
        study.model.effects.push_back(variant.applied);
        study.model.effects.back().present = true;
        study.space.axes.push_back(size_axis(effect));
        // One of several wrong readings has a name of its own.
        const auto same = std::count_if(study.model.effects.begin(), study.model.effects.end(),
                                        [&](const AppliedEffect& other) { return other.effect == &effect; });
        if (same > 1) {
            study.space.axes.back().name = fmt::format("{}-{}.size", effect.name, same);
        }
        study.parameters.push_back(find_parameter(study.model, study.space.axes.back().name, {.file = study.file}));
        study.hash += fmt::format("+{}({})", effect.name, variant.on);
    }
    return study;
}

namespace {

constexpr std::string_view endless = "half-space"; // bottom of a section without a floor

// A piece of text to be replaced.
struct Edit {
    std::size_t begin = 0, end = 0; // bytes
    std::string text;
};

class Editor {
public:
    explicit Editor(std::string text) : text_(std::move(text)) {
        starts_.push_back(0);
        for (std::size_t i = 0; i < text_.size(); ++i) {
            if (text_[i] == '\n') {
                starts_.push_back(i + 1);
            }
        }
    }
    // Byte of a position, whose column counts code points.
    std::size_t at(toml::source_position position) const {
        std::size_t byte = starts_[position.line - 1];
        const auto continues = [&](std::size_t i) { return i < text_.size() && (text_[i] & 0xC0) == 0x80; };
        for (auto column = position.column; column > 1; --column) {
            do {
                ++byte;
            } while (continues(byte));
        }
        return byte;
    }
    void replace(const toml::node& node, std::string text) {
        edits_.push_back({at(node.source().begin), at(node.source().end), std::move(text)});
    }
    // Gives a table a key that it does not state.
    void insert(const toml::table& table, const std::string& key, const std::string& value) {
        const std::size_t begin = at(table.source().begin);
        if (text_[begin] == '{') {
            edits_.push_back({begin + 1, begin + 1, fmt::format(" {} = {},", key, value)});
        } else if (text_[begin] == '[') {
            const std::size_t end = std::min(text_.find('\n', begin), text_.size());
            edits_.push_back({end, end, fmt::format("\n{} = {}", key, value)});
        } else { // made by dotted keys: a.b = 1
            const std::size_t line = text_.rfind('\n', begin) + 1;
            const std::string path = text_.substr(line, text_.find('=', begin) - line);
            edits_.push_back({line, line, fmt::format("{}{} = {}\n", path.substr(0, path.rfind('.') + 1), key, value)});
        }
    }
    std::string result() {
        std::stable_sort(edits_.begin(), edits_.end(), [](const Edit& a, const Edit& b) { return a.begin > b.begin; });
        for (const Edit& edit : edits_) {
            text_.replace(edit.begin, edit.end - edit.begin, edit.text);
        }
        return text_.ends_with('\n') ? text_ : text_ + '\n';
    }

private:
    std::string text_;
    std::vector<std::size_t> starts_; // of the lines
    std::vector<Edit> edits_;
};

// The table of the array `list` with this name; nullptr: none.
const toml::table* named(const toml::table& root, std::string_view list, const std::string& name) {
    if (const toml::array* tables = root[list].as_array()) {
        for (const toml::node& node : *tables) {
            const toml::table* table = node.as_table();
            if (table != nullptr && (*table)["name"].value_or(std::string()) == name) {
                return table;
            }
        }
    }
    return nullptr;
}

std::string quoted(const std::string& text) {
    std::ostringstream stream;
    stream << toml::value<std::string>(text);
    return stream.str();
}

} // namespace

std::string extended_text(const Study& extended, const std::vector<Variant>& variants,
                          const std::vector<double>& values, const std::string& folder) {
    const toml::table root = toml::parse(extended.text, extended.file);
    Editor editor(extended.text);
    const auto own = std::filesystem::absolute(extended.file).parent_path();
    bool outside = false;
    const auto replace_path = [&](const toml::node& file) {
        const auto path = (own / file.value_or(std::string()))
                              .lexically_normal()
                              .lexically_proximate(std::filesystem::absolute(folder));
        editor.replace(file, quoted(path.generic_string()));
        outside = outside || leaves_folder(path);
    };
    const auto put = [&](const toml::table& table, const std::string& key, const std::string& value) {
        if (const toml::node* node = table.get(key)) {
            editor.replace(*node, value);
        } else {
            editor.insert(table, key, value);
        }
    };
    const auto set = [&](const toml::table& table, const std::string& key, double value) {
        put(table, key, fmt::format("{}", value));
    };
    if (const toml::array* loads = root["loads"].as_array()) {
        for (const toml::node& load : *loads) {
            if (const toml::node* history = load.as_table()->get("history")) {
                replace_path(*history);
            }
        }
    }
    if (const toml::array* files = root["data"]["files"].as_array()) {
        for (const toml::node& file : *files) {
            replace_path(file);
        }
        if (outside && root["data"]["outside"].value_or(false) == false) {
            put(*root["data"].as_table(), "outside", "true");
        }
    }
    if (const toml::table* model = root["model"].as_table()) {
        const std::string before = (*model)["folder"].value_or(std::string("."));
        const std::string there =
            (own / before).lexically_normal().lexically_proximate(std::filesystem::absolute(folder)).generic_string();
        if (const toml::node* stated = model->get("folder")) {
            editor.replace(*stated, quoted(there));
        } else if (model->contains("command")) {
            editor.insert(*model, "folder", quoted(there));
        }
    }
    const toml::table* solver = root["solver"].as_table();
    if (extended.load_steps == LoadSteps::chosen && solver != nullptr) {
        editor.insert(*solver, "load_steps", fmt::format("{}", extended.model.settings.solver.load_steps));
    }
    const toml::table* section = root["section"].as_table();
    const bool loses_floor = extended.model.half_space && root["section"]["bottom"].value_or(std::string()) != endless;
    if (loses_floor && section != nullptr) {
        put(*section, "bottom", quoted(std::string(endless)));
    }
    const std::size_t known = values.size() - variants.size();
    for (std::size_t k = 0; k < known; ++k) {
        const std::string& path = extended.parameters[k].path;
        if (extended.has_own_model && !extended.parameters[k].in_effect) {
            set(*named(root, "parameters", path), "value", values[k]);
            continue;
        }
        const auto dot = path.rfind('.');
        const std::string owner = path.substr(0, dot);
        const std::string key = path.substr(dot + 1);
        for (const std::string_view list : {"layers", "loads", "effects"}) {
            if (const toml::table* table = named(root, list, owner)) {
                set(*table, key, values[k]);
            }
        }
    }
    // A declared effect gets its size where it stands.
    const auto declared = [&](const Variant& variant) {
        return find_effect(variant.applied.effect->name) == nullptr
                   ? named(root, "effects", std::string(variant.applied.effect->name))
                   : nullptr;
    };
    for (std::size_t v = 0; v < variants.size(); ++v) {
        if (const toml::table* table = declared(variants[v])) {
            set(*table, "size", values[known + v]);
        }
    }
    std::string result = editor.result();
    if (extended.load_steps == LoadSteps::chosen && solver == nullptr) {
        result += fmt::format("\n[solver]\nload_steps = {}\n", extended.model.settings.solver.load_steps);
    }
    if (loses_floor && section == nullptr) {
        result += fmt::format("\n[section]\nbottom = {}\n", quoted(std::string(endless)));
    }
    for (std::size_t v = 0; v < variants.size(); ++v) {
        const AppliedEffect& applied = variants[v].applied;
        const Effect& effect = *applied.effect;
        if (declared(variants[v]) == nullptr) {
            result += fmt::format("\n[[effects]]\nname = \"{}\"\nsize = {}  # {}\n", effect.name, values[known + v],
                                  effect.unit);
        }
        if (!applied.layer.empty()) {
            result += fmt::format("layer = {}\n", quoted(applied.layer));
        }
        if (applied.load) {
            result +=
                fmt::format("load = {}\n", quoted(extended.model.loads[static_cast<std::size_t>(*applied.load)].name));
        }
        if (applied.quantity) {
            result += fmt::format("quantity = {}\n", quoted(quantity_name(extended, *applied.quantity)));
        }
        if (applied.reading) {
            result += fmt::format("reading = {}\n", *applied.reading + 1);
        }
        if (applied.thickness) {
            result += fmt::format("thickness_mm = {}\n", *applied.thickness / pave::unit::mm);
        }
        if (!applied.offsets.empty()) {
            std::vector<std::string> offsets;
            for (const double offset : applied.offsets) {
                offsets.push_back(fmt::format("{}", offset / pave::unit::mm));
            }
            result += fmt::format("offsets_mm = [{}]\n", pave::join(offsets));
        }
        const problem::Axis& axis = extended.space.axes[known + v];
        result += fmt::format("\n[[parameters]]\nname = \"{}\"\nmin = {}\nmax = {}\nscale = \"{}\"\n", axis.name,
                              axis.low, axis.high, axis.scale == problem::Scale::log ? "log" : "linear");
    }
    return result;
}

} // namespace explore::study
