// Sections and cases that several tests share.
#pragma once

#include "material/catalog.h"
#include "pavement/forward.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace test {

using namespace pave;
using namespace pave::pavement;

inline Layer linear_layer(std::string name, double thickness, double modulus, double poisson) {
    return {std::move(name), thickness, 2200.0, 0.5, 0.0, material::find_law("linear"), {modulus, poisson}};
}

struct Uzan {
    double k1, k2, k3, n;
    double delta = 5e3; // Pa
    double eta = std::numeric_limits<double>::quiet_NaN();
    double residual_stress = 0.0; // Pa
};

inline Layer uzan_layer(std::string name, double thickness, const Uzan& u) {
    return {std::move(name),
            thickness,
            2200.0,
            0.5,
            u.residual_stress,
            material::find_law("uzan"),
            {0.0, u.k1, u.k2, u.k3, u.n, 0.35, 0.35, material::not_given, u.delta, u.eta}};
}

inline Load plate(double radius = 0.15, double pressure = 595e3) {
    Load load;
    load.name = "fwd";
    load.type = LoadType::plate;
    load.patch = Patch::circle;
    load.radius = radius;
    load.pressure = pressure;
    return load;
}

// The history sin^2(pi t / duration), then nothing until the end.
inline std::vector<Load::Sample> haversine_history(double duration, double until, int parts = 400) {
    std::vector<Load::Sample> list;
    for (int i = 0; i <= parts; ++i) {
        list.push_back({duration * i / parts, i < parts ? std::pow(std::sin(std::numbers::pi * i / parts), 2) : 0.0});
    }
    if (until > duration) {
        list.push_back({until, 0.0});
    }
    return list;
}

inline Load dual_wheel(double force = 40e3, double pressure = 650e3, Patch patch = Patch::rectangle,
                       double spacing = 0.34) {
    Load load;
    load.name = "dual";
    load.type = LoadType::dual_wheel;
    load.patch = patch;
    load.force = force;
    load.pressure = pressure;
    load.spacing = spacing;
    return load;
}

inline Sensor deflection(double x) {
    return {0, Quantity::deflection, x, 0.0, 0.0, 0.0};
}
inline Sensor strain_zz(double depth, double gauge, double x = 0.0) {
    return {0, Quantity::strain_zz, x, 0.0, depth, gauge};
}

// CAPTIF pavement 1 under the FWD plate, with the layout of the reference numbers: deflections at six offsets, then
// seven 75 mm gauges on the axis.
inline Case captif(double asphalt_MPa, double subgrade_MPa, const Uzan& base,
                   Integration integration = Integration::incremental) {
    Case c;
    c.layers = {linear_layer("asphalt", 0.030, asphalt_MPa * 1e6, 0.35), uzan_layer("base", 0.277, base),
                linear_layer("subgrade", 1.193, subgrade_MPa * 1e6, 0.40)};
    c.loads = {plate()};
    for (const double x : {0.0, 0.2, 0.45, 0.6, 0.9, 1.8}) {
        c.sensors.push_back(deflection(x));
    }
    for (int i = 0; i < 7; ++i) {
        c.sensors.push_back(strain_zz(0.1125 + 0.075 * i, 0.075));
    }
    c.settings.integration = integration;
    return c;
}

inline Outcome<Response> run(const Case& c, const std::vector<std::string>& paths = {}) {
    const ForwardModel model(c);
    std::vector<Parameter> parameters;
    for (const std::string& path : paths) {
        parameters.push_back(find_parameter(c, path, {}));
    }
    return model.run(c, parameters, *model.make_workspace());
}

} // namespace test
