// Plain values of pavement engineering: layers, loads, sensors, settings. SI units.
#pragma once

#include "base/expression.h"
#include "fe/materials.h"
#include "fe/settings.h"
#include "pavement/correction.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pave::pavement {

struct Layer {
    std::string name;
    double thickness = 0.0;       // m
    double density = 0.0;         // kg/m3
    double k0 = 0.0;              // horizontal over vertical initial stress
    double residual_stress = 0.0; // Pa, horizontal compression locked in
    const material::Law* law = nullptr;
    std::vector<double> parameters;     // SI, in the order of law->parameters()
    std::vector<fe::Field> fields{};    // what varies within the layer
    std::optional<double> compliance{}; // m/Pa, shear compliance of the interface at its bottom; none: bonded
    // s, under a pulse: stress = E C (strain + damping_time d(strain)/dt), a damping ratio of pi f damping_time at the
    // frequency f.
    double damping_time = 0.0;

    bool operator==(const Layer&) const = default;
};

enum class LoadType { plate, wheel, dual_wheel, gear };
enum class Patch { circle, rectangle };

struct Load {
    std::string name;
    LoadType type = LoadType::plate;
    double pressure = 0.0; // Pa
    double radius = 0.0;   // m, plate
    double force = 0.0;    // N, wheel and dual wheel: of the whole assembly
    double spacing = 0.0;  // m, dual wheel: between patch centres
    struct Wheel {
        double x = 0.0, y = 0.0; // m
        double force = 0.0;      // N, carried by a circle at the pressure
        bool operator==(const Wheel&) const = default;
    };
    std::vector<Wheel> wheels{}; // of a gear, at least one
    Patch patch = Patch::rectangle;
    double patch_width = 0.16; // m, rectangle
    double factor = 1.0;       // on the pressure, at the same area of contact
    // The pressure is 1 + pressure_shape g times the mean: g = 2 (r/a)^2 - 1 on a circle of radius a,
    // 3/2 (xi^2 + eta^2) - 1 on a rectangle with -1 <= xi, eta <= 1. Positive: heavy edges. The force stays.
    double pressure_shape = 0.0;
    // Pa/m, plate: resists, per area, deflections that differ from the mean one under the plate; none: flexible.
    std::optional<double> plate_stiffness{};
    // s: the load rises and falls as sin^2(pi t / duration). Layers that relax and inertia see it.
    double duration = 0.03;
    // Plate: the inertia of the section answers to the load's pulse, its mass times this; none: static.
    std::optional<double> inertia{};
    // How it was recorded to act, linear between samples of increasing time and nothing before and after; the
    // pressure is its largest. None: the load is static, or has a duration.
    struct Sample {
        double time = 0.0;  // s
        double share = 0.0; // of the pressure
        bool operator==(const Sample&) const = default;
    };
    std::vector<Sample> history{};
    double time_shift = 0.0; // s, from the times of readings to those of the history

    bool is_pulse() const { return !history.empty(); }

    bool operator==(const Load&) const = default;

    // One circle on the axis: the axisymmetric model serves it.
    bool is_axisymmetric() const {
        return type == LoadType::plate || (type == LoadType::wheel && patch == Patch::circle);
    }
    // Where the pressure acts, of all but a gear: one patch on the z axis, or two at x = +- centre.
    struct Footprint {
        Patch shape = Patch::circle;
        double centre = 0.0; // m, x of the patch at x >= 0
        double half_x = 0.0; // m; of a circle both are its radius: the plate's own, or the one that
        double half_y = 0.0; // carries the force at the pressure
        double inner() const { return centre > 0.0 ? centre - half_x : 0.0; }
        double outer() const { return centre + half_x; }
    };
    Footprint footprint() const;
    struct Circle {
        double x = 0.0, y = 0.0, radius = 0.0; // m
    };
    // The patches of a load on circles.
    std::vector<Circle> circles() const;
    // Whether two of them overlap.
    bool circles_overlap() const;
    double total_force() const; // N
};

// deflection: positive down [m]; strains [-] and load-induced stresses [Pa]: positive in compression. What devices on
// the surface make of deflections, slope [-] and benkelman [m]: device.h.
enum class Quantity { deflection, strain_zz, strain_xx, strain_yy, stress_zz, stress_xx, stress_yy, slope, benkelman };

