#include "analysis/studies/new_study.h"

#include "base/error.h"
#include "base/text.h"
#include "data/asphalt_temperature.h"
#include "data/bowl_indices.h"
#include "data/fwd_values.h"
#include "data/reading.h"
#include "data/resolution.h"
#include "data/road_bowls.h"
#include "run/program.h"
#include "study/station.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <numbers>

namespace explore::analysis {
namespace {

// Differences between the two kinds of study.
struct Parts {
    std::string head;   // comment lines
    std::string title;  // harmless in quotes
    std::string layers; // a comment line on where the layers come from
    std::string loads;  // [[loads]]
    std::string noise;  // of [data]
    std::string load;   // that the output is predicted under
    NewSection section;
};

std::string study_text(const std::string& name, const Parts& parts) {
    return fmt::format(
        R"({0}#     pavescape check {1}
#     pavescape fit {1}
#     pavescape explore {1}
# Keys carry their unit. `pavescape effects` lists what can be added to the model.
schema = 1
title = "{2}"

# What the last layer stands on. "half-space": it goes on for ever. "rigid": on rock at the bottom of its thickness_mm,
# which may be a parameter: a floor where there is none makes the subgrade look too soft.
[section]
bottom = "half-space"

{3}
{4}
{5}
{6}
# The unknowns, and between which bounds.
{7}
# What the answer is for: predicted from every set of parameters that the readings allow.
{8})",
        parts.head, run::shell_word(name + ".toml"), parts.title, parts.layers, parts.section.layers_text(),
        parts.loads, parts.noise, parts.section.parameters_text(), parts.section.outputs_text(parts.load));
}

double hundredths(double value) {
    return std::round(100.0 * value) / 100.0;
}

// In a comment or between quotes of TOML.
std::string harmless(const std::string& text) {
    std::string safe = pave::printable(text, 80);
    std::replace(safe.begin(), safe.end(), '"', '\'');
    std::replace(safe.begin(), safe.end(), '\\', '/');
    return safe;
}

const data::FwdStation& chosen(const data::FwdFile& file, const std::string& path, const std::string& station) {
    std::vector<std::string> names;
    std::string why;
    for (const data::FwdStation& s : file.stations) {
        if (station.empty()) {
            const auto bowls = data::bowls_of(s);
            if (bowls) {
                return s;
            }
            why = why.empty() ? "station " + s.name + ": " + bowls.failure().reason : why;
        } else if (s.name == station || (s.chainage_m && fmt::format("{:g}", *s.chainage_m) == station)) {
            return s;
        }
        names.push_back(s.name);
    }
    constexpr std::size_t most = 40;
    if (names.size() > most) {
        names.resize(most);
        names.emplace_back("...");
    }
    if (station.empty()) {
        throw pave::Error({.file = path}, "no station of this file can be used", why, "pavescape survey shows all");
    }
    throw pave::Error({.file = path, .key = "--station"}, "this station is not in the file", "\"" + station + "\"",
                      pave::join(names));
}

// Of the layers of a study; template_words: where none were stated.
void set_layers(Parts& parts, const NewOptions& options, std::string_view template_words) {
    parts.layers = options.layers.empty()
                       ? template_words
                       : "# Layers from the top down, as stated; their laws, densities and Poisson's "
                         "ratios are usual ones.";
    if (!options.layers.empty()) {
        parts.section.layers = options.layers;
    }
    parts.section.is_linear = options.is_linear;
}

// Vertical strain under the centre of a uniform circle of pressure on an elastic half-space (Ahlvin and Ulery 1962, HRB
// Bulletin 342), with z over the radius: p (1 + nu)/E ((1 - 2 nu)(1 - z/r) + z/r^3), r = sqrt(1 + z^2).
double half_space_strain(double z, double pressure_over_modulus, double poisson) {
    const double r = std::hypot(1.0, z);
    return pressure_over_modulus * (1.0 + poisson) * ((1.0 - 2.0 * poisson) * (1.0 - z / r) + z / (r * r * r));
}

} // namespace

