#include "data/temperature_curves.h"

#include "data/asphalt_temperature.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::data {
namespace {

// Of D0 and of the differences from it to 300, 600 and 900 mm.
struct Factors {
    double d0 = 1.0, to_300 = 1.0;
    std::optional<double> to_600{}, to_900{};
};

// The sums of indices that are differences from D0.
std::optional<double> sum(const std::optional<double>& a, const std::optional<double>& b) {
    return a && b ? std::optional(*a + *b) : std::nullopt;
}

Factors fhwa_factors(double h, double latitude, double d, double from_C, double to_C) {
    const double lg_h = std::log10(h);
    const double lg_phi = std::log10(latitude);
    const double lg_d = std::log10(d);
    const double by_12 = -0.0275 + 0.012 * lg_h * lg_phi;
    const double by_24 = -0.00622 * lg_phi * lg_d + 0.00838 * lg_h * lg_phi;
    const double by_36 = -0.00487 * lg_phi * lg_d + 0.00677 * lg_h * lg_phi;
    const auto delta_36 = [&](double celsius) {
        return std::pow(10.0, 3.05 - 1.13 * lg_h + 0.502 * lg_phi * lg_d + by_36 * celsius);
    };
    const auto ratio = [&](double slope) { return std::pow(10.0, slope * (to_C - from_C)); };
    return {.d0 = (d + delta_36(to_C)) / (d + delta_36(from_C)),
            .to_300 = ratio(by_12),
            .to_600 = ratio(by_24),
            .to_900 = ratio(by_36)};
}

Factors rws_factors(double from_C, double to_C) {
    const auto ratio = [&](double linear, double square) {
        const auto at = [&](double celsius) {
            const double t = celsius - 20.0;
            return 1.0 + linear * t + square * t * t;
        };
        return at(to_C) / at(from_C);
    };
    return {.d0 = ratio(0.013926, 0.0002298), .to_300 = ratio(0.043535, 0.00098467)};
}

std::vector<std::string> out_of_range(TemperatureCurve curve, double reference_C, const WhereMeasured& where) {
    const TemperatureCurveWords& words = words_of(curve);
    std::vector<std::string> found;
    for (const double celsius : {where.asphalt_C, reference_C}) {
        if (!(celsius >= words.coldest_C && celsius <= words.hottest_C)) {
            found.push_back(
                fmt::format("{:.3g} C (it is used from {:g} to {:g} C)", celsius, words.coldest_C, words.hottest_C));
        }
    }
    if (curve == TemperatureCurve::fhwa && where.latitude_deg) {
        const double latitude = std::abs(*where.latitude_deg);
        if (!(latitude >= fhwa_lowest_latitude && latitude <= fhwa_highest_latitude)) {
            found.push_back(fmt::format("a latitude of {:.0f} degrees (its sites lie between {:g} and {:g})", latitude,
                                        fhwa_lowest_latitude, fhwa_highest_latitude));
        }
    }
    if (curve == TemperatureCurve::irc && where.asphalt_mm && *where.asphalt_mm < irc_thinnest_mm) {
        found.push_back(
            fmt::format("{:.0f} mm of asphalt (it wants {:g} mm at least)", *where.asphalt_mm, irc_thinnest_mm));
    }
    return found;
}

} // namespace

IndicesAtReference indices_at(TemperatureCurve curve, double reference_C, const WhereMeasured& where,
                              const BowlIndices& indices) {
    IndicesAtReference result{.out_of_range = out_of_range(curve, reference_C, where)};
    if (curve == TemperatureCurve::irc) {
        return result;
    }
    Factors factors;
    if (curve == TemperatureCurve::rws) {
        factors = rws_factors(where.asphalt_C, reference_C);
    } else {
        result.why_not = !where.asphalt_mm     ? "the thickness of the asphalt is not known"
                         : !where.latitude_deg ? "the latitude is not known"
                         : !where.d900_um      ? "there is no deflection at 900 mm"
                                               : "";
        if (!result.why_not.empty()) {
            return result;
        }
        // At the equator the regression's logarithm of the latitude has no value; far outside its range already.
        const double latitude = std::max(1.0, std::abs(*where.latitude_deg));
        factors = fhwa_factors(*where.asphalt_mm, latitude, *where.d900_um, where.asphalt_C, reference_C);
    }
    result.d0_um = factors.d0 * indices.d0_um;
    if (indices.sci_um) {
        result.sci_um = factors.to_300 * *indices.sci_um;
    }
    const auto to_600 = sum(indices.sci_um, indices.bdi_um);
    const auto to_900 = sum(to_600, indices.bci_um);
    if (to_600 && factors.to_600) {
        result.bdi_um = *factors.to_600 * *to_600 - *result.sci_um;
    }
    if (to_900 && factors.to_900) {
        result.bci_um = *factors.to_900 * *to_900 - *factors.to_600 * *to_600;
    }
    return result;
}

std::optional<double> modulus_factor_by(TemperatureCurve curve, double asphalt_C, double reference_C) {
    if (curve != TemperatureCurve::irc) {
        return modulus_factor(asphalt_C, reference_C);
    }
    const auto share = [](double celsius) { return celsius > 0.0 ? 1.0 - 0.238 * std::log(celsius) : 0.0; };
    const double to = share(reference_C);
    const double from = share(asphalt_C);
    return to > 0.0 && from > 0.0 ? std::optional(to / from) : std::nullopt;
}

} // namespace explore::data
