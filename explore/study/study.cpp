#include "study/study.h"

#include "pavement/effects/catalog.h"
#include "study/own_effects.h"
#include "study/readings.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::study {

using namespace pave::pavement;

std::string_view Study::noise_name() const {
    return noise == NoiseSource::estimated ? "estimated"
           : noise == NoiseSource::sought  ? "sought"
           : noise_assumed > 0             ? "partly stated"
                                           : "stated";
}

std::string Study::stem() const {
    return std::filesystem::path(file).stem().string();
}

std::string Study::folder_name() const {
    const std::filesystem::path path(file);
    const std::string folder = path.parent_path().filename().string();
    return stem() == "extended" && !folder.empty() ? folder + "-extended" : stem();
}

std::span<const data::Reading> Study::measured() const {
    const auto end = std::find_if(readings.begin(), readings.end(), [](const auto& r) { return !r.is_measured(); });
    return {readings.begin(), end};
}

std::vector<std::size_t> Study::outputs() const {
    std::vector<std::size_t> list;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        if (!readings[i].is_measured()) {
            list.push_back(i);
        }
    }
    return list;
}

std::vector<std::string> Study::groups_fitted() const {
    std::vector<std::string> names;
    for (const Group& group : groups) {
        if (!group.held_out) {
            names.push_back(group.name);
        }
    }
    return names;
}

bool Study::is_at_hand(pave::pavement::Quantity quantity) const {
    if (!possible.empty()) {
        return std::find(possible.begin(), possible.end(), quantity) != possible.end();
    }
    const auto count = static_cast<std::ptrdiff_t>(measured().size());
    return std::any_of(model.sensors.begin(), model.sensors.begin() + count,
                       [&](const auto& sensor) { return sensor.quantity == quantity; });
}

std::size_t Study::held_out_readings() const {
    std::size_t count = 0;
    for (const Group& group : groups) {
        count += group.held_out ? group.rows.size() : 0;
    }
    return count;
}

bool leaves_folder(const std::filesystem::path& path) {
    const auto normal = path.lexically_normal();
    return normal.is_absolute() || (!normal.empty() && *normal.begin() == "..");
}

bool leaves_folder(const std::filesystem::path& folder, const std::filesystem::path& path) {
    std::error_code error; // of a file that is not there, or of a circle of links: others complain of those
    const auto own = std::filesystem::canonical(folder.empty() ? "." : folder, error);
    const auto target = error ? own : std::filesystem::canonical(folder / path, error);
    return leaves_folder(path) || (!error && leaves_folder(target.lexically_relative(own)));
}

void refuse_own_model(const Study& study, const std::string& what) {
    if (study.has_own_model) {
        throw pave::Error({.file = study.file, .key = "model"}, what + " knows the built-in model alone", "[model]",
                          "a study with [[layers]] and [[loads]]");
    }
}

Study with_measurements(Study study, std::vector<data::Reading> measurements) {
    refuse_own_model(study, "what brings readings of its own");
    study.model.sensors.clear();
    study.readings.clear();
    if (study.model.settings.wall_follows) {
        study.model.settings.extent = extent_not_stated;
    }
    for (auto& m : measurements) {
        add_measurement(study, std::move(m));
    }
    set_groups(study, {}, {}, nullptr);
    set_noise(study);
    settle_extent(study);
    study.hash = hash_with_readings(study.hash, study.measured());
    return study;
}

std::vector<std::string> effect_names() {
    std::vector<std::string> names;
    for (const Effect* effect : effects()) {
        names.emplace_back(effect->name);
    }
    return names;
}

void check_effect(const Study& study, const AppliedEffect& applied, const pave::Place& place) {
    if (const std::string why = why_impossible(study.model, applied); !why.empty()) {
        throw pave::Error(place, "the study cannot have this effect: " + why,
                          "\"" + std::string(applied.effect->name) + "\"",
                          "what it acts on: " + std::string(applied.effect->acts_on));
    }
}

const Effect& effect_named(const std::string& name, const pave::Place& place) {
    if (const Effect* effect = find_effect(name)) {
        return *effect;
    }
    const auto names = effect_names();
    const std::string near = pave::nearest_name(name, names);
    throw pave::Error(place, near.empty() ? "unknown effect" : "unknown effect, did you mean \"" + near + "\"?",
                      "\"" + name + "\"", pave::join(names));
}

Study with_effect(Study study, const std::string& name, double size, const pave::Place& place) {
    const Effect* effect = study.has_own_model ? &effect_named(study, name, place) : &effect_named(name, place);
    if (!(size >= effect->low && size <= effect->high)) {
        throw pave::Error(place, "size out of range", fmt::format("{} = {}", name, size),
                          fmt::format("{} <= size <= {} [{}]", effect->low, effect->high, effect->unit));
    }
    auto& applied = study.model.effects;
    auto own = std::find_if(applied.begin(), applied.end(), [&](const auto& a) { return a.effect == effect; });
    if (own == applied.end()) {
        AppliedEffect added;
        added.effect = effect;
        if (find_effect(name) != nullptr) { // what a study declares is for its own model
            check_effect(study, added, place);
        }
        own = applied.insert(applied.end(), std::move(added));
    }
    own->size = size;
    return study;
}

} // namespace explore::study
