// Draws a section, its parameters, a layout of sensors, noise and what the model will lack from a seed, and writes
// study.toml and data.csv as an engineer would bring them; the truth goes to standard output as one JSON object, where
// only the judge reads it.
//
// usage: blind_generator SEED FOLDER KIND [LEAST MOST] [correlated | few | middle | DATA]
//   KIND   none, one, two, the name of an effect, or outside: one that is neither in the catalogue nor of the form of a
//          correction; LEAST MOST: its strength, in standard deviations (8 20); correlated: errors are tied as those of
//          repeated drops are, and the study says so; independent.toml and its data say that they are not; few: 11
//          readings instead of 40 to 59, and further.csv says what instruments at other places and a heavier drop
//          would read; middle: 20 to 40 readings
//   DATA   what the data have that the study does not state: understated, overstated (errors 1.5 times as large or as
//          small as stated), heavy (errors of Student's t with four degrees of freedom, of the stated deviation), bad
//          (two or three readings wrong by 7 to 15 deviations), common (each load's readings share an error of 1 to 3
//          %), tied (errors of neighbouring readings are alike), fault (of the file: two sensors exchanged, all counted
//          from the far end, one in another unit)
//
// The data come from a mesh 2.5 times as fine and from load paths ten times as exact as the study asks for. Half of the
// effects that are fields of the section have another form here than in the catalogue. The strength of an effect is
// what it changes in the data, in standard deviations, beyond what the parameters that will be fitted can follow at the
// truth, computed here from finite differences; so is how well it could be told from every other effect.
#include "base/random.h"
#include "base/units.h"
#include "material/catalog.h"
#include "pavement/effects/catalog.h"
#include "pavement/effects/effect.h"
#include "pavement/forward.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gsl/gsl_cdf.h>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>

namespace {

using namespace pave;
using namespace pave::pavement;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

class Draw {
public:
    Draw(std::uint64_t seed, std::uint64_t stream) : random_(seed, stream) {}
    double uniform(double low, double high) { return low + (high - low) * random_.uniform(next_++); }
    double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
    std::size_t below(std::size_t n) {
        return std::min(n - 1, static_cast<std::size_t>(uniform(0.0, 1.0) * static_cast<double>(n)));
    }
    bool chance(double p) { return uniform(0.0, 1.0) < p; }
    double normal() { return random_.normal(1'000'000 + normal_++); }

private:
    RandomStream random_;
    std::uint64_t next_ = 0;
    std::uint64_t normal_ = 0;
};

double rounded(double value, double step) {
    return step * std::round(value / step);
}

Case draw_case(Draw& draw) {
    Case c;
    const auto linear = [](std::string name, double thickness, double modulus, double poisson) {
        return Layer{std::move(name), thickness, 2200.0, 0.5, 0.0, material::find_law("linear"), {modulus, poisson}};
    };
    const double asphalt = rounded(draw.uniform(0.03, 0.12), 0.005);
    const double base = rounded(draw.uniform(0.18, 0.40), 0.005);
    const double floor = rounded(draw.uniform(1.4, 3.0), 0.05);
    c.layers.push_back(linear("asphalt", asphalt, draw.log_uniform(1.5e9, 6e9), 0.35));
    Layer granular{"base", base, 2200.0, 0.5, 0.0, material::find_law("uzan"), {}};
    for (const auto& info : granular.law->parameters()) {
        granular.parameters.push_back(info.to_si * info.default_value.value_or(0.0));
    }
    const auto set = [&](std::string_view key, double value) {
        granular.parameters[*granular.law->index_of(key)] = value;
    };
    set("k1", draw.log_uniform(900.0, 3000.0));
    set("k2", draw.uniform(0.35, 0.75));
    set("k3", draw.uniform(-0.6, -0.05));
    set("n", draw.uniform(0.3, 0.75));
    set("poisson_12", 0.35);
    set("poisson_31", 0.35);
    c.layers.push_back(granular);
    c.layers.push_back(linear("subgrade", floor - asphalt - base, draw.log_uniform(30e6, 100e6), 0.40));
    Load plate;
    plate.name = "fwd";
    plate.type = LoadType::plate;
    plate.patch = Patch::circle;
    plate.radius = 0.15;
    plate.pressure = rounded(draw.uniform(450e3, 800e3), 1e3);
    Load wheel;
    wheel.name = "wheel";
    wheel.type = LoadType::wheel;
    wheel.patch = Patch::circle;
    wheel.force = rounded(draw.uniform(20e3, 40e3), 100.0);
    wheel.pressure = rounded(draw.uniform(550e3, 850e3), 1e3);
    c.loads = {plate, wheel};

    const auto add = [&](int load, Quantity quantity, double x, double depth, double gauge) {
        c.sensors.push_back({load, quantity, x, 0.0, depth, gauge});
    };
    for (const double x : {0.0, 0.2, 0.3, 0.45, 0.6, 0.9, 1.2, 1.5}) {
        add(0, Quantity::deflection, x, 0.0, 0.0);
        if (x < 1.4) {
            add(1, Quantity::deflection, x, 0.0, 0.0);
        }
    }
    const double gauge = draw.chance(0.7) ? 0.075 : 0.05;
    const double aside = rounded(draw.uniform(0.1, 0.35), 0.01);
    const double farther = aside + rounded(draw.uniform(0.15, 0.4), 0.01);
    const bool under_plate = draw.chance(0.7);
    const auto strains = [&](double depth) {
        add(1, Quantity::strain_zz, 0.0, depth, gauge);
        add(1, Quantity::strain_zz, aside, depth, gauge);
        add(1, Quantity::strain_zz, farther, depth, gauge);
        if (under_plate) {
            add(0, Quantity::strain_zz, 0.0, depth, gauge);
        }
    };
    constexpr int in_base = 3;
    for (int i = 0; i < in_base; ++i) {
        strains(rounded(asphalt + base * (i + 0.5) / in_base, 0.005));
    }
    const std::size_t in_subgrade = 4 + draw.below(3);
    for (std::size_t i = 0; i < in_subgrade; ++i) {
        strains(rounded(asphalt + base + 0.06 + 0.10 * static_cast<double>(i), 0.005));
    }
    for (const double depth :
         {asphalt + 0.4 * base, asphalt + 0.8 * base, asphalt + base + 0.1, asphalt + base + 0.3}) {
        add(1, Quantity::stress_zz, 0.0, rounded(depth, 0.005), 0.0);
        if (draw.chance(0.6)) {
            add(0, Quantity::stress_zz, 0.0, rounded(depth, 0.005), 0.0);
        }
    }
    c.settings.extent = c.default_extent();
    c.settings.wall_follows = true; // as in the study that is written, which states none
    return c;
}

// The deflections of the plate and, under the wheel, the strains at the three upper depths.
void keep_few(Case& c) {
    std::size_t strains = 0;
    std::erase_if(c.sensors, [&](const Sensor& s) {
        constexpr std::size_t most = 3;
        const bool is_strain = s.load == 1 && s.quantity == Quantity::strain_zz && s.x == 0.0;
        return !(s.load == 0 && s.quantity == Quantity::deflection) && !(is_strain && ++strains <= most);
    });
}

// The deflections of the plate and so many others that 20 to 40 are left, drawn evenly.
void keep_middle(Case& c, Draw& draw) {
    constexpr std::size_t least = 20;
    constexpr std::size_t most = 40;
    const std::size_t count = least + draw.below(most - least + 1);
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        if (!(c.sensors[i].load == 0 && c.sensors[i].quantity == Quantity::deflection)) {
            others.push_back(i);
        }
    }
    std::set<std::size_t> dropped;
    while (c.sensors.size() - dropped.size() > count) {
        const auto at = others.begin() + static_cast<std::ptrdiff_t>(draw.below(others.size()));
        dropped.insert(*at);
        others.erase(at);
    }
    std::size_t index = 0;
    std::erase_if(c.sensors, [&](const Sensor&) { return dropped.contains(index++); });
}

