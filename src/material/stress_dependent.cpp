#include "material/stress_dependent.h"

#include "base/units.h"
#include "material/floor.h"

#include <cmath>

namespace pave::material {

StressDependent::StressDependent(std::vector<ParameterInfo> own, std::optional<double> default_n) : own_(own.size()) {
    infos_.push_back(modulus_axis_info());
    infos_.insert(infos_.end(), own.begin(), own.end());
    const auto directions = direction_infos(default_n);
    infos_.insert(infos_.end(), directions.begin(), directions.end());
    infos_.push_back(tension_smoothing_info());
    infos_.push_back({"shear_floor",
                      1.0,
                      0.0,
                      10.0,
                      false,
                      not_given,
                      "eta, floor of theta in proportion to shear; default 0 incremental, 1 secant",
                      {}});
}

ParameterInfo scale_info(std::string_view meaning) {
    return {"k1", 1.0, 0.0, 1e6, true, {}, meaning, {}, UsualRange{300, 12000, 1500, true}};
}
ParameterInfo confinement_info(UsualRange range) {
    return {"k2",
            1.0,
            -5.0,
            5.0,
            false,
            {},
            "exponent of confinement: stiffens when positive",
            {},
            range,
            StressPower{"theta"}};
}
ParameterInfo poisson_12_info() {
    return {"poisson_12", 1.0, -0.99, 0.99,     false, {}, "Poisson's ratio in the horizontal plane",
            {},           {},  {},    "poisson"};
}
ParameterInfo poisson_31_info() {
    return {"poisson_31", 1.0, -0.99, 2.0, false, {}, "horizontal strain from vertical load", {}, {}, {}, "poisson"};
}
ParameterInfo modulus_axis_info() {
    return {"modulus_axis", 1.0, 0.0, 1.0, false, 0.0, "which modulus the law gives", {"horizontal", "vertical"}};
}
std::vector<ParameterInfo> direction_infos(std::optional<double> default_n) {
    return {
        {"n", 1.0, 0.0, 20.0, true, default_n, "horizontal over vertical modulus, E1/E3", {}},
        poisson_12_info(),
        poisson_31_info(),
        {"shear_ratio", 1.0, 0.0, 10.0, true, not_given, "G13/E3; without it 1/G13 = 1/E1 + (1 + 2 nu31)/E3", {}},
    };
}
mechanics::CrossAnisotropy cross_anisotropy(double modulus_axis, std::span<const double> directions) {
    return {.n = directions[0],
            .nu12 = directions[1],
            .nu31 = directions[2],
            .shear_ratio = std::isnan(directions[3]) ? std::nullopt : std::optional(directions[3]),
            .modulus_is_vertical = modulus_axis == 1.0};
}
ParameterInfo tension_smoothing_info() {
    return {"tension_smoothing_kPa", unit::kPa, 0.0, 1e3, true, 5.0, "delta, the smooth floor of theta", {}};
}

std::span<const std::size_t> StressDependent::scale_parameters() const {
    static constexpr std::size_t own[] = {first};
    return own;
}

Modulus StressDependent::modulus(std::span<const double> p, mechanics::Invariants at) const {
    const Floor floor(p[place(delta)], p[place(eta)], at);
    const Terms t = terms(own(p), floor.thp, at.tau);
    if (!(t.value < modulus_limit)) {
        return {.value = modulus_limit, .d_theta = 0.0, .d_tau = 0.0, .limited = true};
    }
    return {.value = t.value,
            .d_theta = t.d_thp * floor.d_theta,
            .d_tau = t.d_tau + t.d_thp * floor.d_tau,
            .limited = false};
}

double StressDependent::modulus_derivative(std::span<const double> p, mechanics::Invariants at, const Modulus& here,
                                           std::size_t i) const {
    const bool is_own = i >= first && i < first + own_;
    if (here.limited || !(is_own || i == place(delta) || i == place(eta))) {
        return 0.0;
    }
    const Floor floor(p[place(delta)], p[place(eta)], at);
    if (is_own) {
        return own_derivative(own(p), floor.thp, at.tau, here.value, i - first);
    }
    return terms(own(p), floor.thp, at.tau).d_thp *
           (i == place(delta) ? floor.by_delta(p[i]) : floor.by_eta(p[i], at.tau));
}

mechanics::Stiffness<6> StressDependent::unit_stiffness(std::span<const double> p, mechanics::Invariants) const {
    return cross_anisotropy(p[0], p.subspan(place(n))).unit_stiffness();
}

mechanics::Stiffness<6> StressDependent::unit_stiffness_derivative(std::span<const double> p, mechanics::Invariants,
                                                                   std::size_t i) const {
    if (i < place(n) || i > place(shear_ratio)) {
        return mechanics::Stiffness<6>::Zero();
    }
    return cross_anisotropy(p[0], p.subspan(place(n))).unit_stiffness_derivative(direction_variables[i - place(n)]);
}

std::string StressDependent::impossible(std::span<const double> p) const {
    return cross_anisotropy(p[0], p.subspan(place(n))).impossible();
}

} // namespace pave::material
