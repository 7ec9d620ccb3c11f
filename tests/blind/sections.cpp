#include "blind/sections.h"

#include "base/units.h"
#include "material/catalog.h"
#include "pavement/forward.h"

#include <array>
#include <set>

namespace blind {

namespace {

double rounded(double value, double step) {
    return step * std::round(value / step);
}

// Layouts of seven sensors [mm]: two of which one stands in a file where the other was driven.
constexpr std::array<std::array<double, 7>, 2> mistaken_layouts[] = {
    {{{0, 200, 300, 600, 900, 1200, 1500}, {0, 210, 315, 475, 630, 925, 1535}}},
    {{{0, 200, 300, 450, 600, 900, 1200}, {0, 200, 300, 600, 900, 1200, 1500}}},
    {{{0, 300, 450, 600, 900, 1200, 1500}, {0, 300, 600, 900, 1200, 1500, 1800}}},
};

constexpr double fine_refine = 1.5;

} // namespace

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

void keep_few(Case& c) {
    std::size_t strains = 0;
    std::erase_if(c.sensors, [&](const Sensor& s) {
        constexpr std::size_t most = 3;
        const bool is_strain = s.load == 1 && s.quantity == Quantity::strain_zz && s.x == 0.0;
        return !(s.load == 0 && s.quantity == Quantity::deflection) && !(is_strain && ++strains <= most);
    });
}

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

Case lay_out(Case& c, Draw& draw, Json& truth) {
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

double common_noise(Quantity quantity, double value) {
    switch (quantity) {
    case Quantity::deflection: return std::hypot(0.02 * value, 2e-6);
    case Quantity::stress_zz: return std::hypot(0.10 * value, 2.0 * unit::kPa);
    default: return std::hypot(0.05 * value, 10e-6);
    }
}

double study_refine(bool correlated) {
    return correlated ? 0.9 : 0.6;
}

Case finer(Case c) {
    c.settings.refine = fine_refine;
    c.settings.solver.load_steps *= 3;
    return c;
}

VectorXd responses(const Case& c) {
    const ForwardModel model(c);
    const auto outcome = model.run(c, {}, *model.make_workspace());
    if (!outcome) {
        return {};
    }
    return VectorXd::Map(outcome->values.data(), static_cast<Eigen::Index>(outcome->values.size()));
}

} // namespace blind
