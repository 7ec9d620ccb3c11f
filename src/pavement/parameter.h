// The numbers of a case by name: "base.k1", "subgrade.modulus_MPa", "fwd.pressure_kPa", "base-tension.size",
// "subgrade-depth.factor_2".
#pragma once

#include "base/error.h"
#include "fe/materials.h"
#include "pavement/section.h"

#include <optional>

namespace pave::pavement {

// One number of a layer or a load as it stands in a study file. Keys of a law come from the law itself.
struct KeyInfo {
    std::string_view key;
    double to_si = 1.0;
    double low = 0.0; // file units, inclusive unless low_is_open
    double high = 0.0;
    bool low_is_open = false;
    std::optional<double> default_value; // file units; none = must be given
    std::string_view meaning;
    double& (*of)(Layer&) = nullptr; // exactly one of the two
    double& (*of_load)(Load&) = nullptr;
    bool changes_geometry = false;
};
std::span<const KeyInfo> layer_keys();
// has_history: of a load under a history, whose time and largest force or pressure are recorded.
std::span<const KeyInfo> load_keys(LoadType type, Patch patch, bool has_history = false);
std::span<const KeyInfo> load_keys(const Load& load);

// A number of a case that may be varied.
struct Parameter {
    std::string path;
    bool in_load = false;
    bool in_effect = false;     // the size of an effect
    bool in_correction = false; // a factor of a correction, number `place`
    int owner = 0;              // index of the layer, load, effect or correction
    std::size_t place = 0;
    const KeyInfo* key = nullptr;         // of the layer or load itself, or
    std::optional<std::size_t> law_index; // of the layer's law
    double to_si = 1.0;
    double low = 0.0, high = 0.0; // allowed, file units
    bool low_is_open = false;

    double& in(Case& c) const;       // SI
    double get(const Case& c) const; // file units
    bool changes_geometry() const { return key != nullptr && key->changes_geometry; }
};

// Every path of the case that names a number.
std::vector<std::string> parameter_paths(const Case& c);

// Throws Error (place filled by the caller) when the path names nothing; suggests the nearest name.
Parameter find_parameter(const Case& c, std::string_view path, const Place& place);

// How the responses under one load follow a parameter: the sum of the solver's derivatives by `variation`, each times
// `factor` [per file unit], and what the gains of the sensors add.
struct Derivative {
    struct Term {
        fe::Variation variation;
        double factor = 1.0;
    };
    std::vector<Term> terms;
    std::vector<double> gain_rates; // d(gain)/d(parameter) of each sensor; empty: none changes
};

// Nothing where the solver has no such derivative: places of sensors, geometry of a section with fields, springs or
// inertia or that changes other numbers too. Effects turn numbers of the case into others in closed form; the chain
// rule through them is by differences of those forms, to some 1e-10. A motion of the mesh is by the file value.
std::optional<Derivative> exact_derivative(const Case& c, const Parameter& parameter, int load);

// Whether two cases, their effects applied, are the same under a load but for where and how the sensors read.
bool differ_in_sensors_alone(Case a, Case b, int load);

} // namespace pave::pavement
