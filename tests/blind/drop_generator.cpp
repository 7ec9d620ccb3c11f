// Stations with repeated drops, for trials of what is said of them: linear layers on a half-space, computed by a
// transform solution that shares nothing with the engines that are tried, with noise of every drop.
//
// usage: drop_generator STATIONS DROPS SEED FOLDER
//
// Writes drops.csv and study.toml, which states the noise of one drop and seeks three moduli. Every
// sensor errs by 2 % and 1 um, correlated over 600 mm, all sensors of a drop by another 1.2 % in common; drops differ
// in load. DROPS 0: one drop without errors at 700 kPa, and no noise stated. What is true, the output under a pressure
// of 1 kPa, goes to standard output as JSON.
#include "reference/multilayer_elastic.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iostream>
#include <random>
#include <string>

namespace {

using pave::reference::ElasticLayer;
using pave::reference::Floor;
using pave::reference::multilayer_elastic;

constexpr double radius = 0.15; // m
constexpr double relative = 0.02;
constexpr double absolute_um = 1.0;
constexpr double common_relative = 0.012;
constexpr double correlation_mm = 600.0;
constexpr double output_depth = 0.47; // m
constexpr std::array offsets_mm{0.0, 200.0, 300.0, 450.0, 600.0, 900.0, 1200.0, 1500.0, 1800.0};

class Draws {
public:
    explicit Draws(unsigned seed) : engine_(seed) {}
    double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
    double log_between(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
    double normal() { return std::normal_distribution<double>()(engine_); }

private:
    std::mt19937_64 engine_;
};

// The deflections of one drop in um. exact_um: under 1 kPa.
std::array<double, offsets_mm.size()> drop_of(const std::array<double, offsets_mm.size()>& exact_um,
                                              double pressure_kPa, Draws& draw) {
    const double common = common_relative * draw.normal();
    double chain = 0.0; // Gauss and Markov: correlated by exp(-distance / length)
    std::array<double, offsets_mm.size()> read{};
    for (std::size_t i = 0; i < offsets_mm.size(); ++i) {
        const double rho = i == 0 ? 0.0 : std::exp(-(offsets_mm[i] - offsets_mm[i - 1]) / correlation_mm);
        chain = rho * chain + std::sqrt(1.0 - rho * rho) * draw.normal();
        const double um = pressure_kPa * exact_um[i];
        read[i] = um * (1.0 + common) + std::hypot(relative * um, absolute_um) * chain;
    }
    return read;
}

std::string study_text(int drops) {
    std::string text = "schema = 1\ntitle = \"Stations with repeated drops\"\n\n[section]\nbottom = \"half-space\"\n\n";
    struct Layer {
        const char* name;
        const char* thickness;
        double modulus, low, high;
    };
    for (const Layer& l : {Layer{"asphalt", "thickness_mm = 150\n", 3000, 200, 50000},
                           Layer{"base", "thickness_mm = 300\n", 300, 20, 4000}, Layer{"subgrade", "", 60, 10, 500}}) {
        text += fmt::format(
            "[[layers]]\nname = \"{0}\"\n{1}density_kg_m3 = 2000\nk0 = 0.5\nlaw = \"linear\"\nmodulus_MPa = {2}\n"
            "poisson = 0.35\n\n[[parameters]]\nname = \"{0}.modulus_MPa\"\nmin = {3}\nmax = {4}\nscale = "
            "\"log\"\n\n",
            l.name, l.thickness, l.modulus, l.low, l.high);
    }
    text += fmt::format(
        "[[loads]]\nname = \"fwd\"\ntype = \"plate\"\nradius_mm = {:g}\npressure_kPa = 700\n\n[data]\nmisfit = "
        "\"weighted\"\n\n",
        1e3 * radius);
    if (drops > 0) {
        text +=
            fmt::format("[data.noise]\nrelative = {}\nabsolute = {{ um = {} }}\ncommon_relative = {}\ncorrelation_mm = "
                        "{}\nof_drops = 1\n\n",
                        relative, absolute_um, common_relative, correlation_mm);
    }
    return text +
           fmt::format("[[outputs]]\nname = \"strain\"\nload = \"fwd\"\nquantity = \"strain_zz\"\ndepth_mm = {:g}\n",
                       1e3 * output_depth);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 5) {
        std::cerr << "usage: drop_generator STATIONS DROPS SEED FOLDER\n";
        return 2;
    }
    const int stations = std::atoi(argv[1]);
    const int drops = std::atoi(argv[2]);
    const std::filesystem::path folder = argv[4];
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "study.toml") << study_text(drops);
    std::ofstream csv(folder / "drops.csv");
    csv << "station,chainage_m,drop,radius_mm,pressure_kPa";
    for (const double offset : offsets_mm) {
        csv << fmt::format(",D{:g}_um", offset);
    }
    csv << "\n";
    Draws draw(static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10)));
    std::string truth;
    for (int s = 0; s < stations; ++s) {
        const std::array layers{ElasticLayer{0.15, 1e6 * draw.log_between(1500.0, 8000.0), 0.35},
                                ElasticLayer{0.3, 1e6 * draw.log_between(120.0, 600.0), 0.35},
                                ElasticLayer{0.0, 1e6 * draw.log_between(35.0, 120.0), 0.35}};
        std::array<double, offsets_mm.size()> exact_um{};
        for (std::size_t i = 0; i < offsets_mm.size(); ++i) {
            exact_um[i] =
                1e6 * multilayer_elastic(layers, Floor::half_space, radius, 1e3, 1e-3 * offsets_mm[i], 0.0).u_z;
        }
        const double strain =
            -1e6 * multilayer_elastic(layers, Floor::half_space, radius, 1e3, 0.0, output_depth).eps_zz;
        truth += fmt::format("{}{{\"asphalt.modulus_MPa\": {}, \"base.modulus_MPa\": {}, \"subgrade.modulus_MPa\": {}, "
                             "\"strain_per_kPa\": {}}}",
                             s == 0 ? "" : ",\n ", layers[0].modulus / 1e6, layers[1].modulus / 1e6,
                             layers[2].modulus / 1e6, strain);
        if (drops == 0) {
            csv << fmt::format("S{0},{1},1,{2:g},700", s, 10 * s, 1e3 * radius);
            for (const double um : exact_um) {
                csv << fmt::format(",{:.4f}", 700.0 * um);
            }
            csv << "\n";
        }
        for (int d = 0; d < drops; ++d) {
            const double pressure_kPa = 700.0 * draw.between(0.97, 1.03);
            csv << fmt::format("S{0},{1},{2},{3:g},{4:.3f}", s, 10 * s, d + 1, 1e3 * radius, pressure_kPa);
            for (const double um : drop_of(exact_um, pressure_kPa, draw)) {
                csv << fmt::format(",{:.4f}", um);
            }
            csv << "\n";
        }
    }
    std::cout << "[" << truth << "]\n";
    return 0;
}