// Layouts of seven sensors [mm]: two of which one stands in a file where the other was driven.
constexpr std::array<std::array<double, 7>, 2> mistaken_layouts[] = {
    {{{0, 200, 300, 600, 900, 1200, 1500}, {0, 210, 315, 475, 630, 925, 1535}}},
    {{{0, 200, 300, 450, 600, 900, 1200}, {0, 200, 300, 600, 900, 1200, 1500}}},
    {{{0, 300, 450, 600, 900, 1200, 1500}, {0, 300, 600, 900, 1200, 1500, 1800}}},
};

// Puts the deflections of every load that has any at the places of one layout; the same case as the file states it.
Case lay_out(Case& c, Draw& draw, nlohmann::ordered_json& truth) {
    const auto& pair = mistaken_layouts[draw.below(std::size(mistaken_layouts))];
    const std::size_t stands = draw.chance(0.5) ? 1 : 0;
    truth["sensors_mm"] = pair[stands];
    std::set<int> loads;
    for (const Sensor& sensor : c.sensors) {
        if (sensor.quantity == Quantity::deflection) {
            loads.insert(sensor.load);
        }
    }
    std::erase_if(c.sensors, [](const Sensor& sensor) { return sensor.quantity == Quantity::deflection; });
    Case stated = c;
    for (const int load : loads) {
        for (std::size_t i = 0; i < pair[0].size(); ++i) {
            c.sensors.push_back({load, Quantity::deflection, pair[stands][i] * unit::mm, 0.0, 0.0, 0.0});
            stated.sensors.push_back({load, Quantity::deflection, pair[1 - stands][i] * unit::mm, 0.0, 0.0, 0.0});
        }
    }
    return stated;
}

// What else could be read: under both loads and under a drop that is half as heavy again; the strains of the study once
// more, by other gauges.
Case with_further_readings(Case c) {
    Load heavier = c.loads[0];
    heavier.name += " at 150 % of the pressure";
    heavier.pressure *= 1.5;
    c.loads.push_back(heavier);
    std::vector<Sensor> more;
    for (int load = 0; load < 3; ++load) {
        for (const double x : {0.0, 0.2, 0.3, 0.45, 0.6, 0.9, 1.2, 1.5, 1.8}) {
            more.push_back({load, Quantity::deflection, x, 0.0, 0.0, 0.0});
        }
        if (load < 2) {
            constexpr double gauge = 0.075;
            const double asphalt = c.layers[0].thickness;
            const double base = c.layers[1].thickness;
            more.push_back({load, Quantity::strain_xx, 0.0, 0.0, asphalt - unit::mm, 0.0});
            more.push_back({load, Quantity::strain_zz, 0.0, 0.0, asphalt + base / 2.0, gauge});
            more.push_back({load, Quantity::strain_zz, 0.0, 0.0, asphalt + base + gauge / 2.0, gauge});
            more.push_back({load, Quantity::stress_zz, 0.0, 0.0, asphalt + base + gauge / 2.0, 0.0});
        }
    }
    std::copy_if(c.sensors.begin(), c.sensors.end(), std::back_inserter(more),
                 [](const Sensor& s) { return s.quantity == Quantity::strain_zz; });
    c.sensors.insert(c.sensors.end(), more.begin(), more.end()); // those that an effect names keep their numbers
    return c;
}

// Standard deviations that are common: of a deflection 2 % and 2 um, a strain 5 % and 10 microstrain, a stress 10 % and
// 2 kPa.
double common_noise(Quantity quantity, double value) {
    switch (quantity) {
    case Quantity::deflection: return std::hypot(0.02 * value, 2e-6);
    case Quantity::stress_zz: return std::hypot(0.10 * value, 2.0 * unit::kPa);
    default: return std::hypot(0.05 * value, 10e-6);
    }
}

constexpr double fine_refine = 1.5;

// Where neighbouring readings share their errors, their differences are known to a third of one reading's: the mesh
// must be right to that.
double study_refine(bool correlated) {
    return correlated ? 0.9 : 0.6;
}

Case finer(Case c) {
    c.settings.refine = fine_refine;
    c.settings.solver.load_steps *= 3;
    return c;
}

// Responses; empty: none.
VectorXd responses(const Case& c) {
    const ForwardModel model(c);
    const auto outcome = model.run(c, {}, *model.make_workspace());
    if (!outcome) {
        return {};
    }
    return VectorXd::Map(outcome->values.data(), static_cast<Eigen::Index>(outcome->values.size()));
}

// Other forms than the catalogue's.
double rational_distance(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    const double d = std::hypot(std::abs(at[0]) - shape[0], at[1]);
    const double reach = 1.5 * shape[1];
    return d * d / (d * d + reach * reach);
}
double root_of_depth(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return std::sqrt(std::max(0.0, at[2] - shape[0]));
}
double fading_with_depth(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    constexpr double reach = 0.2; // m
    return -1.0 / (1.0 + std::pow(std::max(0.0, at[2] - shape[0]) / reach, 4));
}

