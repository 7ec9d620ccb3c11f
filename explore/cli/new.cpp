// pavescape new: a commented study to start from, with readings to replace.
#include "cli/commands.h"
#include "run/files.h"

#include <filesystem>
#include <fmt/format.h>

namespace explore::cli {
namespace {

constexpr std::string_view study_template =
    R"(# A study: one section, what was measured on it, what is to be found. Written by `pavescape new`; runs as it stands:
#     pavescape check {0}.toml
#     pavescape fit {0}.toml
# Replace the numbers by yours. Keys carry their unit. `pavescape effects` lists what can be added to the model.
schema = 1
title = "{0}"

# What the last layer stands on. "half-space": it goes on for ever. "rigid": on rock at the bottom of its thickness_mm,
# which may be a parameter: a floor where there is none makes the subgrade look too soft.
[section]
bottom = "half-space"

# Layers from the top down.
[[layers]]
name = "asphalt"
thickness_mm = 50
density_kg_m3 = 2300          # with k0: the stress that is there before the load
k0 = 0.5                      # horizontal over vertical stress at rest
law = "linear"
modulus_MPa = 3000
poisson = 0.35

[[layers]]
name = "base"
thickness_mm = 250
density_kg_m3 = 2200
k0 = 0.5
law = "uzan"                  # E = k1 pa (theta/pa)^k2 (tau/pa + 1)^k3, pa = 100 kPa
modulus_axis = "vertical"     # E is that of the laboratory test; "horizontal": E1
k1 = 1500                     # 900 to 1700 for crushed rock
k2 = 0.65                     # 0.5 to 0.8: stiffens with confinement
k3 = -0.3                     # -0.8 to 0: softens with shear
n = 0.4                       # horizontal over vertical modulus
poisson_12 = 0.35
poisson_31 = 0.35

[[layers]]
name = "subgrade"
density_kg_m3 = 1900
k0 = 0.5
law = "linear"
modulus_MPa = 60
poisson = 0.40

# What loads it: "plate" (FWD), "wheel" or "dual-wheel".
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 566            # 40 kN

# What was read. Without a sigma in the file the noise is taken from what the fit leaves over.
[data]
files = ["{0}.csv"]
misfit = "weighted"           # by the noise; "log": by the logarithms, for strains of all sizes
noise_relative = 0.02
noise_floor = 0.005           # of the largest reading under that load

# What is to be found, and between which bounds.
[[parameters]]
name = "asphalt.modulus_MPa"
min = 500
max = 15000
scale = "log"

[[parameters]]
name = "base.k1"
min = 300
max = 5000
scale = "log"

[[parameters]]
name = "subgrade.modulus_MPa"
min = 15
max = 300
scale = "log"

# What the answer is for: predicted from every set of parameters that the readings allow.
[[outputs]]
name = "subgrade-top strain"
load = "fwd"
quantity = "strain_zz"
depth_mm = 301
)";

// An FWD bowl that such a section could give: to be replaced.
constexpr std::string_view data_template =
    "# An example bowl, not a measurement: replace it. quantity: deflection, strain_zz, strain_xx, stress_zz, ...\n"
    "# Deflections are positive down, strains and stresses in compression. sigma may be empty.\n"
    "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n"
    "fwd,deflection,0,0,0,0,0.640,mm,\n"
    "fwd,deflection,200,0,0,0,0.470,mm,\n"
    "fwd,deflection,300,0,0,0,0.372,mm,\n"
    "fwd,deflection,450,0,0,0,0.264,mm,\n"
    "fwd,deflection,600,0,0,0,0.197,mm,\n"
    "fwd,deflection,900,0,0,0,0.122,mm,\n"
    "fwd,deflection,1200,0,0,0,0.085,mm,\n"
    "fwd,deflection,1500,0,0,0,0.063,mm,\n";

int write_study(const std::string& file) {
    const std::filesystem::path path(file);
    if (path.extension() != ".toml") {
        throw pave::Error({.file = file}, "not a name of a study", "\"" + path.extension().string() + "\"",
                          "NAME.toml");
    }
    const std::string stem = path.stem().string();
    constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
    if (stem.find_first_not_of(plain) != std::string::npos) { // it stands in the study
        throw pave::Error({.file = file}, "not a name of a study", "\"" + stem + "\"", "letters, digits, . _ -");
    }
    const std::string folder = path.has_parent_path() ? path.parent_path().string() : ".";
    for (const std::string& name : {stem + ".toml", stem + ".csv"}) {
        const auto there = std::filesystem::path(folder) / name;
        if (std::filesystem::exists(there)) {
            throw pave::Error({.file = there.string()}, "this file is there already", {}, "a name that is free");
        }
    }
    run::write_file(folder, stem + ".csv", std::string(data_template));
    run::write_file(folder, stem + ".toml", fmt::format(fmt::runtime(study_template), stem));
    fmt::print("written: {0}/{1}.toml and {0}/{1}.csv\nnext:    pavescape check {0}/{1}.toml\n", folder, stem);
    return done;
}

} // namespace

void add_new(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("new", "writes a commented study to start from");
    auto file = std::make_shared<std::string>();
    command->add_option("FILE", *file, "NAME.toml; the readings go to NAME.csv beside it")->required();
    command->footer("Example: pavescape new road.toml");
    command->callback([=, &action] { action = [=] { return write_study(*file); }; });
}

} // namespace explore::cli
