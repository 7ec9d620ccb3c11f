// Twins of whole pulses, for blind trials: a linear section on a rock in motion, computed by Fourier and Hankel
// transforms (tests/reference/layered_pulse.h), which share nothing with the solver that is tried, with noise.
//
// usage: pulse_generator SEED FOLDER [EFFECT]
//
// Writes study.toml with the histories of seven sensors and peaks.toml with their largest deflections alone. Without an
// effect three moduli and the depth of the rock are sought. With one (floor-depth, damping, asphalt-relaxation,
// density) the section has it, or one of the geophones (sensor-gain), and the studies seek three moduli and do not know
// of it. What is true goes to standard output.
#include "reference/layered_pulse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iostream>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace {

using pave::reference::MovingLayer;

constexpr double duration = 0.025; // s
constexpr double radius = 0.15;    // m
constexpr double pressure = 700e3; // Pa
constexpr double relative = 0.02;  // of a reading
constexpr double absolute = 1e-6;  // m
constexpr std::array offsets{0.0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.8};
constexpr std::array names{"asphalt", "base", "subgrade"};
constexpr double until = 0.045; // s, the last reading
constexpr double apart = 0.003; // s

class Draws {
public:
    explicit Draws(unsigned seed) : engine_(seed) {}
    double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
    double log_between(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
    double normal() { return std::normal_distribution<double>()(engine_); }
    bool coin() { return between(0.0, 1.0) < 0.5; }

private:
    std::mt19937_64 engine_;
};

// Changes the section or the gain of a sensor; the size as `diagnose` states it.
double hide(const std::string& effect, Draws& draw, std::vector<MovingLayer>& layers, std::vector<double>& gains) {
    if (effect == "floor-depth") {
        constexpr double highest = -0.48; // m, what the effect may be sought at
        const double share = draw.coin() ? draw.between(0.2, 0.6) : -draw.between(0.12, 0.25);
        const double by = std::max(highest, layers[2].thickness * share);
        layers[2].thickness += by;
        return 1e3 * by;
    }
    if (effect == "damping") {
        const double factor = draw.log_between(3.0, 12.0);
        layers[2].damping_time *= factor;
        return factor;
    }
    if (effect == "asphalt-relaxation") {
        layers[0].fading_share = draw.between(0.35, 0.8);
        layers[0].fading_time = 0.01;
        return layers[0].fading_share;
    }
    if (effect == "density") {
        const double factor = draw.coin() ? draw.between(1.15, 1.5) : draw.between(0.65, 0.87);
        layers[2].density *= factor;
        return factor;
    }
    if (effect == "sensor-gain") {
        const double factor = draw.coin() ? draw.between(1.06, 1.25) : draw.between(0.8, 0.94);
        gains[static_cast<std::size_t>(draw.between(0.0, static_cast<double>(gains.size())))] = factor;
        return factor;
    }
    std::cerr << "no such effect: " << effect << "\n";
    std::exit(2);
}

std::string study_of(const std::vector<MovingLayer>& layers, bool seeks_floor, const char* data) {
    std::string text = "schema = 1\ntitle = \"a whole pulse\"\n";
    for (std::size_t l = 0; l < layers.size(); ++l) {
        text += fmt::format("\n[[layers]]\nname = \"{}\"\nthickness_mm = {:.10g}\ndensity_kg_m3 = {}\nk0 = 0.5\nlaw = "
                            "\"linear\"\nmodulus_MPa = {}\npoisson = {}\ndamping_time_ms = {}\n",
                            names[l], 1e3 * layers[l].thickness, layers[l].density, std::array{3000, 300, 80}[l],
                            layers[l].poisson, 1e3 * layers[l].damping_time);
    }
    text += fmt::format("\n[[loads]]\nname = \"drop\"\ntype = \"plate\"\nradius_mm = {}\nhistory = \"force.csv\"\n\n"
                        "[solver]\ntime_step_ms = 0.5\n\n[data]\nfiles = [\"{}\"]\nmisfit = \"weighted\"\n\n"
                        "[data.noise]\nrelative = {}\nabsolute = {{ um = {} }}\n",
                        1e3 * radius, data, relative, 1e6 * absolute);
    const auto parameter = [&](const char* name, double low, double high) {
        text += fmt::format("\n[[parameters]]\nname = \"{}\"\nmin = {}\nmax = {}\nscale = \"log\"\n", name, low, high);
    };
    parameter("asphalt.modulus_MPa", 500, 20000);
    parameter("base.modulus_MPa", 50, 1500);
    parameter("subgrade.modulus_MPa", 15, 400);
    if (seeks_floor) {
        parameter("subgrade.thickness_mm", 700, 8000);
    }
    return text;
}

} // namespace