// Physics that no effect of the catalogue has. Its size is of the logarithm of a modulus, but for the last three.
struct Outside {
    std::string_view name;
    std::string_view channel, layer;                                            // where it acts; layer "": on readings
    double most;                                                                // size
    double (*weight)(const fe::Field::Shape& shape, const Eigen::Vector3d& at); // of a modulus; none: see apply_outside
};

struct Hidden {
    const Effect* effect = nullptr;
    AppliedEffect options; // what it acts on
    std::string form;      // empty: the catalogue's own
    double size = 0.0;
    const Outside* outside = nullptr; // in place of an effect
    double place = 0.0, width = 0.0;  // m, of that

    std::string name() const { return std::string(outside != nullptr ? outside->name : effect->name); }
};

// shape: top of the layer, its thickness, place, width.
double lens(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return -1.0 / (1.0 + std::pow((at[2] - shape[0] - shape[2]) / shape[3], 8));
}
double crust(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return std::exp(-std::pow((at[2] - shape[0]) / shape[3], 2));
}
double bulge(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    const double zeta = (at[2] - shape[0]) / shape[1];
    return 4.0 * zeta * (1.0 - zeta);
}
double wet_bottom(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    const double zeta = (at[2] - shape[0]) / shape[1];
    return -1.0 / (1.0 + std::exp((0.67 - zeta) / 0.04));
}
// shape: x of the load's patch, half its width, place, width.
double aside(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return std::hypot(std::abs(at[0]) - shape[0], at[1]);
}
double outside_radius(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return -1.0 / (1.0 + std::exp((shape[2] - aside(shape, at)) / 0.02));
}
double loose_beside(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return std::expm1(-std::pow(aside(shape, at) / (2.0 * shape[3]), 4));
}
double bulb(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return -std::exp(-std::pow(aside(shape, at) / (2.0 * shape[3]), 2));
}

constexpr Outside outsides[] = {
    {"wet-lens", "depth", "subgrade", 2.5, lens},
    {"stiff-crust", "depth", "subgrade", 2.0, crust},
    {"compaction-bulge", "depth", "base", 2.0, bulge},
    {"wet-base-bottom", "depth", "base", 2.5, wet_bottom},
    {"cracked-asphalt", "distance", "asphalt", 3.0, outside_radius},
    {"loose-base", "distance", "base", 2.5, loose_beside},
    {"softened-bulb", "distance", "subgrade", 2.0, bulb},
    {"confined-subgrade", "theta", "subgrade", 1.5, nullptr}, // E in proportion to theta^size
    {"tilted-bar", "offset", "", 0.5, nullptr},               // every sensor farther off by this share
    {"gauges-by-depth", "level", "", 1.0, nullptr},           // readings times 1 + size (depth/0.5 m)^2
};

void apply_outside(Case& c, const Hidden& hidden, int load) {
    const Outside& outside = *hidden.outside;
    if (outside.weight != nullptr) {
        const std::size_t l = layers_named(c, outside.layer).front();
        const auto patch = c.loads[static_cast<std::size_t>(load)].footprint();
        const bool is_depth = outside.channel == "depth";
        c.layers[l].fields.push_back(
            {.parameter = {},
             .is_power = true,
             .size = hidden.size,
             .weight = outside.weight,
             .shape = {is_depth ? top_of(c, l) : patch.centre, is_depth ? c.layers[l].thickness : patch.half_x,
                       hidden.place, hidden.width}});
    } else if (outside.channel == "theta") {
        Layer& layer = c.layers.back();
        make_uzan(layer);
        layer.parameters[*layer.law->index_of("k2")] = hidden.size;
    } else {
        for (Sensor& sensor : c.sensors) {
            const bool is_deflection = sensor.quantity == Quantity::deflection;
            if (is_deflection && outside.channel == "offset") {
                sensor.x *= 1.0 + hidden.size;
            } else if (!is_deflection && outside.channel == "level") {
                sensor.gain *= 1.0 + hidden.size * std::pow(sensor.depth / 0.5, 2);
            }
        }
    }
}

// The modulus of a linear layer along the channel: [place in mm, MPa].
Json profile(const Case& c, const Hidden& hidden) {
    Json list = Json::array();
    const Outside& outside = *hidden.outside;
    const std::size_t l = outside.layer.empty() ? 0 : layers_named(c, outside.layer).front();
    if (outside.weight == nullptr || c.layers[l].law->stress_dependent()) {
        return list;
    }
    const bool is_depth = outside.channel == "depth";
    const double top = is_depth ? top_of(c, l) : 0.0;
    const fe::Field::Shape shape{top, is_depth ? c.layers[l].thickness : 0.1, hidden.place, hidden.width};
    for (double at = 0.0; at < (is_depth ? c.layers[l].thickness : 2.0); at += 0.01) {
        const Eigen::Vector3d point = is_depth ? Eigen::Vector3d{0, 0, top + at} : Eigen::Vector3d{at, 0, 0};
        list.push_back({at / unit::mm,
                        c.layers[l].parameters[0] * std::exp(hidden.size * outside.weight(shape, point)) / unit::MPa});
    }
    return list;
}

// The catalogue's forms turn a case into another for one load at a time; ours do so here.
constexpr std::string_view forms[][2] = {
    {"anisotropy-distribution", "n rises with d^2/(d^2 + (1.5 a)^2), whatever the depth"},
    {"subgrade-depth-gradient", "E grows with the root of the depth"},
    {"weak-subgrade-top", "E falls towards the top without a step, like 1/(1 + (depth/200 mm)^4)"},
    {"base-residual-stress", "a quarter more of it in the lower half of the base, a quarter less in the upper"},
    {"wheel-wander", "the wheel is anywhere within a band alike"},
};