NewStudy example_study(const std::string& name, const NewOptions& options) {
    Parts parts;
    parts.head = "# A study: one section, what was measured on it, what is to be found. Written by `pavescape new`; "
                 "runs as it stands:\n";
    parts.title = name;
    set_layers(parts, options, "# Layers from the top down: replace the numbers by yours.");
    if (!options.gauges_mm.empty()) {
        constexpr double radius_mm = 98.9, pressure_kPa = 650.0, modulus_MPa = 120.0, poisson = 0.35;
        parts.load = "wheel";
        parts.loads = fmt::format(R"(# The load: "wheel", "dual-wheel" or "plate" (FWD).
[[loads]]
name = "wheel"
type = "wheel"
patch = "circle"
force_kN = {:.1f}
pressure_kPa = {:g}
)",
                                  pressure_kPa * std::numbers::pi * radius_mm * radius_mm * 1e-6, pressure_kPa);
        parts.noise = fmt::format(R"(# The readings: vertical strains over gauges of 75 mm.
[data]
files = ["{}.csv"]
misfit = "weighted"

[data.noise]
relative = 0.05
absolute = {{ microstrain = 10 }}
)",
                                  name);
        std::string rows;
        for (const double depth_mm : options.gauges_mm) {
            const double strain = half_space_strain(depth_mm / radius_mm, 1e-3 * pressure_kPa / modulus_MPa, poisson);
            rows += fmt::format("wheel,strain_zz,0,0,{:g},75,{:.0f},microstrain,\n", depth_mm, 1e6 * strain);
        }
        return {study_text(name, parts),
                fmt::format("# Examples, not measurements: strains in a half-space of {:g} MPa. Replace them.\n"
                            "# Strains are positive in compression. depth_mm: of the middle of a gauge.\n{}\n{}",
                            modulus_MPa, data::measurement_header(), rows)};
    }
    parts.loads = R"(# The load: "plate" (FWD), "wheel" or "dual-wheel".
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 566            # 40 kN
)";
    parts.noise = fmt::format(
        R"(# The readings. Without noise here or a sigma in the file it is taken from the residuals of the fit.
[data]
files = ["{}.csv"]
misfit = "weighted"           # by the noise; "log": by the logarithms, for strains of all sizes
noise_relative = 0.02
noise_floor = 0.005           # of the largest reading under that load
)",
        name);
    parts.load = "fwd";
    // The section above with asphalt of 3500 MPa, k1 1400 and a subgrade of 65 MPa; `pavescape twin
    // --noise 0.015 --seed 2`, rounded to micrometres.
    const std::string readings =
        "# An example bowl, not a measurement: replace it. quantity: deflection, strain_zz, strain_xx, stress_zz, ...\n"
        "# Deflections are positive down, strains and stresses in compression. sigma may be empty.\n"
        "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n"
        "fwd,deflection,0,0,0,0,0.815,mm,\n"
        "fwd,deflection,200,0,0,0,0.685,mm,\n"
        "fwd,deflection,300,0,0,0,0.584,mm,\n"
        "fwd,deflection,450,0,0,0,0.449,mm,\n"
        "fwd,deflection,600,0,0,0,0.344,mm,\n"
        "fwd,deflection,900,0,0,0,0.219,mm,\n"
        "fwd,deflection,1200,0,0,0,0.142,mm,\n"
        "fwd,deflection,1500,0,0,0,0.107,mm,\n";
    return {study_text(name, parts), readings};
}

namespace {

std::string station_head(const data::FwdStation& station, const std::string& source) {
    const auto given = [](const char* what, const std::optional<double>& celsius) {
        return celsius ? fmt::format(", {} {:g} C", what, *celsius) : std::string();
    };
    return fmt::format("# Station {} of {}{}{}{}{}{}. Written by `pavescape new`:\n", harmless(station.name), source,
                       station.date.empty() ? "" : ", " + harmless(station.date),
                       station.time.empty() ? "" : " " + harmless(station.time), given("air", station.air_C),
                       given("surface", station.surface_C),
                       given("asphalt", data::measured_asphalt_C(station.asphalt_C, station.surface_C)));
}

// At mid-depth of the asphalt: measured, or by BELLS3 from the surface; nothing: the file does not tell.
std::optional<double> asphalt_C(const data::FwdStation& station, const NewSection& section) {
    const auto measured = data::measured_asphalt_C(station.asphalt_C, station.surface_C);
    const auto hour = data::hour_of_day(station.time);
    const NewLayer& top = section.layers[0];
    return measured ? measured
           : station.surface_C && station.air_C && hour && top.material == NewMaterial::asphalt
               ? std::optional(data::bells3(*station.surface_C, *station.air_C, *hour, *top.thickness_mm / 2.0))
               : std::nullopt;
}

constexpr std::string_view layers_of_station =
    "# Layers from the top down. The file does not say what they are: REPLACE thicknesses and laws by "
    "those of your road.\n# depth_mm of the outputs below goes with the thicknesses.";

// By the surface modulus at the farthest sensor; over a floor, where that rises with distance, by the least of them.
void set_subgrade(Parts& parts, const data::DeflectionBowl& bowl) {
    constexpr double softest = 10.0; // MPa
    constexpr double stiffest = 1000.0;
    double least = stiffest;
    std::optional<double> farthest;
    for (const auto& at : data::indices_of(bowl, bowl.pressure_kPa).surface_moduli) {
        if (at.offset_mm > 0.0 && at.modulus_MPa > 0.0) {
            farthest = std::clamp(at.modulus_MPa, softest, stiffest);
            least = std::min(least, *farthest);
        }
    }
    if (farthest) {
        parts.section.subgrade_MPa = two_digits(least);
        parts.section.subgrade_low_MPa = two_digits(least / 4.0);
        parts.section.subgrade_high_MPa = two_digits(*farthest * 4.0);
    }
}

// Of all stations: repeats along the whole road tell more than those of one.
std::vector<pave::Outcome<data::StationBowls>> bowls_of_file(const data::FwdFile& file) {
    std::vector<const data::FwdStation*> stations;
    for (const data::FwdStation& s : file.stations) {
        stations.push_back(&s);
    }
    return data::bowls_of_road(stations);
}

// Of a station of the file.
const data::StationBowls& bowls_or_error(const std::vector<pave::Outcome<data::StationBowls>>& road,
                                         const data::FwdFile& file, const data::FwdStation& station,
                                         const std::string& path) {
    const auto& bowls = road[static_cast<std::size_t>(&station - file.stations.data())];
    if (!bowls) {
        throw pave::Error({.file = path, .line = station.line, .key = "station " + station.name},
                          "its readings cannot be right", bowls.failure().reason, "another station");
    }
    return *bowls;
}

} // namespace