int main(int count, char** words) {
    if (count < 3) {
        std::cerr << "usage: pulse_generator SEED FOLDER [EFFECT]\n";
        return 2;
    }
    const std::filesystem::path folder = words[2];
    const std::string effect = count > 3 ? words[3] : "";
    Draws draw(static_cast<unsigned>(std::stoul(words[1])) * 7919u + 17u);
    std::vector<MovingLayer> layers{{draw.between(0.1, 0.2), draw.log_between(1.5e9, 8e9), 0.35, 2300.0, 5e-4},
                                    {draw.between(0.2, 0.45), draw.log_between(150e6, 500e6), 0.35, 2000.0, 5e-4},
                                    {draw.between(1.5, 4.0), draw.log_between(40e6, 150e6), 0.4, 1800.0, 5e-4}};
    const std::vector<MovingLayer> stated = layers;
    std::vector<double> gains(offsets.size(), 1.0);
    const double size = effect.empty() ? 0.0 : hide(effect, draw, layers, gains);
    const auto turned = std::ranges::find_if(gains, [](double gain) { return gain != 1.0; });

    std::vector<double> times;
    for (int i = 1; apart * i < until + 1e-9; ++i) {
        times.push_back(apart * i);
    }
    std::vector<double> close; // for the peaks
    for (int i = 0; i < 300; ++i) {
        close.push_back(0.005 + i * (until - 0.005) / 299.0);
    }
    const auto motion = pave::reference::layered_pulse(layers, false, radius, pressure, duration, offsets, times);
    const auto course = pave::reference::layered_pulse(layers, false, radius, pressure, duration, offsets, close);

    std::filesystem::create_directories(folder);
    std::ofstream force(folder / "force.csv");
    force << "time_ms,pressure_kPa\n";
    for (int i = 0; i <= 100; ++i) {
        force << fmt::format("{},{:.10g}\n", 0.25 * i,
                             1e-3 * pressure * std::pow(std::sin(std::numbers::pi * i / 100), 2));
    }
    force << fmt::format("{},0\n", 1e3 * until + 1.0);
    const char* header = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,time_ms,value,unit,sigma\n";
    std::ofstream histories(folder / "histories.csv");
    std::ofstream peaks(folder / "peaks.csv");
    histories << header;
    peaks << header;
    const auto noisy = [&](double value) { return value + std::hypot(relative * value, absolute) * draw.normal(); };
    for (std::size_t i = 0; i < offsets.size(); ++i) {
        for (std::size_t j = 0; j < times.size(); ++j) {
            histories << fmt::format("drop,deflection,{},0,0,0,{:.10g},{:.10g},um,\n", 1e3 * offsets[i], 1e3 * times[j],
                                     1e6 * noisy(gains[i] * motion[i][j]));
        }
        double largest = 0.0;
        for (const double u : course[i]) {
            largest = std::max(largest, u);
        }
        peaks << fmt::format("drop,deflection,{},0,0,0,,{:.10g},um,\n", 1e3 * offsets[i],
                             1e6 * noisy(gains[i] * largest));
    }
    std::ofstream(folder / "study.toml") << study_of(stated, effect.empty(), "histories.csv");
    std::ofstream(folder / "peaks.toml") << study_of(stated, effect.empty(), "peaks.csv");
    std::cout << fmt::format(
        "{{\"effect\": \"{}\", \"size\": {:.10g}, \"at_mm\": {}, \"parameters\": {{\"asphalt.modulus_MPa\": {:.10g}, "
        "\"base.modulus_MPa\": {:.10g}, \"subgrade.modulus_MPa\": {:.10g}, \"subgrade.thickness_mm\": {:.10g}}}}}\n",
        effect, size, turned == gains.end() ? "null" : fmt::format("{}", 1e3 * offsets[turned - gains.begin()]),
        1e-6 * layers[0].modulus, 1e-6 * layers[1].modulus, 1e-6 * layers[2].modulus, 1e3 * layers[2].thickness);
}