void apply_form(Case& c, const Hidden& hidden, int load) {
    if (hidden.outside != nullptr) {
        apply_outside(c, hidden, load);
        return;
    }
    const std::string_view name = hidden.effect->name;
    const std::size_t base = 1;
    const std::size_t subgrade = c.layers.size() - 1;
    if (name == "anisotropy-distribution") {
        const auto patch = c.loads[static_cast<std::size_t>(load)].footprint();
        c.layers[base].fields.push_back({.parameter = c.layers[base].law->index_of("n"),
                                         .target = 1.0,
                                         .size = hidden.size,
                                         .weight = rational_distance,
                                         .shape = {patch.centre, patch.half_x}});
    } else if (name == "subgrade-depth-gradient") {
        c.layers[subgrade].fields.push_back(
            {.parameter = {}, .size = hidden.size, .weight = root_of_depth, .shape = {top_of(c, subgrade)}});
    } else if (name == "weak-subgrade-top") {
        c.layers[subgrade].fields.push_back({.parameter = {},
                                             .size = 1.0 - std::exp(-hidden.size),
                                             .weight = fading_with_depth,
                                             .shape = {top_of(c, subgrade)}});
    } else if (name == "base-residual-stress") {
        Layer upper = c.layers[base];
        upper.thickness /= 2.0;
        c.layers[base].thickness -= upper.thickness;
        upper.residual_stress += 0.75 * hidden.size * unit::kPa;
        c.layers[base].residual_stress += 1.25 * hidden.size * unit::kPa;
        c.layers.insert(c.layers.begin() + static_cast<std::ptrdiff_t>(base), upper);
    } else { // wheel-wander: a band of the same standard deviation
        constexpr int places = 15;
        for (Sensor& sensor : c.sensors) {
            if (sensor.load == load && c.loads[static_cast<std::size_t>(load)].type != LoadType::plate) {
                for (int i = 0; i < places; ++i) {
                    const double at = std::sqrt(3.0) * ((2.0 * i + 1.0) / places - 1.0);
                    sensor.shares.push_back({at * hidden.size * unit::mm, 0.0, 1.0 / places});
                }
            }
        }
    }
}

// Responses with what is hidden; other forms are applied load by load, so each load is run alone.
VectorXd responses_with(const Case& plain, const std::vector<Hidden>& hidden) {
    Case c = plain;
    bool own_form = false;
    for (const Hidden& h : hidden) {
        if (h.effect != nullptr && h.form.empty()) {
            c.effects.push_back(h.options);
            c.effects.back().effect = h.effect;
            c.effects.back().size = h.size;
        }
        own_form = own_form || h.outside != nullptr || !h.form.empty();
    }
    if (!own_form) {
        return responses(c);
    }
    VectorXd all(static_cast<Eigen::Index>(plain.sensors.size()));
    for (std::size_t load = 0; load < c.loads.size(); ++load) {
        Case one = c;
        for (const Hidden& h : hidden) {
            if (h.outside != nullptr || !h.form.empty()) {
                apply_form(one, h, static_cast<int>(load));
            }
        }
        const ForwardModel model(one);
        const auto outcome = model.run(one, {}, *model.make_workspace());
        if (!outcome) {
            return {};
        }
        for (std::size_t i = 0; i < plain.sensors.size(); ++i) {
            if (plain.sensors[i].load == static_cast<int>(load)) {
                all[static_cast<Eigen::Index>(i)] = outcome->values[i];
            }
        }
    }
    return all;
}

struct Fitted {
    std::string path;
    double low, high;
    bool is_log;
};
const Fitted fitted[] = {{"asphalt.modulus_MPa", 500, 15000, true},
                         {"base.k1", 300, 8000, true},
                         {"base.k2", 0.05, 1.0, false},
                         {"base.n", 0.1, 1.0, false},
                         {"subgrade.modulus_MPa", 10, 250, true}};

// Errors of readings: their covariance is root root', root a lower triangle.
struct Errors {
    Eigen::MatrixXd root;

    Eigen::Index size() const { return root.rows(); }
    // Independent combinations, in standard deviations.
    VectorXd in_units(const VectorXd& change) const { return root.triangularView<Eigen::Lower>().solve(change); }
};

// Of repeated drops (docs/evidence/ranges.md): own errors are correlated over this distance between readings of one
// load and quantity, and all readings of a load have one in common, this share of the relative one.
constexpr double correlated_mm = 600.0;
constexpr double in_common = 0.6;

// own: standard deviations; common: of the error in common, a reading each; zero where errors are independent.
Errors errors_of(const Case& c, const VectorXd& own, const VectorXd& common) {
    Eigen::MatrixXd covariance = own.cwiseAbs2().asDiagonal();
    for (Eigen::Index i = 0; i < own.size() && common.any(); ++i) {
        for (Eigen::Index k = 0; k < own.size(); ++k) {
            const Sensor& a = c.sensors[static_cast<std::size_t>(i)];
            const Sensor& b = c.sensors[static_cast<std::size_t>(k)];
            if (a.load == b.load) {
                const double apart = std::hypot(a.x - b.x, a.depth - b.depth) / unit::mm;
                covariance(i, k) =
                    common[i] * common[k] +
                    (a.quantity == b.quantity ? own[i] * own[k] * std::exp(-apart / correlated_mm) : 0.0);
            }
        }
    }
    return {covariance.llt().matrixL()};
}

// Of the responses, in standard deviations, by the logarithms of the fitted parameters: central differences. Empty:
// none.
Eigen::MatrixXd derivatives(const Case& c, const Errors& errors) {
    Eigen::MatrixXd j(errors.size(), static_cast<Eigen::Index>(std::size(fitted)));
    constexpr double step = 0.01;
    for (std::size_t k = 0; k < std::size(fitted); ++k) {
        const Parameter p = find_parameter(c, fitted[k].path, {});
        Case up = c;
        Case down = c;
        p.in(up) *= 1.0 + step;
        p.in(down) /= 1.0 + step;
        const VectorXd above = responses(up);
        const VectorXd below = responses(down);
        if (above.size() == 0 || below.size() == 0) {
            return {};
        }
        j.col(static_cast<Eigen::Index>(k)) = errors.in_units(above - below) / (2.0 * std::log1p(step));
    }
    return j;
}

// Orthonormal base of what these columns span: what the fitted parameters can follow.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
    return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

VectorXd beyond(const Eigen::MatrixXd& base, const VectorXd& change) {
    return change - base * (base.transpose() * change);
}