NewStudy study_of_pulses(const std::string& name, const data::FwdFile& file, const std::string& path,
                         const std::string& wanted, const NewOptions& options) {
    const data::FwdStation& station = chosen(file, path, wanted);
    const std::string source = harmless(std::filesystem::path(path).filename().string());
    const auto road = bowls_of_file(file);
    const data::StationBowls& bowls = bowls_or_error(road, file, station, path);
    constexpr double apart_ms = 1.0;
    NewStudy made;
    Parts parts;
    parts.head = station_head(station, source);
    parts.title = fmt::format("Station {} of {}, whole pulses", harmless(station.name), source);
    set_layers(parts, options, layers_of_station);
    parts.section.asphalt_C = asphalt_C(station, parts.section);
    parts.section.has_energy = true;
    parts.loads = "# The drops of the station that have a history. time_shift_ms would move readings against it.\n";
    std::vector<data::Reading> rows;
    double longest_ms = 0.0;
    for (const data::FwdDrop& drop : station.drops) {
        if (!drop.history) {
            continue;
        }
        const data::FwdHistory& history = *drop.history;
        const std::string load = fmt::format("drop-{}", drop.number);
        const std::string csv = fmt::format("{}-{}.csv", name, load);
        std::string pressures = "time_ms,pressure_kPa\n";
        for (std::size_t i = 0; i < history.pressure_kPa.size(); ++i) {
            pressures +=
                fmt::format("{:.6g},{:g}\n", history.step_ms * static_cast<double>(i), history.pressure_kPa[i]);
        }
        made.histories.emplace_back(csv, pressures);
        parts.load = load; // the last one
        parts.loads += fmt::format("[[loads]]\nname = \"{}\"\ntype = \"plate\"\nradius_mm = {:g}\nhistory = \"{}\"\n\n",
                                   load, drop.radius_mm, csv);
        const auto every = static_cast<std::size_t>(std::max(1.0, std::round(apart_ms / history.step_ms)));
        const std::size_t sensors = history.offsets_mm.size();
        for (std::size_t s = 0; s < sensors; ++s) {
            for (std::size_t i = every; i < history.pressure_kPa.size(); i += every) {
                const double deflection = history.deflection_um[i * sensors + s];
                data::Reading row;
                row.load = load;
                row.quantity = "deflection";
                row.x_mm = history.offsets_mm[s];
                row.time_ms = history.step_ms * static_cast<double>(i);
                row.value = deflection;
                row.unit = data::unit_named("um");
                if (std::isfinite(deflection)) {
                    longest_ms = std::max(longest_ms, *row.time_ms);
                    rows.push_back(std::move(row));
                }
            }
        }
    }
    if (made.histories.empty() || rows.empty()) {
        throw pave::Error({.file = path, .line = station.line, .key = "station " + station.name},
                          "none of its drops has a time history", pave::join(file.remarks),
                          "a station with one, or its peaks: without --pulses");
    }
    parts.loads.pop_back();
    parts.noise = fmt::format(
        R"(# The readings, one a millisecond. Errors of one sensor at two times are alike, and geophones drift.
[data]
files = ["{}.csv"]
misfit = "weighted"

[data.noise]
relative = 0.02
absolute = {{ um = 2 }}
correlation_ms = 5
drift_um_per_ms = 0.2

[solver]
time_step_ms = 0.5            # 0.2 for the final answer
)",
        name);
    set_subgrade(parts, bowls.bowl());
    made.study = study_text(name, parts);
    made.readings = fmt::format("# Station {} of {}: {} drop{} over {:g} ms\n{}", harmless(station.name), source,
                                made.histories.size(), made.histories.size() == 1 ? "" : "s", longest_ms,
                                data::measurement_rows(rows));
    return made;
}

