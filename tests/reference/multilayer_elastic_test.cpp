#include "multilayer_elastic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace pave::reference {
namespace {

using std::numbers::pi;
using Stack = std::vector<ElasticLayer>;

constexpr double micro = 1e-6;
constexpr double just_above = 1e-9; // m

// Thin stiff surfacing on a granular base on soft soil in a concrete tank, under a plate.
const Stack tank{{0.030, 3000e6, 0.35}, {0.277, 300e6, 0.35}, {1.193, 40e6, 0.40}};
constexpr double tank_radius = 0.15;
constexpr double tank_pressure = 595e3;

ElasticField in_tank(double r, double z) {
    return multilayer_elastic(tank, Floor::rigid_rough, tank_radius, tank_pressure, r, z);
}

// Simpson's rule.
template <class Function>
double integral(double from, double to, int intervals, Function&& f) {
    const double step = (to - from) / intervals;
    double sum = f(from) + f(to);
    for (int i = 1; i < intervals; ++i) {
        sum += (i % 2 == 1 ? 4.0 : 2.0) * f(from + i * step);
    }
    return sum * step / 3.0;
}

// Integral of J1(k a) J0(k r) / k over k: the surface deflection of a half-space, by complete elliptic integrals.
double half_space_deflection(double a, double r) {
    if (r < a) {
        return 2.0 / pi * std::comp_ellint_2(r / a);
    }
    if (r == a) {
        return 2.0 / pi;
    }
    const double m = a / r;
    return 2.0 / (pi * m) * (std::comp_ellint_2(m) - (1.0 - m * m) * std::comp_ellint_1(m));
}

// The deflection 2 (1 - nu^2) q a / E times the integral of kernel(k) J1(k a) J0(k r) / k, kernel(infinity) = 1.
template <class Kernel>
double surface_deflection(const ElasticLayer& top, double a, double q, double r, double last, Kernel&& kernel) {
    const double rest = integral(0.0, last, 20000, [&](double k) {
        const double load = k > 0.0 ? std::cyl_bessel_j(1.0, k * a) / k : a / 2.0;
        return (kernel(k) - 1.0) * load * std::cyl_bessel_j(0.0, k * r);
    });
    return 2.0 * (1.0 - top.poisson * top.poisson) * q * a / top.modulus * (half_space_deflection(a, r) + rest);
}

void expect_relative(double value, double expected, double tolerance, const std::string& what) {
    EXPECT_NEAR(value, expected, tolerance * std::abs(expected)) << what;
}

// Boussinesq's solution integrated over the circle, on its axis (Timoshenko and Goodier, Theory of Elasticity).
void expect_boussinesq_on_the_axis(const Stack& layers, double modulus, double nu) {
    constexpr double a = 0.15;
    constexpr double q = 600e3;
    for (const double z : {0.0, 1e-7, 1e-3, 0.05, 0.15, 0.2, 0.35, 0.9, 3.0}) {
        const std::string where = "z = " + std::to_string(z);
        const double d = std::hypot(a, z);
        const double sigma_z = -q * (1.0 - std::pow(z / d, 3));
        const double sigma_r = -q / 2.0 * (1.0 + 2.0 * nu - 2.0 * (1.0 + nu) * z / d + std::pow(z / d, 3));
        const double u_z = (1.0 + nu) * q / modulus * (a * a / d + (1.0 - 2.0 * nu) * a * a / (d + z));
        const ElasticField field = multilayer_elastic(layers, Floor::half_space, a, q, 0.0, z);
        expect_relative(field.u_z, u_z, 1e-10, where);
        EXPECT_EQ(field.u_r, 0.0);
        EXPECT_NEAR(field.sigma_rr, field.sigma_tt, 1e-10 * q);
        EXPECT_NEAR(field.sigma_zz, sigma_z, 1e-10 * q) << where;
        EXPECT_NEAR(field.sigma_rr, sigma_r, 1e-10 * q) << where;
        EXPECT_NEAR(field.sigma_rz, 0.0, 1e-10 * q) << where;
        EXPECT_NEAR(field.eps_zz, (sigma_z - 2.0 * nu * sigma_r) / modulus, 1e-10 * q / modulus) << where;
        EXPECT_NEAR(field.eps_rr, ((1.0 - nu) * sigma_r - nu * sigma_z) / modulus, 1e-10 * q / modulus) << where;
        EXPECT_NEAR(field.eps_tt, field.eps_rr, 1e-10 * q / modulus) << where;
    }
    const double u_z = multilayer_elastic(layers, Floor::half_space, a, q, 0.0, 0.0).u_z;
    expect_relative(u_z, 2.0 * (1.0 - nu * nu) * q * a / modulus, 1e-10, "surface");
}

TEST(MultilayerElastic, ReproducesBoussinesqUnderACircle) {
    expect_boussinesq_on_the_axis({{0.0, 80e6, 0.35}}, 80e6, 0.35);
    expect_boussinesq_on_the_axis({{0.0, 80e6, 0.5}}, 80e6, 0.5);
    expect_boussinesq_on_the_axis({{0.0, 80e6, 0.0}}, 80e6, 0.0);
}

TEST(MultilayerElastic, ReproducesBoussinesqWithThreeLayersOfOneMaterial) {
    expect_boussinesq_on_the_axis({{0.05, 80e6, 0.35}, {0.3, 80e6, 0.35}, {0.0, 80e6, 0.35}}, 80e6, 0.35);
    expect_boussinesq_on_the_axis({{0.2, 80e6, 0.5}, {0.15, 80e6, 0.5}, {0.0, 80e6, 0.5}}, 80e6, 0.5);
}

TEST(MultilayerElastic, ReproducesTheSurfaceOfAHalfSpaceOffTheAxis) {
    constexpr double a = 0.15, q = 600e3, e = 80e6, nu = 0.35;
    const Stack one{{0.0, e, nu}};
    const Stack two{{0.04, e, nu}, {0.0, e, nu}};
    for (const Stack& layers : {one, two}) {
        for (const double r : {1e-9, 0.05, 0.1499, a, 0.1501, 0.3, 1.8}) {
            const std::string where = "r = " + std::to_string(r);
            const ElasticField field = multilayer_elastic(layers, Floor::half_space, a, q, r, 0.0);
            expect_relative(field.u_z, 2.0 * (1.0 - nu * nu) * q * a / e * half_space_deflection(a, r), 1e-10, where);
            const double inner = std::min(a, r);
            expect_relative(field.u_r, -(1.0 + nu) * (1.0 - 2.0 * nu) * q * inner * inner / (2.0 * e * r), 1e-10,
                            where);
            EXPECT_NEAR(field.sigma_zz, r < a ? -q : r > a ? 0.0 : -q / 2.0, 1e-10 * q) << where;
            EXPECT_NEAR(field.sigma_rz, 0.0, 1e-10 * q) << where;
        }
    }
}

TEST(MultilayerElastic, GivesTheSameFieldWhereverOneMaterialIsCut) {
    constexpr double a = 0.15, q = 600e3;
    const Stack one{{0.0, 80e6, 0.35}};
    const Stack three{{0.07, 80e6, 0.35}, {0.21, 80e6, 0.35}, {0.0, 80e6, 0.35}};
    for (const double z : {0.0, 0.001, 0.07, 0.12, 0.28, 0.6}) {
        for (const double r : {0.0, 0.1, a, 0.2, 1.0}) {
            const ElasticField expected = multilayer_elastic(one, Floor::half_space, a, q, r, z);
            const ElasticField field = multilayer_elastic(three, Floor::half_space, a, q, r, z);
            EXPECT_NEAR(field.u_z, expected.u_z, 1e-13) << r << ' ' << z;
            EXPECT_NEAR(field.u_r, expected.u_r, 1e-13) << r << ' ' << z;
            EXPECT_NEAR(field.sigma_rr, expected.sigma_rr, 1e-10 * q) << r << ' ' << z;
            EXPECT_NEAR(field.sigma_tt, expected.sigma_tt, 1e-10 * q) << r << ' ' << z;
            EXPECT_NEAR(field.sigma_zz, expected.sigma_zz, 1e-10 * q) << r << ' ' << z;
            EXPECT_NEAR(field.sigma_rz, expected.sigma_rz, 1e-10 * q) << r << ' ' << z;
        }
    }
}

// Burmister (1943): two incompressible layers, n = (E1 - E2) / (E1 + E2).
TEST(MultilayerElastic, ReproducesBurmistersTwoLayers) {
    constexpr double a = 0.15, q = 600e3;
    for (const double ratio : {0.1, 4.0, 100.0}) {
        for (const double h : {0.06, 0.3}) {
            const Stack layers{{h, ratio * 50e6, 0.5}, {0.0, 50e6, 0.5}};
            const double n = (ratio - 1.0) / (ratio + 1.0);
            const auto kernel = [&](double k) {
                const double t = k * h;
                const double e = std::exp(-2.0 * t);
                return (1.0 + 4.0 * n * t * e - n * n * e * e) /
                       (1.0 - 2.0 * n * (1.0 + 2.0 * t * t) * e + n * n * e * e);
            };
            for (const double r : {0.0, 0.1, a, 0.4, 1.8}) {
                const double expected = surface_deflection(layers.front(), a, q, r, 20.0 / h, kernel);
                const double u_z = multilayer_elastic(layers, Floor::half_space, a, q, r, 0.0).u_z;
                expect_relative(u_z, expected, 1e-7, std::to_string(ratio) + ' ' + std::to_string(r));
            }
        }
    }
}

// One layer stuck to a rigid floor (Vorovich, Aleksandrov and Babeshko, contact problems of the theory of elasticity):
// kernel (2 c sinh 2t - 4t) / (2 c cosh 2t + 4t^2 + 1 + c^2), c = 3 - 4 nu.
TEST(MultilayerElastic, ReproducesOneLayerStuckToARigidFloor) {
    constexpr double a = 0.15, q = 600e3, h = 0.3;
    for (const double nu : {0.0, 0.35, 0.5}) {
        const Stack layers{{h, 80e6, nu}};
        const double c = 3.0 - 4.0 * nu;
        const auto kernel = [&](double k) {
            const double t = k * h;
            return (2.0 * c * std::sinh(2.0 * t) - 4.0 * t) /
                   (2.0 * c * std::cosh(2.0 * t) + 4.0 * t * t + 1.0 + c * c);
        };
        for (const double r : {0.0, 0.1, a, 0.3, 0.6}) {
            const double expected = surface_deflection(layers.front(), a, q, r, 20.0 / h, kernel);
            const double centre = surface_deflection(layers.front(), a, q, 0.0, 20.0 / h, kernel);
            const double u_z = multilayer_elastic(layers, Floor::rigid_rough, a, q, r, 0.0).u_z;
            EXPECT_NEAR(u_z, expected, 1e-8 * centre) << nu << ' ' << r;
        }
    }
}

TEST(MultilayerElastic, SettlesLikeAnOedometerUnderAWideLoadOnARigidFloor) {
    constexpr double q = 600e3;
    const Stack layers{{0.2, 500e6, 0.3}, {0.3, 60e6, 0.4}};
    double settlement = 0.0;
    for (const ElasticLayer& layer : layers) {
        const double nu = layer.poisson;
        settlement += q * layer.thickness * (1.0 + nu) * (1.0 - 2.0 * nu) / ((1.0 - nu) * layer.modulus);
    }
    constexpr double a = 60.0; // the stiff layer spreads the edge over about 1.2 m
    const ElasticField top = multilayer_elastic(layers, Floor::rigid_rough, a, q, 0.0, 0.0);
    expect_relative(top.u_z, settlement, 1e-6, "surface");
    const ElasticField inside = multilayer_elastic(layers, Floor::rigid_rough, a, q, 1.0, 0.35);
    expect_relative(inside.sigma_zz, -q, 1e-6, "sigma_zz");
    expect_relative(inside.sigma_rr, -q * 0.4 / 0.6, 1e-6, "sigma_rr");
    EXPECT_NEAR(inside.eps_rr, 0.0, 1e-6 * q / 60e6);
}

// European Commission, AMADEUS (2000), phase 1, as tabulated by Skar, Andersen and Nielsen, ALVA (2020). Lowest and
// highest printed value of BISAR and GAMES; KENLAYER differs from them by up to 0.5 microstrain.
TEST(MultilayerElastic, ReproducesTheAmadeusSingleWheel) {
    const Stack layers{{0.26, 5000e6, 0.35}, {0.50, 200e6, 0.40}, {0.0, 50e6, 0.45}};
    constexpr double a = 0.1508, q = 0.7e6;
    const auto at = [&](double r, double z) { return multilayer_elastic(layers, Floor::half_space, a, q, r, z); };
    const auto expect_between = [](double strain, double low, double high) {
        EXPECT_GE(strain / micro, low - 0.05);
        EXPECT_LE(strain / micro, high + 0.05);
    };
    expect_between(at(0.0, 0.26 - just_above).eps_rr, 100.5, 100.5);
    expect_between(at(0.0, 0.26).eps_zz, -251.7, -251.6);
    expect_between(at(0.0, 0.76).eps_zz, -185.1, -185.0);
    expect_between(at(a, 0.26 - just_above).eps_rr, 61.9, 61.9); // radial
    expect_between(at(a, 0.26).eps_zz, -192.2, -192.2);
    expect_between(at(a, 0.76).eps_zz, -177.5, -177.5);
}

TEST(MultilayerElastic, ReproducesTheAmadeusDualWheel) {
    const Stack layers{{0.26, 5000e6, 0.35}, {0.50, 200e6, 0.40}, {0.0, 50e6, 0.45}};
    const auto at = [&](double r, double z) {
        return multilayer_elastic(layers, Floor::half_space, 0.1066, 0.7e6, r, z);
    };
    // Both wheels and the points lie on the x axis: the strain along y is tangential to both circles.
    const auto along_y = [&](double r1, double r2, double z) { return at(r1, z).eps_tt + at(r2, z).eps_tt; };
    const auto vertical = [&](double r1, double r2, double z) { return at(r1, z).eps_zz + at(r2, z).eps_zz; };
    EXPECT_NEAR(along_y(0.0, 0.34, 0.26 - just_above) / micro, 85.0, 0.5);
    EXPECT_NEAR(vertical(0.0, 0.34, 0.26) / micro, -186.0, 0.5);
    EXPECT_NEAR(vertical(0.0, 0.34, 0.76) / micro, -170.0, 0.5);
    EXPECT_NEAR(along_y(0.17, 0.17, 0.26 - just_above) / micro, 89.0, 0.5);
    EXPECT_NEAR(vertical(0.17, 0.17, 0.26) / micro, -183.0, 0.5);
    EXPECT_NEAR(vertical(0.17, 0.17, 0.76) / micro, -177.0, 0.5);
}

// Out to 300 depths. On a half-space sigma_zz falls off with r^-5 only.
double vertical_force(Floor floor, double z) {
    const auto ring = [&](double r) {
        return 2.0 * pi * r * multilayer_elastic(tank, floor, tank_radius, tank_pressure, r, z).sigma_zz;
    };
    const double near = integral(0.0, 0.5, 200, ring);
    return near + integral(std::log(0.5), std::log(std::max(15.0, 300.0 * z)), 200,
                           [&](double s) { return std::exp(s) * ring(std::exp(s)); });
}

TEST(MultilayerElastic, CarriesTheWholeLoadOnEveryHorizontalPlane) {
    const double load = tank_pressure * pi * tank_radius * tank_radius;
    for (const double z : {0.02, 0.03, 0.2, 0.5, 1.0}) {
        expect_relative(vertical_force(Floor::rigid_rough, z), -load, 1e-4, "rigid, z = " + std::to_string(z));
        expect_relative(vertical_force(Floor::half_space, z), -load, 1e-4, "half-space, z = " + std::to_string(z));
    }
    expect_relative(vertical_force(Floor::rigid_rough, 1.5), -load, 1e-4, "floor");
}

TEST(MultilayerElastic, DoesNotMoveOnARigidFloor) {
    for (const double r : {0.0, 0.1, tank_radius, 0.6, 1.8}) {
        const ElasticField field = in_tank(r, 1.5);
        EXPECT_EQ(field.u_z, 0.0);
        EXPECT_EQ(field.u_r, 0.0);
        const double above = in_tank(r, 1.5 - 1e-6).u_z; // u_z falls to zero with the slope eps_zz
        EXPECT_NEAR(above, -1e-6 * field.eps_zz, 1e-14);
        EXPECT_NE(field.sigma_zz, 0.0);
    }
}

TEST(MultilayerElastic, IsContinuousAcrossBondedInterfaces) {
    for (const Floor floor : {Floor::half_space, Floor::rigid_rough}) {
        for (const double interface : {0.030, 0.307}) {
            for (const double r : {0.0, 0.1, tank_radius, 0.6, 1.8}) {
                const auto at = [&](double z) {
                    return multilayer_elastic(tank, floor, tank_radius, tank_pressure, r, z);
                };
                const ElasticField above = at(interface - just_above);
                const ElasticField below = at(interface);
                EXPECT_NEAR(above.u_z, below.u_z, 1e-11);
                EXPECT_NEAR(above.u_r, below.u_r, 1e-11);
                EXPECT_NEAR(above.sigma_zz, below.sigma_zz, 1e-7 * tank_pressure);
                EXPECT_NEAR(above.sigma_rz, below.sigma_rz, 1e-7 * tank_pressure);
                EXPECT_NEAR(above.eps_rr, below.eps_rr, 1e-10);
                EXPECT_NEAR(above.eps_tt, below.eps_tt, 1e-10);
            }
        }
    }
}

TEST(MultilayerElastic, GivesADepthOnAnInterfaceToTheLayerBelow) {
    for (const double interface : {0.030, 0.030 + 0.277, 0.307}) {
        const ElasticField above = in_tank(0.0, interface - just_above);
        const ElasticField on = in_tank(0.0, interface);
        const ElasticField below = in_tank(0.0, interface + just_above);
        EXPECT_NEAR(on.sigma_rr, below.sigma_rr, 1e-6 * tank_pressure);
        EXPECT_GT(std::abs(on.sigma_rr - above.sigma_rr), 0.1 * tank_pressure);
    }
}

TEST(MultilayerElastic, HasStrainsThatAreTheDerivativesOfItsDisplacements) {
    constexpr double step = 1e-4;
    for (const double z : {0.012, 0.025, 0.1, 0.25, 0.35, 1.2}) {
        for (const double r : {0.02, 0.12, tank_radius, 0.3, 0.9}) {
            const ElasticField field = in_tank(r, z);
            const ElasticField in = in_tank(r - step, z);
            const ElasticField out = in_tank(r + step, z);
            const ElasticField up = in_tank(r, z - step);
            const ElasticField down = in_tank(r, z + step);
            const auto slope = [](double before, double after) { return (after - before) / (2.0 * step); };
            const ElasticLayer& layer = tank[z < 0.03 ? 0 : z < 0.307 ? 1 : 2];
            const double shear = layer.modulus / (2.0 * (1.0 + layer.poisson));
            const std::string where = "r = " + std::to_string(r) + ", z = " + std::to_string(z);
            EXPECT_NEAR(slope(in.u_r, out.u_r), field.eps_rr, 0.02 * micro) << where;
            EXPECT_NEAR(field.u_r / r, field.eps_tt, 1e-9 * micro) << where;
            EXPECT_NEAR(slope(up.u_z, down.u_z), field.eps_zz, 0.02 * micro) << where;
            EXPECT_NEAR(slope(up.u_r, down.u_r) + slope(in.u_z, out.u_z), field.sigma_rz / shear, 0.02 * micro)
                << where;
            // Equilibrium; stresses of order 1e6 Pa change over lengths of order 0.1 m.
            EXPECT_NEAR(slope(in.sigma_rr, out.sigma_rr) + (field.sigma_rr - field.sigma_tt) / r +
                            slope(up.sigma_rz, down.sigma_rz),
                        0.0, 2e3)
                << where;
            EXPECT_NEAR(slope(in.sigma_rz, out.sigma_rz) + field.sigma_rz / r + slope(up.sigma_zz, down.sigma_zz), 0.0,
                        2e3)
                << where;
            // Hooke's law.
            EXPECT_NEAR(field.eps_zz,
                        (field.sigma_zz - layer.poisson * (field.sigma_rr + field.sigma_tt)) / layer.modulus, 1e-15);
            EXPECT_NEAR(field.eps_rr,
                        (field.sigma_rr - layer.poisson * (field.sigma_tt + field.sigma_zz)) / layer.modulus, 1e-15);
            EXPECT_NEAR(field.eps_tt,
                        (field.sigma_tt - layer.poisson * (field.sigma_rr + field.sigma_zz)) / layer.modulus, 1e-15);
        }
    }
}

TEST(MultilayerElastic, IsSmoothTowardsTheSurfaceAndTheAxis) {
    for (const double r : {0.0, 0.1, 0.2, 0.6, 1.8}) {
        const ElasticField on = in_tank(r, 0.0);
        const ElasticField below = in_tank(r, 1e-9);
        EXPECT_NEAR(on.u_z, below.u_z, 1e-11);
        EXPECT_NEAR(on.eps_rr, below.eps_rr, 1e-10);
        EXPECT_NEAR(on.eps_tt, below.eps_tt, 1e-10);
        EXPECT_NEAR(on.eps_zz, below.eps_zz, 1e-10);
        EXPECT_NEAR(on.sigma_zz, r < tank_radius ? -tank_pressure : 0.0, 1e-10 * tank_pressure);
        EXPECT_NEAR(on.sigma_rz, 0.0, 1e-10 * tank_pressure);
    }
    EXPECT_NEAR(in_tank(tank_radius, 0.0).u_z, in_tank(tank_radius, 1e-9).u_z, 1e-11);
    for (const double z : {0.0, 0.01, 0.1, 1.0}) {
        const ElasticField on = in_tank(0.0, z);
        const ElasticField beside = in_tank(1e-8, z);
        EXPECT_NEAR(on.u_z, beside.u_z, 1e-14);
        EXPECT_NEAR(on.eps_rr, beside.eps_rr, 1e-12);
        EXPECT_NEAR(on.eps_tt, beside.eps_tt, 1e-12);
        EXPECT_NEAR(on.eps_zz, beside.eps_zz, 1e-12);
    }
}

// Betti: circles a and b of the same pressure, the deflection of one integrated over the other.
TEST(MultilayerElastic, ObeysTheReciprocalTheorem) {
    const auto volume = [](double load_radius, double over) {
        return integral(0.0, over, 200, [&](double r) {
            return 2.0 * pi * r * multilayer_elastic(tank, Floor::rigid_rough, load_radius, tank_pressure, r, 0.0).u_z;
        });
    };
    expect_relative(volume(0.1, 0.4), volume(0.4, 0.1), 1e-5, "volume");
}

TEST(MultilayerElastic, ApproachesTheHalfSpaceWithARigidFloorFarDown) {
    const auto at = [](Floor floor, double depth, double r, double z) {
        Stack layers = tank;
        layers.back().thickness = depth;
        return multilayer_elastic(layers, floor, tank_radius, tank_pressure, r, z);
    };
    for (const double r : {0.0, tank_radius, 0.6}) {
        for (const double z : {0.0, 0.1, 0.4}) {
            const ElasticField endless = at(Floor::half_space, 0.0, r, z);
            const ElasticField far = at(Floor::rigid_rough, 100.0, r, z);
            const ElasticField farther = at(Floor::rigid_rough, 1000.0, r, z);
            // A floor at depth H holds back displacements of about P / (E H), so strains of about P / (E H^2), here
            // 1e-3 microstrain.
            EXPECT_LT(far.u_z, farther.u_z);
            EXPECT_LT(farther.u_z, endless.u_z);
            expect_relative(endless.u_z - far.u_z, 10.0 * (endless.u_z - farther.u_z), 0.01, "u_z");
            expect_relative(farther.u_z, endless.u_z, 1e-3, "u_z");
            EXPECT_NEAR(farther.eps_rr, endless.eps_rr, 1e-3 * micro);
            EXPECT_NEAR(farther.eps_zz, endless.eps_zz, 1e-3 * micro);
            EXPECT_NEAR(farther.sigma_zz, endless.sigma_zz, 1e-6 * tank_pressure);
        }
    }
}

TEST(MultilayerElastic, IsProportionalToThePressure) {
    const ElasticField one = in_tank(0.1, 0.2);
    const ElasticField two = multilayer_elastic(tank, Floor::rigid_rough, tank_radius, -2.0 * tank_pressure, 0.1, 0.2);
    EXPECT_DOUBLE_EQ(two.u_z, -2.0 * one.u_z);
    EXPECT_DOUBLE_EQ(two.eps_zz, -2.0 * one.eps_zz);
    EXPECT_DOUBLE_EQ(two.sigma_rr, -2.0 * one.sigma_rr);
}

TEST(MultilayerElastic, RejectsWhatCannotBe) {
    const auto attempt = [](const Stack& layers, double radius, double r, double z) {
        return multilayer_elastic(layers, Floor::rigid_rough, radius, 1e5, r, z);
    };
    EXPECT_THROW(attempt({}, 0.15, 0.0, 0.0), std::invalid_argument);
    EXPECT_THROW(attempt({{0.0, 1e8, 0.3}}, 0.15, 0.0, 0.0), std::invalid_argument);
    EXPECT_THROW(attempt({{0.3, 0.0, 0.3}}, 0.15, 0.0, 0.0), std::invalid_argument);
    EXPECT_THROW(attempt({{0.3, 1e8, 0.6}}, 0.15, 0.0, 0.0), std::invalid_argument);
    EXPECT_THROW(attempt({{0.3, 1e8, 0.3}}, 0.0, 0.0, 0.0), std::invalid_argument);
    EXPECT_THROW(attempt({{0.3, 1e8, 0.3}}, 0.15, -0.1, 0.0), std::invalid_argument);
    EXPECT_THROW(attempt({{0.3, 1e8, 0.3}}, 0.15, 0.0, -0.1), std::invalid_argument);
    EXPECT_THROW(attempt({{0.3, 1e8, 0.3}}, 0.15, 0.0, 0.31), std::invalid_argument);
    EXPECT_THROW(attempt({{0.3, 1e8, 0.3}}, 0.15, std::numeric_limits<double>::quiet_NaN(), 0.0),
                 std::invalid_argument);
}

} // namespace
} // namespace pave::reference