// How far what is hidden remains from what the fitted parameters can follow, at their best: standard deviations.
// Gauss and Newton's steps in the logarithms, differences for derivatives. plain: without what is hidden.
double remaining(const Case& c, const VectorXd& plain, const VectorXd& change, const Errors& errors) {
    Case at = c;
    VectorXd left = change;
    for (int iteration = 0; iteration < 5; ++iteration) {
        const Eigen::MatrixXd j = derivatives(at, errors);
        if (j.size() == 0) {
            break;
        }
        VectorXd step = (j.transpose() * j + 1e-3 * Eigen::MatrixXd::Identity(j.cols(), j.cols()))
                            .ldlt()
                            .solve(j.transpose() * left);
        bool better = false;
        for (int half = 0; half < 5 && !better; ++half, step *= 0.5) {
            Case next = at;
            for (std::size_t k = 0; k < std::size(fitted); ++k) {
                const Parameter p = find_parameter(c, fitted[k].path, {});
                const double value = p.get(next) * std::exp(std::clamp(step[static_cast<Eigen::Index>(k)], -1.0, 1.0));
                p.in(next) = std::clamp(value, fitted[k].low, fitted[k].high) * p.to_si;
            }
            const VectorXd there = responses(next);
            if (there.size() == plain.size()) {
                const VectorXd now = change - errors.in_units(there - plain);
                if (now.norm() < left.norm()) {
                    better = true;
                    at = next;
                    left = now;
                }
            }
        }
        if (!better) {
            break;
        }
    }
    return left.norm();
}

// The best possible rate of telling what is hidden, of strength d, from every other effect, and the one that is
// hardest.
void add_ceiling(Json& truth, const Case& c, const Hidden& hidden, const VectorXd& change, double d,
                 const Eigen::MatrixXd& base, const Errors& errors) {
    double lowest = 1.0;
    std::string hardest;
    const auto compare = [&](const std::string& name, const VectorXd& other, bool both_signs) {
        if (other.norm() < 1e-6 * d) {
            return;
        }
        double cosine = change.dot(other) / (change.norm() * other.norm());
        cosine = both_signs ? std::abs(cosine) : cosine;
        const double rate = gsl_cdf_ugaussian_P(d * std::sqrt(std::max(0.0, (1.0 - cosine) / 2.0)));
        if (rate < lowest) {
            lowest = rate;
            hardest = name;
        }
    };
    const VectorXd plain = responses(c);
    for (const Effect* effect : effects()) {
        if (effect == hidden.effect) {
            continue;
        }
        std::vector<AppliedEffect> ways{{}};
        if (effect == find_effect("outlier")) {
            for (Eigen::Index i = 0; i < errors.size(); ++i) {
                compare(std::string(effect->name),
                        beyond(base, errors.in_units(errors.root(i, i) * VectorXd::Unit(errors.size(), i))), true);
            }
            continue;
        }
        if (effect->takes_reading && !effect->takes_quantity) {
            for (int reading = 0; reading < static_cast<int>(c.sensors.size()); ++reading) {
                ways.push_back({.reading = reading});
            }
        } else if (effect->takes_quantity) { // of one instrument: only where it is read over time
            std::set<std::pair<int, Quantity>> groups;
            for (const Sensor& s : c.sensors) {
                groups.emplace(s.load, s.quantity);
            }
            for (const auto& [load, quantity] : groups) {
                ways.push_back({.load = load, .quantity = quantity});
                ways.push_back({.quantity = quantity});
            }
        } else if (effect->takes_load) {
            for (int load = 0; load < static_cast<int>(c.loads.size()); ++load) {
                ways.push_back({.load = load});
            }
        }
        for (AppliedEffect way : ways) {
            way.effect = effect;
            if (!why_impossible(c, way).empty()) {
                continue;
            }
            Case with = c;
            with.effects = {way};
            with.effects[0].size = effect->log_scale ? std::exp(0.3 * std::log(effect->typical))
                                                     : effect->null + 0.5 * (effect->typical - effect->null);
            const VectorXd there = responses(with);
            if (there.size() == plain.size()) {
                compare(std::string(effect->name), beyond(base, errors.in_units(there - plain)),
                        effect->null > effect->low && effect->null < effect->high);
            }
        }
    }
    truth["ceiling"] = lowest;
    truth["hardest"] = hardest;
}

// What the study asks for: the strain at the top of the subgrade under the wheel.
Sensor output_sensor(const Case& c) {
    Sensor sensor;
    sensor.load = 1;
    sensor.quantity = Quantity::strain_zz;
    sensor.depth = c.layers[0].thickness + c.layers[1].thickness + unit::mm;
    sensor.measured = false;
    return sensor;
}

// noise: the text of [data.noise].
std::string study_text(const Case& c, Draw& draw, bool is_log, const std::string& noise) {
    std::string text = "schema = 1\ntitle = \"A section\"\n";
    for (std::size_t l = 0; l < c.layers.size(); ++l) {
        const Layer& layer = c.layers[l];
        text += fmt::format("\n[[layers]]\nname = \"{}\"\nthickness_mm = {:g}\ndensity_kg_m3 = {:g}\nk0 = {:g}\n",
                            layer.name, layer.thickness / unit::mm, layer.density, layer.k0);
        if (layer.law->stress_dependent()) {
            const double k3 = layer.parameters[*layer.law->index_of("k3")];
            text +=
                fmt::format("law = \"uzan\"\nk1 = {:.0f}\nk2 = 0.5\nk3 = {}\nn = 0.5\npoisson_12 = 0.35\npoisson_31 = "
                            "0.35\n",
                            draw.log_uniform(800.0, 3500.0), k3);
        } else {
            text += fmt::format("law = \"linear\"\nmodulus_MPa = {}\npoisson = {:g}\n", l == 0 ? 3000 : 50,
                                layer.parameters[1]);
        }
    }
    for (const Load& load : c.loads) {
        text += fmt::format("\n[[loads]]\nname = \"{}\"\n", load.name);
        text += load.type == LoadType::plate
                    ? fmt::format("type = \"plate\"\nradius_mm = 150\npressure_kPa = {:g}\n", load.pressure / unit::kPa)
                    : fmt::format("type = \"wheel\"\npatch = \"circle\"\nforce_kN = {:g}\npressure_kPa = {:g}\n",
                                  load.force / unit::kN, load.pressure / unit::kPa);
    }
    text += fmt::format("\n[mesh]\nrefine = {}\n\n[data]\nfiles = [\"data.csv\"]\nmisfit = \"{}\"\n",
                        study_refine(!noise.empty()), is_log ? "log" : "weighted") +
            noise;
    for (const Fitted& f : fitted) {
        text += fmt::format("\n[[parameters]]\nname = \"{}\"\nmin = {:g}\nmax = {:g}\nscale = \"{}\"\n", f.path, f.low,
                            f.high, f.is_log ? "log" : "linear");
    }
    return text + fmt::format("\n[[outputs]]\nname = \"subgrade-top-strain\"\nload = \"wheel\"\nquantity = "
                              "\"strain_zz\"\ndepth_mm = {:g}\n",
                              output_sensor(c).depth / unit::mm);
}

