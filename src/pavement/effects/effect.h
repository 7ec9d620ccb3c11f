// A missing physical effect: a size with a null value, and how it changes a case.
//
// An effect is one file with one object, named in one line of catalog.cpp. It turns a case into another one: the model
// knows fields, interfaces, springs and the like (section.h, fe/materials.h), not effects.
#pragma once

#include "pavement/section.h"

namespace pave::pavement {

// The layer an effect acts on unless a case says otherwise.
enum class LayerRole {
    none,
    asphalt, // named "asphalt", else the uppermost
    base,    // named "base", else the uppermost stress-dependent one, else the one above the lowest
    subgrade // named "subgrade", else the lowest
};

struct Effect {
    std::string_view name;
    std::string_view unit; // of the size; "-" for a pure number
    double null = 0.0;     // the size that changes nothing, to the last bit
    double low = 0.0;      // prior range of the size, null included; others are refused
    double high = 0.0;
    bool high_is_limit = false; // no larger size exists: an interface that slips freely, a plate that does not bend
    bool log_scale = false;
    double typical = 0.0; // a size that is seen in practice
    std::string_view mechanism;
    std::string_view source;
    std::string_view acts_on;          // what, unless a case says otherwise
    LayerRole layer = LayerRole::none; // a case may name another
    // Options that a case may give.
    bool takes_load = false;
    bool takes_quantity = false;
    bool takes_reading = false;
    bool is_error_of_reading = false; // its size is the error of that one reading, whatever the model says
    bool takes_thickness = false;
    bool takes_offsets = false;

    // In both, applied.layer is given for effects with a layer. Changes c, as load number `load` sees it, by the
    // effect.
    void (*apply)(Case& c, const AppliedEffect& applied, int load) = nullptr;
    // Why the case cannot have the effect, or "".
    std::string (*refuses)(const Case& c, const AppliedEffect& applied) = nullptr;
    // The size in words of the road or the instrument: which way, and how much. "the wheel runs 30 mm beside the
    // gauges"
    std::string (*in_words)(const AppliedEffect& applied) = nullptr;
};

// Not at its null size, or to be modelled at it.
bool is_active(const AppliedEffect& applied);

// The case without effects and corrections that load number `load` meets: they are applied one after the other.
Case with_effects(const Case& c, int load);

// The layer whose stiffness is all that the effect changes, under every load alike; "": it changes more, or other
// things.
std::string layer_stiffened(const Case& c, const AppliedEffect& applied);

// The sensors that an effect changes, if it changes neither layers nor loads; else none.
struct ChangedReadings {
    std::vector<std::size_t> sensors;
    bool are_scaled = false; // multiplied by the size, and no more
};
ChangedReadings readings_changed_alone(const Case& c, const AppliedEffect& applied);

// Why the case cannot have the effect, or "": what the effect itself says, and options that name nothing.
std::string why_impossible(const Case& c, const AppliedEffect& applied);

// For effects. "2.7 times the stated modulus", "40 % of the stated modulus"
std::string stiffness_words(double factor);
// "12 % above what is stated", "3 % below what is stated"
std::string share_words(double factor);
// For effects. Indices of the layers of a name, from above: one, or the parts of one that was divided.
std::vector<std::size_t> layers_named(const Case& c, std::string_view name);
// Depth of the top of a layer [m].
double top_of(const Case& c, std::size_t layer);
// Index of the layer that plays a role, by the rules above; none: there are too few layers.
std::optional<std::size_t> layer_of_role(const Case& c, LayerRole role);
// Multiplies the modulus of a layer.
void scale_modulus(Layer& layer, double factor);
// Shear compliance of an interface that slips by a share [m/Pa]: (1 mm/MPa) size/(1 - size); bonded is 1e-5 mm/MPa.
double slip_compliance(double size);
// Shared by the interfaces of the base: an effect without name, place and functions.
Effect interface_slip();
// Whether a load, or with none given any of them, is a plate.
bool is_plate(const Case& c, std::optional<int> load);
// Why an effect that only readings in time tell cannot be looked for, or "".
std::string why_not_in_time(const Case& c);
// Whether strains or stresses are measured.
bool has_gauges(const Case& c);
// The reading of a sensor, as shares: those it has, or itself.
std::vector<Sensor::Share> shares_of(const Sensor& sensor);
// Makes a linear isotropic layer one of equation 1 with the same stiffness: k2 = k3 = 0, n = 1, the vertical modulus
// stated, so that the effects on its parameters may act on it. Other layers stay as they are.
void make_uzan(Layer& layer);
// G13/E3 of a layer with n and shear_ratio: what is stated, or what follows from n.
double shear_ratio_of(const Layer& layer);
// The logarithm of the modulus varies evenly through the layers of a name, by the size from top to bottom; its mean
// stays.
void add_modulus_gradient(Case& c, std::string_view layer, double size);

} // namespace pave::pavement