struct QuantityInfo {
    Quantity quantity;
    std::string_view name;
    std::string_view unit; // of reports
    double to_si;          // SI = to_si * report value
};
inline constexpr QuantityInfo quantities[] = {
    {Quantity::deflection, "deflection", "mm", 1e-3},        {Quantity::strain_zz, "strain_zz", "microstrain", 1e-6},
    {Quantity::strain_xx, "strain_xx", "microstrain", 1e-6}, {Quantity::strain_yy, "strain_yy", "microstrain", 1e-6},
    {Quantity::stress_zz, "stress_zz", "kPa", 1e3},          {Quantity::stress_xx, "stress_xx", "kPa", 1e3},
    {Quantity::stress_yy, "stress_yy", "kPa", 1e3},          {Quantity::slope, "slope", "um/m", 1e-6},
    {Quantity::benkelman, "benkelman", "mm", 1e-3},
};
constexpr const QuantityInfo& info(Quantity quantity) {
    return quantities[static_cast<int>(quantity)];
}

// Where something is read. x transverse, y along the traffic, depth down. gauge: length over which strain_zz is
// averaged, centred on depth; 0 = at the point. At an interface the layer below is read.
struct Sensor {
    int load = 0; // index
    Quantity quantity = Quantity::deflection;
    double x = 0.0, y = 0.0, depth = 0.0; // m
    double gauge = 0.0;                   // m
    bool measured = true;                 // by an instrument, which may err; false: a requested response
    double gain = 1.0;                    // of the instrument
    std::optional<double> time{};         // s, under a pulse: when; none: the extreme over time
    // Terms of a reading that is a weighted sum: readings at places beside the sensor, over gauge lengths of their own.
    // None: that of the sensor itself.
    struct Share {
        double dx = 0.0;    // m
        double gauge = 0.0; // m
        double weight = 1.0;
        bool operator==(const Share&) const = default;
    };
    std::vector<Share> shares{};

    bool operator==(const Sensor&) const = default;
};

enum class Integration { incremental, secant };

struct Settings {
    Integration integration = Integration::incremental;
    double extent = 4.0;       // m: the smooth wall
    bool wall_follows = false; // effects and thicknesses move it to default_extent()
    double refine = 1.0;
    fe::SolverSettings solver;
    // Linear layers under circles are computed without a mesh and a wall.
    bool layered = false;
    double time_step = 2e-4; // s, under a pulse
    // Loads on the path of a heavier one are read on the way to it: see path_of_each(). For a section in which nothing
    // varies that is part of a load.
    bool shares_paths = false;
};

struct Effect; // effects/effect.h

// An effect in a case: how big, and on what. An option that is not given is the effect's own choice.
struct AppliedEffect {
    const Effect* effect = nullptr;
    double size = 0.0; // in the effect's unit
    // Modelled at the null size too, because something varies the size or differentiates by it.
    bool present = false;
    std::string layer{};
    std::optional<int> load{};
    std::optional<Quantity> quantity{};
    std::optional<int> reading{};      // index of a sensor
    std::optional<double> thickness{}; // m, of a sublayer
    std::vector<double> offsets{};     // m, of a layout: where its sensors stand, nearest to the load first
};

// A number of a case that follows others: pavement/tie.h.
struct Tie {
    std::string path;
    Expression expression;
};

// Everything a forward run is a function of.
struct Case {
    std::vector<Layer> layers; // top to bottom, on a rigid rough floor unless half_space
    std::vector<Load> loads;
    std::vector<Sensor> sensors;
    Settings settings;
    std::vector<AppliedEffect> effects; // what the above does not say; applied in this order
    // The last layer goes on for ever: its thickness is how deep finite elements reach before those without end.
    bool half_space = false;
    std::vector<Tie> ties{};               // set before the effects act, each after those it reads
    std::vector<Correction> corrections{}; // applied after the effects, in this order

    double depth() const;
    // Whether the response depends on the duration of the load.
    bool relaxes() const;
    // Whether the anisotropy of a layer follows the stress.
    bool turns() const;
    // Whether the strain of a layer derives from an energy, and whether that of every layer that depends on stress
    // does.
    bool has_energy() const;
    bool is_hyperelastic() const;
    // Where the wall stands unless a study says otherwise: 4 m (8 m under a pulse), or twice the depth of the section,
    // or twice the distance of the farthest sensor. Nearer than twice the depth, the wall shows in the far deflections.
    double default_extent() const { return default_extent(depth()); }
    // Of another depth [m].
    double default_extent(double depth) const;
};

// Of each load, the number of the one on whose load path it lies: the heaviest that differs from it in pressure alone,
// where the settings let loads share paths and both are plates that act on the section without effects, time and secant
// equilibrium, and the load is read by its deflections. Else its own, and so where the section has no path: linear or
// hyperelastic.
std::vector<int> path_of_each(const Case& c);

} // namespace pave::pavement