// Of the sensors from this one on.
std::string data_text(const Case& c, const VectorXd& values, const VectorXd& sigma, std::size_t first = 0) {
    std::string text = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n";
    for (std::size_t i = first; i < c.sensors.size(); ++i) {
        const Sensor& s = c.sensors[i];
        const auto& about = info(s.quantity);
        const auto at = static_cast<Eigen::Index>(i);
        text += fmt::format("{},{},{:g},0,{:g},{:g},{},{},{}\n", c.loads[static_cast<std::size_t>(s.load)].name,
                            about.name, s.x / unit::mm, s.depth / unit::mm, s.gauge / unit::mm,
                            values[at] / about.to_si, about.unit, sigma[at] / about.to_si);
    }
    return text;
}

// Writes further.csv; false: the section has no answer under the heavier drop.
bool write_further_readings(const Case& c, const std::vector<Hidden>& hidden, Draw& draw,
                            const std::filesystem::path& folder) {
    const Case more = with_further_readings(c);
    const VectorXd exact = responses_with(finer(more), hidden);
    if (exact.size() == 0) {
        return false;
    }
    VectorXd values = exact;
    VectorXd sigma = exact;
    for (Eigen::Index i = 0; i < exact.size(); ++i) {
        sigma[i] = common_noise(more.sensors[static_cast<std::size_t>(i)].quantity, exact[i]);
        values[i] += sigma[i] * draw.normal();
    }
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "further.csv") << data_text(more, values, sigma, c.sensors.size());
    return true;
}

struct Strength {
    double least = 8.0, most = 20.0; // standard deviations
};

// A size whose change, beyond what the parameters and `others` can follow, has the strength wanted; nothing: there is
// none within the effect's range.
std::optional<Hidden> sized(Draw& draw, const Case& c, Hidden hidden, const VectorXd& plain,
                            const Eigen::MatrixXd& base, const Errors& errors, double wanted) {
    Effect own{};
    own.high = hidden.outside != nullptr ? hidden.outside->most : 0.0;
    const Effect& effect = hidden.outside != nullptr ? own : *hidden.effect;
    const bool up_only = effect.null <= effect.low;
    const bool down_only = effect.null >= effect.high;
    const double side = up_only ? 1.0 : down_only ? -1.0 : draw.chance(0.5) ? 1.0 : -1.0;
    const auto size_at = [&](double share) { // 0 null, 1 the end of the range
        const double end = side > 0.0 ? effect.high : effect.low;
        return effect.log_scale ? std::exp(std::log(effect.null) + share * (std::log(end) - std::log(effect.null)))
                                : effect.null + share * (end - effect.null);
    };
    const auto strength = [&](double share) {
        hidden.size = size_at(share);
        const VectorXd there = responses_with(c, {hidden});
        return there.size() == plain.size() ? beyond(base, errors.in_units(there - plain)).norm() : -1.0;
    };
    double low = 0.0;
    for (const double high : {0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9}) {
        const double found = strength(high);
        if (found < 0.0) {
            return std::nullopt;
        }
        if (found >= wanted) {
            double a = low;
            double b = high;
            for (int i = 0; i < 6; ++i) {
                const double middle = 0.5 * (a + b);
                (strength(middle) >= wanted ? b : a) = middle;
            }
            hidden.size = size_at(b);
            return hidden;
        }
        low = high;
    }
    return std::nullopt;
}

// Without those that only a history tells: the cases here are of peaks.
std::vector<const Effect*> drawn_effects() {
    std::vector<const Effect*> drawn;
    std::ranges::copy_if(effects(), std::back_inserter(drawn), [](const Effect* e) {
        return e->name != "damping" && e->name != "asphalt-relaxation" && e->name != "density";
    });
    return drawn;
}

Hidden draw_hidden(Draw& draw, const Case& c, const std::string& kind) {
    Hidden hidden;
    if (kind == "outside") {
        hidden.outside = &outsides[draw.below(std::size(outsides))];
        hidden.place = draw.uniform(hidden.outside->layer == "subgrade" ? 0.15 : 0.2, 0.4);
        hidden.width = draw.uniform(0.08, 0.15);
        return hidden;
    }
    hidden.effect = find_effect(kind);
    if (hidden.effect == nullptr) {
        const auto all = drawn_effects();
        hidden.effect = all[draw.below(all.size())];
    }
    const Effect& effect = *hidden.effect;
    const int load = static_cast<int>(draw.below(c.loads.size()));
    if (effect.takes_reading && !effect.takes_quantity) {
        hidden.options.reading = static_cast<int>(draw.below(c.sensors.size()));
    } else if (effect.takes_quantity) {
        const Sensor& sensor = c.sensors[draw.below(c.sensors.size())];
        hidden.options.quantity = sensor.quantity;
        if (draw.chance(0.7)) {
            hidden.options.load = sensor.load;
        }
    } else if (effect.takes_load && draw.chance(0.5)) {
        hidden.options.load = load;
    }
    for (const auto& [name, form] : forms) {
        if (name == effect.name && !hidden.options.load && draw.chance(0.5)) {
            hidden.form = form;
        }
    }
    return hidden;
}

Json words(const Case& c, const Hidden& hidden) {
    Json json = {{"effect", hidden.name()}, {"size", hidden.size}, {"form", hidden.form}};
    if (hidden.outside != nullptr) {
        json["channel"] = std::string(hidden.outside->channel);
        json["layer"] = std::string(hidden.outside->layer);
        json["profile"] = profile(c, hidden);
    }
    if (hidden.options.load) {
        json["load"] = c.loads[static_cast<std::size_t>(*hidden.options.load)].name;
    }
    if (hidden.options.quantity) {
        json["quantity"] = std::string(info(*hidden.options.quantity).name);
    }
    if (hidden.options.reading) {
        json["reading"] = *hidden.options.reading + 1;
    }
    return json;
}

constexpr const char* kinds_of_data[] = {"few", "middle", "understated", "overstated", "heavy",
                                         "bad", "common", "tied",        "fault",      "layout"};

