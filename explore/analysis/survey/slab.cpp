#include "analysis/survey/slab.h"

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

namespace explore::analysis {

using data::DeflectionBowl;
using pave::counted;
using pave::figure;
using pave::layered::Foundation;
using pave::layered::plate_deflection;

namespace {

constexpr double least_stiffness = 0.1; // m
constexpr double most_stiffness = 6.0;
constexpr double joint_offset_mm = 300.0;

// Deflections of the sensors for k = 1 Pa/m or C = 1 Pa [m/Pa times the pressure].
Eigen::VectorXd shape_of(const SlabOptions& options, const DeflectionBowl& bowl, double stiffness) {
    Eigen::VectorXd shape(static_cast<Eigen::Index>(bowl.readings.size()));
    for (std::size_t i = 0; i < bowl.readings.size(); ++i) {
        shape[static_cast<Eigen::Index>(i)] = plate_deflection(options.foundation, bowl.radius_mm * pave::unit::mm,
                                                               bowl.readings[i].offset_mm * pave::unit::mm, stiffness);
    }
    return shape;
}

// The best compliance of the foundation for a shape, by relative residuals, and what it leaves.
struct Scaled {
    double compliance = 0.0; // 1/k or 1/C
    Eigen::VectorXd residuals;
};
Scaled scaled(const DeflectionBowl& bowl, const Eigen::VectorXd& shape) {
    Eigen::VectorXd relative = shape;
    for (Eigen::Index i = 0; i < shape.size(); ++i) {
        const double reading = bowl.readings[static_cast<std::size_t>(i)].deflection_um * 1e-6;
        relative[i] *= bowl.pressure_kPa * pave::unit::kPa / reading;
    }
    const double compliance = relative.sum() / relative.squaredNorm();
    return {compliance, (compliance * relative).array() - 1.0};
}

// Golden section on ln l: of one bowl the sum of squares has one minimum within the range.
template <class F>
double minimum_of(const F& f) {
    const double part = 0.5 * (std::sqrt(5.0) - 1.0);
    double a = std::log(least_stiffness);
    double b = std::log(most_stiffness);
    double c = b - part * (b - a);
    double d = a + part * (b - a);
    double at_c = f(std::exp(c));
    double at_d = f(std::exp(d));
    constexpr double close = 1e-7;
    while (b - a > close) {
        if (at_c < at_d) {
            b = d;
            d = c;
            at_d = at_c;
            c = b - part * (b - a);
            at_c = f(std::exp(c));
        } else {
            a = c;
            c = d;
            at_c = at_d;
            d = a + part * (b - a);
            at_d = f(std::exp(d));
        }
    }
    return std::exp(0.5 * (a + b));
}

double foundation_of(const SlabOptions& options, double compliance) { // MPa/m, MPa
    const double si = 1.0 / compliance;
    return options.foundation == Foundation::dense_liquid
               ? si / pave::unit::MPa
               : 2.0 * (1.0 - options.soil_poisson * options.soil_poisson) * si / pave::unit::MPa;
}

// D = k l^4 or C l^3.
double slab_modulus_of(const SlabOptions& options, double compliance, double stiffness) { // MPa
    const double rigidity = std::pow(stiffness, options.foundation == Foundation::dense_liquid ? 4 : 3) / compliance;
    return rigidity / pave::layered::flexural_rigidity(1.0, options.thickness_mm * pave::unit::mm, options.poisson) /
           pave::unit::MPa;
}

SlabRange slab_range(double value, double log_deviation, double quantile) {
    return {value, value * std::exp(-quantile * log_deviation), value * std::exp(quantile * log_deviation)};
}

SlabFit fit_of(const SlabOptions& options, const DeflectionBowl& bowl) {
    const double stiffness =
        minimum_of([&](double l) { return scaled(bowl, shape_of(options, bowl, l)).residuals.squaredNorm(); });
    const Scaled best = scaled(bowl, shape_of(options, bowl, stiffness));
    const auto n = static_cast<double>(bowl.readings.size());
    SlabFit fit;
    fit.rms_percent = 100.0 * std::sqrt(best.residuals.squaredNorm() / n);
    // To first order in ln l and ln(1/k), with the variance that is left over.
    constexpr double step = 1e-3;
    const auto relative_at = [&](double log_step) -> Eigen::ArrayXd {
        const Eigen::ArrayXd shape = shape_of(options, bowl, stiffness * std::exp(log_step)).array();
        return shape / shape_of(options, bowl, stiffness).array();
    };
    Eigen::MatrixXd jacobian(best.residuals.size(), 2);
    jacobian.col(0) = (relative_at(step) - relative_at(-step)) / (2.0 * step);
    jacobian.col(1).setOnes();
    const Eigen::MatrixXd covariance =
        (jacobian.transpose() * jacobian).inverse() * (best.residuals.squaredNorm() / std::max(1.0, n - 2.0));
    const double quantile = n > 2.0 ? gsl_cdf_tdist_Pinv(0.975, n - 2.0) : 0.0;
    const double power = options.foundation == Foundation::dense_liquid ? 4.0 : 3.0;
    const Eigen::Vector2d of_slab(power, -1.0);
    fit.stiffness_mm = slab_range(stiffness / pave::unit::mm, std::sqrt(covariance(0, 0)), quantile);
    fit.foundation = slab_range(foundation_of(options, best.compliance), std::sqrt(covariance(1, 1)), quantile);
    fit.slab_MPa = slab_range(slab_modulus_of(options, best.compliance, stiffness),
                              std::sqrt(of_slab.dot(covariance * of_slab)), quantile);
    return fit;
}

// By the trapezium rule between the sensors, over the deflection in the middle [mm].
double area_of(const std::vector<data::BowlReading>& readings, const Eigen::VectorXd& deflections) {
    double sum = 0.0;
    for (std::size_t i = 1; i < readings.size(); ++i) {
        const auto at = static_cast<Eigen::Index>(i);
        sum += 0.5 * (deflections[at] + deflections[at - 1]) * (readings[i].offset_mm - readings[i - 1].offset_mm);
    }
    return sum / deflections[0];
}

void set_area(const SlabOptions& options, DeflectionBowl bowl, SlabStation& station) {
    constexpr double outermost = 1600.0;
    std::erase_if(bowl.readings, [](const data::BowlReading& r) { return r.offset_mm > outermost; });
    constexpr std::size_t least = 3;
    if (bowl.readings.size() < least) {
        return;
    }
    Eigen::VectorXd read(static_cast<Eigen::Index>(bowl.readings.size()));
    for (std::size_t i = 0; i < bowl.readings.size(); ++i) {
        read[static_cast<Eigen::Index>(i)] = bowl.readings[i].deflection_um;
    }
    station.area_mm = area_of(bowl.readings, read);
    const auto area_at = [&](double l) { return area_of(bowl.readings, shape_of(options, bowl, l)); };
    double low = least_stiffness;
    double high = most_stiffness;
    if (area_at(low) > *station.area_mm || area_at(high) < *station.area_mm) {
        return; // no plate has such a bowl
    }
    constexpr int halvings = 40;
    for (int i = 0; i < halvings; ++i) {
        const double middle = std::sqrt(low * high);
        (area_at(middle) < *station.area_mm ? low : high) = middle;
    }
    double l = std::sqrt(low * high);
    double d0 = bowl.d0_um() * 1e-6;
    if (options.length_mm > 0.0) {
        const double size = slab_size_mm(options) * pave::unit::mm / l;
        l *= 1.0 - 0.89434 * std::exp(-0.61662 * std::pow(size, 1.04831));
        d0 *= 1.0 - 1.15085 * std::exp(-0.71878 * std::pow(size, 0.80151));
    }
    station.area_stiffness_mm = l / pave::unit::mm;
    const double under_load = plate_deflection(options.foundation, bowl.radius_mm * pave::unit::mm, 0.0, l) *
                              bowl.pressure_kPa * pave::unit::kPa;
    station.area_foundation = foundation_of(options, d0 / under_load);
    station.area_slab_MPa = slab_modulus_of(options, d0 / under_load, l);
}

// Of the line through pressure and D0 of the levels, by least squares [um].
std::optional<double> intercept_of(const std::vector<DeflectionBowl>& levels) {
    if (levels.size() < 2) {
        return std::nullopt;
    }
    double p = 0.0;
    double d = 0.0;
    for (const DeflectionBowl& level : levels) {
        p += level.pressure_kPa;
        d += level.d0_um();
    }
    const auto n = static_cast<double>(levels.size());
    p /= n;
    d /= n;
    double pp = 0.0;
    double pd = 0.0;
    for (const DeflectionBowl& level : levels) {
        pp += std::pow(level.pressure_kPa - p, 2);
        pd += (level.pressure_kPa - p) * (level.d0_um() - d);
    }
    return d - pd / pp * p;
}

std::vector<double> values_of(const SlabResult& result,
                              const std::function<std::optional<double>(const SlabStation&)>& of) {
    std::vector<double> values;
    for (const SlabStation& station : result.stations) {
        if (const auto value = of(station)) {
            values.push_back(*value);
        }
    }
    return values;
}

std::string names_of(const std::vector<const SlabStation*>& stations) {
    std::vector<std::string> names;
    names.reserve(stations.size());
    for (const SlabStation* station : stations) {
        names.push_back(station->name);
    }
    return pave::join(names);
}

bool is_poor(const SlabStation& s) {
    return s.fit && s.fit->rms_percent > poor_rms_percent;
}

} // namespace

double slab_size_mm(const SlabOptions& options) {
    const double shorter = std::min(options.length_mm, options.width_mm);
    return std::sqrt(shorter * std::min(std::max(options.length_mm, options.width_mm), 2.0 * shorter));
}

SlabResult slabs(const std::vector<data::FwdFile>& files, const SlabOptions& options) {
    if ((options.length_mm > 0.0) != (options.width_mm > 0.0)) {
        throw pave::Error({.key = options.length_mm > 0.0 ? "--length" : "--width"}, "a slab has a length and a width",
                          "this one alone", "both, or neither for an infinite slab");
    }
    if (options.length_mm > 0.0 && options.foundation != Foundation::dense_liquid) {
        throw pave::Error({.key = "--length"}, "the size of slabs is known to count on a dense liquid alone",
                          "--foundation solid", "--foundation liquid, or no --length and --width");
    }
    SlabResult result{.options = options, .stations = {}, .bending = {}, .remarks = {}};
    std::vector<std::string> unknown = options.joints;
    std::vector<double> bending;
    std::vector<std::optional<double>> ratios; // D300/D0
    for (const data::FwdFile& file : files) {
        result.remarks.insert(result.remarks.end(), file.remarks.begin(), file.remarks.end());
        for (const data::FwdStation& read : file.stations) {
            SlabStation station{.name = read.name, .chainage_m = read.chainage_m};
            station.is_joint =
                std::find(options.joints.begin(), options.joints.end(), read.name) != options.joints.end();
            std::erase(unknown, read.name);
            ratios.emplace_back();
            const auto bowls = data::bowls_of(read);
            if (!bowls) {
                station.reason = bowls.failure().reason;
                result.stations.push_back(std::move(station));
                continue;
            }
            const DeflectionBowl& bowl = bowls->bowl();
            station.pressure_kPa = bowl.pressure_kPa;
            station.d0_um = bowl.d0_um();
            station.intercept_um = intercept_of(bowls->levels);
            if (const auto there = bowl.at(joint_offset_mm)) {
                ratios.back() = *there / bowl.d0_um();
            }
            constexpr std::size_t least = 3;
            if (station.is_joint) {
                station.reason = ratios.back() ? "" : "no sensor at 300 mm, beyond the joint";
            } else if (bowl.readings.size() < least) {
                station.reason = "two unknowns take three sensors or more";
            } else {
                station.fit = fit_of(options, bowl);
                set_area(options, bowl, station);
                if (ratios.back() && !is_poor(station)) {
                    bending.push_back(1.0 / *ratios.back());
                }
            }
            result.stations.push_back(std::move(station));
        }
    }
    if (!unknown.empty()) {
        std::vector<std::string> names;
        for (const SlabStation& station : result.stations) {
            names.push_back(station.name);
        }
        throw pave::Error({.key = "--joints"}, "no station has this name", unknown[0], pave::join(names));
    }
    if (!bending.empty()) {
        result.bending = data::median(bending);
    }
    for (std::size_t s = 0; s < result.stations.size(); ++s) {
        if (result.stations[s].is_joint && ratios[s]) {
            result.stations[s].transfer_percent = 100.0 * *ratios[s] * result.bending.value_or(1.0);
        }
    }
    return result;
}

std::vector<std::string> findings(const SlabResult& result) {
    std::vector<std::string> text;
    const bool is_liquid = result.options.foundation == Foundation::dense_liquid;
    const auto good = [](const SlabStation& s) {
        return s.fit && !is_poor(s) && s.intercept_um.value_or(0.0) <= void_intercept_um;
    };
    const auto of = [&](const auto& value) {
        return values_of(result, [&](const SlabStation& s) {
            return good(s) ? std::optional<double>(value(*s.fit)) : std::nullopt;
        });
    };
    const auto words = [](std::vector<double> values, const std::string& unit) {
        const double median = data::median(values);
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        return values.size() == 1 ? fmt::format("{} {}", figure(median, 3), unit)
                                  : fmt::format("{} {} in the median ({} to {})", figure(median, 3), unit,
                                                figure(*least, 3), figure(*most, 3));
    };
    const auto foundation = of([](const SlabFit& f) { return f.foundation.value; });
    if (foundation.empty()) {
        text.emplace_back("No bowl is that of a slab on such a foundation.");
    } else {
        text.push_back(fmt::format("{} at {}: {}; modulus of the concrete {}; radius of relative stiffness {}.",
                                   is_liquid ? "Modulus of subgrade reaction k" : "Modulus of the foundation",
                                   counted(foundation.size(), "slab", "slabs"),
                                   words(foundation, is_liquid ? "MPa/m" : "MPa"),
                                   words(of([](const SlabFit& f) { return f.slab_MPa.value; }), "MPa"),
                                   words(of([](const SlabFit& f) { return f.stiffness_mm.value; }), "mm")));
        if (result.options.length_mm > 0.0) {
            const auto by_area = [&](const auto& of_station) {
                return values_of(result, [&](const SlabStation& s) { return good(s) ? of_station(s) : std::nullopt; });
            };
            if (const auto k = by_area([](const SlabStation& s) { return s.area_foundation; }); !k.empty()) {
                text.push_back(fmt::format(
                    "As slabs of {:g} by {:g} m, by AREA: k {}; modulus of the concrete {}; radius of relative "
                    "stiffness {}. The values before are those of infinite slabs.",
                    result.options.length_mm * pave::unit::mm, result.options.width_mm * pave::unit::mm,
                    words(k, "MPa/m"), words(by_area([](const SlabStation& s) { return s.area_slab_MPa; }), "MPa"),
                    words(by_area([](const SlabStation& s) { return s.area_stiffness_mm; }), "mm")));
            }
        }
        if (is_liquid) {
            text.emplace_back("k is that of a falling weight; design by static k takes about half of it.");
        }
    }
    std::vector<const SlabStation*> poor;
    std::vector<const SlabStation*> hollow;
    for (const SlabStation& s : result.stations) {
        if (is_poor(s)) {
            poor.push_back(&s);
        }
        if (s.intercept_um.value_or(0.0) > void_intercept_um) {
            hollow.push_back(&s);
        }
    }
    if (!poor.empty()) {
        text.push_back(
            fmt::format("{}: the bowl is not that of a slab on this foundation (more than {:.0f} % off). A "
                        "joint or crack nearby, asphalt on top, or the other foundation: try --foundation {}.",
                        names_of(poor), poor_rms_percent, is_liquid ? "solid" : "liquid"));
    }
    if (!hollow.empty()) {
        text.push_back(fmt::format("A void is suspected under {}: the line through load and deflection does not start "
                                   "at zero but above {:.0f} um. Drop there again at three levels, or core.",
                                   names_of(hollow), void_intercept_um));
    }
    for (const SlabStation& s : result.stations) {
        if (s.transfer_percent) {
            constexpr double low = 70.0; // AASHTO 1993: poor below 50, good from 70
            text.push_back(
                fmt::format("Load transfer at {}: {:.0f} %{}.", s.name, *s.transfer_percent,
                            *s.transfer_percent < low ? ", which is low: restore it before an overlay" : ""));
        }
    }
    if (!result.bending &&
        std::any_of(result.stations.begin(), result.stations.end(), [](const auto& s) { return s.is_joint; })) {
        text.emplace_back(
            "No slab was dropped on in its middle: load transfer is D300/D0 as read, without a correction "
            "for the bending of the slab.");
    }
    return text;
}

} // namespace explore::analysis