NewStudy study_of_station(const std::string& name, const data::FwdFile& file, const std::string& path,
                          const std::string& wanted, const NewOptions& options) {
    const data::FwdStation& station = chosen(file, path, wanted);
    const std::string source = harmless(std::filesystem::path(path).filename().string());
    const auto road = bowls_of_file(file);
    const data::StationBowls& bowls = bowls_or_error(road, file, station, path);
    std::vector<const data::DeflectionBowl*> all;
    for (const auto& s : road) {
        for (std::size_t i = 0; s && i < s->levels.size(); ++i) {
            all.push_back(&s->levels[i]);
        }
    }
    const auto repeatability = data::repeatability(all);

    Parts parts;
    parts.head = station_head(station, source);
    parts.title = fmt::format("Station {} of {}", harmless(station.name), source);
    set_layers(parts, options, layers_of_station);
    parts.section.asphalt_C = asphalt_C(station, parts.section);
    std::string rows;
    std::string left_out;
    parts.loads = "# The loads of the station, one a level.\n";
    for (const data::DeflectionBowl& bowl : bowls.levels) {
        const std::string load = fmt::format("fwd-{:.0f}kPa", bowl.pressure_kPa);
        parts.loads += fmt::format("[[loads]]\nname = \"{}\"\ntype = \"plate\"\nradius_mm = {:g}\npressure_kPa = {:g}  "
                                   "          # {:.1f} kN, drop{} {}\n\n",
                                   load, bowl.radius_mm, bowl.pressure_kPa, bowl.force_kN(),
                                   bowl.drops.size() == 1 ? "" : "s", fmt::join(bowl.drops, ", "));
        if (&bowl == &bowls.bowl()) {
            parts.load = load;
        }
        for (const data::BowlReading& reading : bowl.readings) {
            data::Reading row;
            row.load = load;
            row.quantity = "deflection";
            row.x_mm = reading.offset_mm;
            row.value = hundredths(reading.deflection_um);
            row.unit = data::unit_named("um");
            row.sigma = hundredths(study::bowl_sigma_um(reading, repeatability.value_or(0.0)));
            rows += data::measurement_row(row);
        }
    }
    parts.loads.pop_back();
    for (const data::DropLeftOut& drop : bowls.left_out) {
        const bool used = drop.why == data::LeftOut::another_level; // its level is a load of its own
        left_out += used ? ""
                         : fmt::format("# Drop {} is left out{}{}\n", drop.number,
                                       drop.why == data::LeftOut::seating ? ": it seats the plate" : "",
                                       drop.words.empty() ? "" : ": " + harmless(drop.words));
    }
    for (const std::string& remark : bowls.remarks) {
        left_out += fmt::format("# {}\n", harmless(remark));
    }
    parts.noise = fmt::format(R"(# The readings; every one states its noise (sigma).
[data]
files = ["{}.csv"]
misfit = "weighted"
)",
                              name);
    set_subgrade(parts, bowls.bowl());
    const double resolution = bowls.bowl().readings[0].resolution_um;
    const std::string head = fmt::format(
        "# Station {} of {}: means of the drops of each level. sigma: {}, with 1 um and 1 % of the sensor{}\n{}{}\n",
        harmless(station.name), source,
        repeatability ? fmt::format("repeats scatter by {:.1f} %", 100.0 * *repeatability) : "no drop is repeated",
        resolution > 1.0
            ? fmt::format(" and what rounding leaves (readings are {})", data::resolution_words(resolution))
            : "",
        left_out, data::measurement_header());
    return {study_text(name, parts), head + rows};
}

std::string plain_name(const std::string& name) {
    constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
    std::string made;
    std::copy_if(name.begin(), name.end(), std::back_inserter(made),
                 [&](char c) { return plain.find(c) != std::string_view::npos; });
    return made;
}

} // namespace explore::analysis