// The numbers of the errors, in standard deviations, as the study does not state them.
void unlike_stated(const Case& c, Draw& draw, const std::string& data, VectorXd& numbers) {
    if (data == "understated") {
        numbers *= 1.5;
    } else if (data == "overstated") {
        numbers /= 1.5;
    } else if (data == "heavy") {
        constexpr double degrees = 4.0;
        for (double& number : numbers) {
            number = gsl_cdf_tdist_Pinv(gsl_cdf_ugaussian_P(number), degrees) / std::sqrt(degrees / (degrees - 2.0));
        }
    } else if (data == "tied") {
        constexpr double length = 0.3; // m
        Eigen::MatrixXd tied = Eigen::MatrixXd::Identity(numbers.size(), numbers.size());
        for (Eigen::Index i = 0; i < numbers.size(); ++i) {
            for (Eigen::Index k = 0; k < numbers.size(); ++k) {
                const Sensor& a = c.sensors[static_cast<std::size_t>(i)];
                const Sensor& b = c.sensors[static_cast<std::size_t>(k)];
                if (i != k) {
                    const double apart = std::hypot(a.x - b.x, a.y - b.y, a.depth - b.depth);
                    tied(i, k) = a.load == b.load && a.quantity == b.quantity ? std::exp(-apart / length) : 0.0;
                }
            }
        }
        const Eigen::MatrixXd root = tied.llt().matrixL();
        numbers = root * numbers;
    } else if (data == "bad") {
        const std::size_t count = 2 + draw.below(2);
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = static_cast<Eigen::Index>(draw.below(static_cast<std::size_t>(numbers.size())));
            numbers[at] = std::copysign(draw.uniform(7.0, 15.0), draw.uniform(-1.0, 1.0));
        }
    }
}

// What happens to the file: values and their stated deviations move or change their unit. What, in words.
Json spoil(const Case& c, Draw& draw, VectorXd& values, VectorXd& spread) {
    std::vector<double> places;
    for (const Sensor& sensor : c.sensors) {
        if (sensor.quantity == Quantity::deflection) {
            places.push_back(sensor.x);
        }
    }
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    const auto at = [&](int load, double x) {
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            const Sensor& sensor = c.sensors[i];
            if (sensor.load == load && sensor.quantity == Quantity::deflection && sensor.x == x) {
                return static_cast<Eigen::Index>(i);
            }
        }
        return Eigen::Index(-1);
    };
    const auto exchange = [&](double one, double other) {
        for (int load = 0; load < static_cast<int>(c.loads.size()); ++load) {
            const Eigen::Index a = at(load, one);
            const Eigen::Index b = at(load, other);
            if (a >= 0 && b >= 0) {
                std::swap(values[a], values[b]);
                std::swap(spread[a], spread[b]);
            }
        }
    };
    switch (draw.below(3)) {
    case 0: {
        const std::size_t i = draw.below(places.size() - 2);
        exchange(places[i], places[i + 1]);
        return {{"fault", "exchanged"}, {"at_mm", {1e3 * places[i], 1e3 * places[i + 1]}}};
    }
    case 1: // the line of each load's own sensors
        for (int load = 0; load < static_cast<int>(c.loads.size()); ++load) {
            std::vector<Eigen::Index> line;
            for (const double place : places) {
                if (const Eigen::Index i = at(load, place); i >= 0) {
                    line.push_back(i);
                }
            }
            for (std::size_t i = 0; i < line.size() / 2; ++i) {
                std::swap(values[line[i]], values[line[line.size() - 1 - i]]);
                std::swap(spread[line[i]], spread[line[line.size() - 1 - i]]);
            }
        }
        return {{"fault", "counted from the far end"}};
    default: {
        constexpr double factors[] = {10.0, 25.4, 1000.0, 1.0 / 25.4};
        const double factor = factors[draw.below(std::size(factors))];
        const double place = places[1 + draw.below(places.size() - 3)];
        for (int load = 0; load < static_cast<int>(c.loads.size()); ++load) {
            if (const Eigen::Index i = at(load, place); i >= 0) {
                values[i] *= factor;
                spread[i] *= factor;
            }
        }
        return {{"fault", "another unit"}, {"at_mm", {1e3 * place}}, {"factor", factor}};
    }
    }
}

int generate(std::uint64_t seed, const std::filesystem::path& folder, const std::string& kind, const Strength& strength,
             bool correlated, const std::string& data) {
    const bool few = data == "few";
    for (std::uint64_t attempt = 0;; ++attempt) {
        Draw draw(seed, 1000 + attempt);
        Case c = draw_case(draw);
        if (few) {
            keep_few(c);
        } else if (data == "middle") {
            keep_middle(c, draw);
        }
        Json truth = {{"seed", seed}};
        const Case stated = data == "layout" ? lay_out(c, draw, truth) : c;
        const Case fine = finer(c);
        Case coarse = c;
        coarse.settings.refine = study_refine(correlated);
        const VectorXd plain = responses(fine);
        const VectorXd plain_coarse = responses(coarse);
        if (plain.size() == 0 || plain_coarse.size() == 0) {
            continue;
        }
        const double noise = draw.uniform(0.01, 0.05);
        const auto sigma_of = [&](const VectorXd& values) {
            VectorXd sigma(values.size());
            for (Eigen::Index i = 0; i < values.size(); ++i) {
                double largest = 0.0;
                for (Eigen::Index k = 0; k < values.size(); ++k) {
                    const Sensor& a = c.sensors[static_cast<std::size_t>(i)];
                    const Sensor& b = c.sensors[static_cast<std::size_t>(k)];
                    if (a.load == b.load && a.quantity == b.quantity) {
                        largest = std::max(largest, std::abs(values[k]));
                    }
                }
                sigma[i] = std::hypot(noise * values[i], 0.3 * noise * largest);
            }
            return sigma;
        };
        const auto common_of = [&](const VectorXd& values) -> VectorXd {
            return (correlated ? in_common * noise : 0.0) * values;
        };
        const Errors errors = errors_of(c, sigma_of(plain), common_of(plain));
        const Eigen::MatrixXd slopes = derivatives(coarse, errors);
        if (slopes.size() == 0) {
            continue;
        }
        const Eigen::MatrixXd base = orthonormal(slopes);
        std::vector<Hidden> hidden;
        std::vector<double> strengths;
        const std::size_t count = kind == "none" ? 0 : kind == "two" ? 2 : 1;
        for (int tried = 0; hidden.size() < count && tried < 12; ++tried) {
            Hidden drawn = draw_hidden(draw, c, kind);
            AppliedEffect applied = drawn.options;
            applied.effect = drawn.effect;
            const bool is_new =
                std::none_of(hidden.begin(), hidden.end(), [&](const Hidden& h) { return h.effect == drawn.effect; });
            if (!is_new || (drawn.effect != nullptr && !why_impossible(c, applied).empty())) {
                continue;
            }
            const double wanted = draw.uniform(strength.least, strength.most);
            if (auto found = sized(draw, coarse, drawn, plain_coarse, base, errors, wanted)) {
                hidden.push_back(*found);
                strengths.push_back(wanted);
            }
        }
        if (hidden.size() < count) {
            continue;
        }
        const VectorXd exact = count == 0 ? plain : responses_with(fine, hidden);
        if (exact.size() == 0) {
            continue;
        }
        truth["noise"] = noise;
        truth["readings"] = c.sensors.size();
        truth["hidden"] = Json::array();
        std::vector<VectorXd> changes;
        double weakest = std::numeric_limits<double>::infinity();
        for (const Hidden& h : hidden) {
            const VectorXd change = errors.in_units(responses_with(fine, {h}) - plain);
            changes.push_back(beyond(base, change));
            const double left = remaining(coarse, plain_coarse, change, errors);
            weakest = std::min(weakest, left);
            Json one = words(c, h);
            one["strength"] = left;
            truth["hidden"].push_back(one);
        }
        if (weakest < strength.least) {
            continue;
        }
        if (count == 2) { // each beyond what the other can mimic
            const double cosine = changes[0].dot(changes[1]) / (changes[0].norm() * changes[1].norm());
            const double left = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
            if (std::min(changes[0].norm(), changes[1].norm()) * left < strength.least) {
                continue;
            }
        }
        if (count == 1) {
            add_ceiling(truth, coarse, hidden[0], changes[0], weakest, base, errors);
        }
        VectorXd spread = sigma_of(exact);
        VectorXd numbers(exact.size());
        for (double& number : numbers) {
            number = draw.normal();
        }
        const VectorXd as_drawn = numbers;
        unlike_stated(c, draw, data, numbers);
        VectorXd values = exact + errors_of(c, spread, common_of(exact)).root * numbers;
        if (data == "bad") {
            truth["bad"] = Json::array();
            for (Eigen::Index i = 0; i < numbers.size(); ++i) {
                if (numbers[i] != as_drawn[i]) {
                    truth["bad"].push_back(i + 1);
                }
            }
        }
        if (data == "common") {
            const double common = draw.uniform(0.01, 0.03);
            for (std::size_t load = 0; load < c.loads.size(); ++load) {
                const double error = common * draw.normal();
                for (Eigen::Index i = 0; i < values.size(); ++i) {
                    const bool is_of_load =
                        static_cast<std::size_t>(c.sensors[static_cast<std::size_t>(i)].load) == load;
                    values[i] += is_of_load ? error * exact[i] : 0.0;
                }
            }
        }
        if (data == "fault") {
            truth["spoilt"] = spoil(c, draw, values, spread);
        }
        if (few && !write_further_readings(c, hidden, draw, folder)) {
            continue;
        }
        std::filesystem::create_directories(folder);
        const bool is_log = draw.chance(0.3) && !correlated; // correlations need residuals in units of the noise
        const std::string said = fmt::format("\n[data.noise]\ncommon_relative = {}\ncorrelation_mm = {}\n",
                                             in_common * noise, correlated_mm);
        const std::string text = study_text(c, draw, is_log, correlated ? said : "");
        std::ofstream(folder / "study.toml") << text;
        std::ofstream(folder / "data.csv") << data_text(stated, values, spread);
        if (correlated) {
            std::string independent = text;
            independent.erase(independent.find(said), said.size());
            const std::string file = "data.csv";
            independent.replace(independent.find(file), file.size(), "independent.csv");
            std::ofstream(folder / "independent.toml") << independent;
            const VectorXd whole = (spread.cwiseAbs2() + common_of(exact).cwiseAbs2()).cwiseSqrt();
            std::ofstream(folder / "independent.csv") << data_text(c, values, whole);
        }
        Json parameters = Json::object();
        for (const Fitted& f : fitted) {
            parameters[f.path] = find_parameter(c, f.path, {}).get(c);
        }
        truth["parameters"] = parameters;
        // What the output is on the road: errors of readings and of where a load stands do not change it; that of a
        // load's size does, for it is asked under that load.
        std::vector<Hidden> of_road;
        for (const Hidden& h : hidden) {
            const std::string name = h.name();
            const auto is = [&](const char* part) { return name.find(part) != std::string::npos; };
            const bool of_readings = h.outside != nullptr && h.outside->layer.empty();
            if (!of_readings && !is("gauge") && !is("sensor") && !is("load-offset") && !is("outlier") && !is("drift") &&
                !is("wander") && !is("inertia")) {
                of_road.push_back(h);
            }
        }
        Case asked = fine;
        asked.sensors = {output_sensor(c)};
        const VectorXd there = of_road.empty() ? responses(asked) : responses_with(asked, of_road);
        truth["output"] = there.size() > 0 ? Json(1e6 * there[0]) : Json(nullptr);
        std::cout << truth.dump() << "\n";
        return 0;
    }
}

} // namespace

int main(int argc, char** argv) {
    std::vector<std::string> words(argv + 1, argv + argc);
    const bool correlated = !words.empty() && words.back() == "correlated";
    const bool is_data = !words.empty() && std::find(std::begin(kinds_of_data), std::end(kinds_of_data),
                                                     words.back()) != std::end(kinds_of_data);
    const std::string data = is_data ? words.back() : "";
    if (correlated || is_data) {
        words.pop_back();
    }
    if (words.size() != 3 && words.size() != 5) {
        std::cerr << "usage: blind_generator SEED FOLDER KIND [LEAST MOST] [correlated | few | middle | DATA]\n";
        return 2;
    }
    Strength strength;
    if (words.size() == 5) {
        strength = {std::stod(words[3]), std::stod(words[4])};
    }
    return generate(std::stoull(words[0]), words[1], words[2], strength, correlated, data);
}
