// The layered engine against closed forms, against an independent program for isotropic layers, against another
// derivation for anisotropic ones, and against itself where laws bind it: equilibrium, reciprocity, limits.
#include "layered/response.h"

#include "base/gauss_legendre.h"
#include "base/random.h"
#include "mechanics/cross_anisotropic.h"
#include "reference/multilayer_elastic.h"

#include <gtest/gtest.h>

#include <complex>

namespace pave::layered {
namespace {

using std::numbers::pi;

constexpr double radius = 0.15; // m

mechanics::Stiffness<6> isotropic(double modulus, double nu) {
    return modulus * mechanics::CrossAnisotropy::isotropic(nu).unit_stiffness();
}

// E3 = 150 MPa unless given.
mechanics::CrossAnisotropy anisotropy(double n) {
    return {.n = n, .nu12 = 0.3, .nu31 = 0.25, .shear_ratio = 0.35, .modulus_is_vertical = true};
}

Circles one_circle(double shape = 0.0) {
    return {{{0.0, 0.0, radius}}, shape};
}

// Of 1 Pa at points (x, y, z).
std::vector<Field> respond(const Section& section, const Circles& circles,
                           const std::vector<std::array<double, 3>>& at) {
    std::vector<Place> places;
    std::vector<Point> points;
    std::vector<double> depths;
    for (const auto& [x, y, z] : at) {
        places.push_back({x, y, true});
        points.push_back({places.size() - 1, z});
        depths.push_back(z);
    }
    Weights weights(circles, places);
    return Transform(section, {}, depths).fields(weights, points);
}
Field respond(const Section& section, const Circles& circles, double x, double y, double z) {
    return respond(section, circles, {{x, y, z}}).front();
}

std::array<double, 7> numbers(const Field& f) {
    return {f.uz, f.strain_xx, f.strain_yy, f.strain_zz, f.stress_xx, f.stress_yy, f.stress_zz};
}

Section four_layers(bool half_space) {
    return {{{isotropic(3e9, 0.35), 0.12},
             {150e6 * anisotropy(0.4).unit_stiffness(), 0.25, 2e-10},
             {isotropic(120e6, 0.4), 0.3},
             {isotropic(60e6, 0.45), 2.0}},
            half_space};
}

TEST(LayeredResponse, AgreesWithAnIndependentProgramOnRandomIsotropicSections) {
    const RandomStream random(11, 0);
    std::uint64_t draw = 0;
    const auto between = [&](double low, double high) { return low + (high - low) * random.uniform(draw++); };
    const double distances[] = {0.0, radius, 0.2, 1.5};
    for (int section_number = 0; section_number < 8; ++section_number) {
        Section section{{}, section_number % 2 == 0};
        std::vector<reference::ElasticLayer> layers;
        std::vector<double> depths{0.0, 0.02};
        double bottom = 0.0;
        for (int l = 0; l <= section_number % 5; ++l) {
            const double thickness = std::exp(between(std::log(0.02), std::log(2.0)));
            const double modulus = std::exp(between(std::log(10e6), std::log(30e9)));
            const double nu = between(0.0, 0.4999);
            section.layers.push_back({isotropic(modulus, nu), thickness});
            layers.push_back({thickness, modulus, nu});
            depths.push_back(bottom + 0.6 * thickness);
            bottom += thickness;
            depths.push_back(bottom);
        }
        std::vector<std::array<double, 3>> at;
        for (const double z : depths) {
            for (const double r : distances) {
                at.push_back({r, 0.0, z});
            }
        }
        const auto found = respond(section, one_circle(), at);
        std::size_t i = 0;
        for (const double z : depths) {
            std::array<double, 7> largest{};
            std::array<double, 7> worst{};
            for (const double r : distances) {
                const auto f = reference::multilayer_elastic(
                    layers, section.half_space ? reference::Floor::half_space : reference::Floor::rigid_rough, radius,
                    1.0, r, z);
                const std::array<double, 7> expected{f.u_z,      f.eps_rr,   f.eps_tt,  f.eps_zz,
                                                     f.sigma_rr, f.sigma_tt, f.sigma_zz};
                const auto own = numbers(found[i++]);
                for (std::size_t k = 0; k < 7; ++k) {
                    largest[k] = std::max(largest[k], std::abs(expected[k]));
                    worst[k] = std::max(worst[k], std::abs(own[k] - expected[k]));
                }
            }
            for (std::size_t k = 0; k < 7; ++k) {
                EXPECT_LE(worst[k], 1e-7 * largest[k] + 1e-22) << section_number << " z = " << z << " number " << k;
            }
        }
    }
}

// J. Boussinesq, integrated over the circle: S. Timoshenko and J. N. Goodier, Theory of Elasticity.
TEST(LayeredResponse, IsBoussinesqsOnTheAxisOfAHalfSpace) {
    constexpr double e = 80e6, nu = 0.35;
    const Section one{{{isotropic(e, nu), 0.0}}, true};
    const Section same{{{isotropic(e, nu), 0.03}, {isotropic(e, nu), 0.4}, {isotropic(e, nu), 0.0}}, true};
    for (const Section& section : {one, same}) {
        for (const double z : {0.0, 1e-9, 1e-4, 0.01, 0.1, 0.5, 4.0}) {
            const double d = std::hypot(radius, z);
            const double sz = -(1.0 - std::pow(z / d, 3));
            const double sr = -0.5 * (1.0 + 2.0 * nu - 2.0 * (1.0 + nu) * z / d + std::pow(z / d, 3));
            const double uz = (1.0 + nu) / e * (radius * radius / d + (1.0 - 2.0 * nu) * radius * radius / (d + z));
            const Field f = respond(section, one_circle(), 0.0, 0.0, z);
            EXPECT_NEAR(f.uz, uz, 1e-8 * uz) << z;
            EXPECT_NEAR(f.stress_zz, sz, 1e-8) << z;
            EXPECT_NEAR(f.stress_xx, sr, 1e-8) << z;
            EXPECT_NEAR(f.stress_yy, sr, 1e-8) << z;
            EXPECT_NEAR(f.strain_zz, (sz - 2.0 * nu * sr) / e, 1e-8 / e) << z;
        }
    }
}

// D. M. Burmister (1945): the surface deflection of two layers with Poisson's ratio 1/2 is 1.5 p a/E2 F, with F the
// integral of his kernel; 0.499999 stands for 1/2 here.
TEST(LayeredResponse, IsBurmistersForTwoLayers) {
    constexpr double e1 = 1000e6, e2 = 50e6, h = 0.2;
    const Section section{{{isotropic(e1, 0.499999), h}, {isotropic(e2, 0.499999), 0.0}}, true};
    const double n = (e1 - e2) / (e1 + e2);
    const auto rule = gauss_legendre(40);
    double integral = 0.0;
    for (int piece = 0; piece < 40; ++piece) {
        for (const auto& [x, weight] : rule) {
            const double m = (piece + 0.5 + 0.5 * x) * 1.5; // k h
            const double e = std::exp(-2.0 * m);
            const double kernel =
                (1.0 + 4.0 * n * m * e - n * n * e * e) / (1.0 - 2.0 * n * (1.0 + 2.0 * m * m) * e + n * n * e * e);
            integral += 0.75 * weight * (kernel - 1.0) * std::cyl_bessel_j(1.0, m * radius / h) / m;
        }
    }
    const double deflection = 1.5 * radius / e1 * (1.0 + integral);
    EXPECT_NEAR(respond(section, one_circle(), 0.0, 0.0, 0.0).uz, deflection, 1e-5 * deflection);
}

// By the eigenvectors of the equations of equilibrium, with complex eigenvalues: another way than the engine's.
TEST(LayeredResponse, AnisotropicHalfSpaceHasTheComplianceOfItsEigenvectors) {
    for (const double n : {0.15, 0.5, 1.3, 3.0}) { // pairs of complex and of real eigenvalues
        const mechanics::Stiffness<6> c = 150e6 * anisotropy(n).unit_stiffness();
        using Complex = std::complex<double>;
        const double c11 = c(0, 0), c13 = c(0, 2), c33 = c(2, 2), c44 = c(3, 3);
        const Complex b = (c11 * c33 - c13 * c13 - 2.0 * c13 * c44) / (2.0 * c33 * c44);
        const Complex root = std::sqrt(b * b - c11 / c33);
        const Complex l[2] = {std::sqrt(b + root), std::sqrt(b - root)};
        Complex t[2], s[2], w[2];
        for (int i = 0; i < 2; ++i) { // U = 1; from the equilibrium of horizontal forces
            w[i] = (c44 * l[i] * l[i] - c11) / (l[i] * (c13 + c44)) * -1.0;
            t[i] = c44 * (-l[i] - w[i]);
            s[i] = c13 - c33 * l[i] * w[i];
        }
        const Complex compliance = (w[1] * t[0] - w[0] * t[1]) / (s[1] * t[0] - s[0] * t[1]);
        const Section section{{{c, 0.0}}, true};
        const double uz = respond(section, one_circle(), 0.0, 0.0, 0.0).uz; // the integral of J1(x)/x is 1
        EXPECT_NEAR(uz, -compliance.real() * radius, 1e-11 * uz) << n;
        EXPECT_NEAR(compliance.imag(), 0.0, 1e-10 * std::abs(compliance));
    }
}

TEST(LayeredResponse, PassesSmoothlyThroughIsotropy) {
    const auto section = [](double n) {
        const mechanics::CrossAnisotropy c{.n = n, .nu12 = 0.3, .nu31 = 0.3, .shear_ratio = {}};
        return Section{{{200e6 * c.unit_stiffness(), 0.3}, {isotropic(60e6, 0.4), 0.0}}, true};
    };
    for (const double z : {0.0, 0.15}) {
        const auto at = numbers(respond(section(1.0), one_circle(), 0.1, 0.0, z));
        const auto above = numbers(respond(section(1.0 + 1e-7), one_circle(), 0.1, 0.0, z));
        const auto below = numbers(respond(section(1.0 - 1e-7), one_circle(), 0.1, 0.0, z));
        for (std::size_t i = 0; i < at.size(); ++i) {
            EXPECT_NEAR(above[i], at[i], 1e-6 * std::abs(at[i])) << i;
            EXPECT_NEAR(above[i] + below[i], 2.0 * at[i], 1e-10 * std::abs(at[i])) << i;
        }
    }
}

// On any plane the vertical stress carries the load.
TEST(LayeredResponse, EveryPlaneCarriesTheLoad) {
    for (const bool half_space : {true, false}) {
        const Section section = four_layers(half_space);
        const auto rule = gauss_legendre(16);
        for (const double z : {0.06, 0.12, 0.5}) {
            std::vector<std::array<double, 3>> at;
            std::vector<double> weights;
            double from = 0.0;
            for (double to = 0.1; to < 100.0; from = to, to *= 1.7) {
                for (const auto& [x, weight] : rule) {
                    const double r = from + (to - from) / 2.0 * (1.0 + x);
                    at.push_back({r, 0.0, z});
                    weights.push_back(weight * (to - from) * pi * r);
                }
            }
            const auto found = respond(section, one_circle(), at);
            double force = 0.0;
            for (std::size_t i = 0; i < found.size(); ++i) {
                force -= weights[i] * found[i].stress_zz;
            }
            EXPECT_NEAR(force, pi * radius * radius, 2e-5 * pi * radius * radius)
                << z; // to 100 m, where rounding is 1e-9
        }
    }
}

// E. Betti: the work of one load on the displacements of another. Of small circles: the deflection at the other.
TEST(LayeredResponse, CirclesAreReciprocal) {
    const Section section = four_layers(true);
    const auto work = [&](const Circle& loaded, const Circle& read) { // over the circle that is read
        std::vector<std::array<double, 3>> at;
        std::vector<double> weights;
        for (const auto& [x, weight] : gauss_legendre(12)) {
            const double r = read.radius * (1.0 + x) / 2.0;
            for (int i = 0; i < 24; ++i) {
                const double angle = 2.0 * pi * i / 24;
                at.push_back({read.x + r * std::cos(angle), read.y + r * std::sin(angle), 0.0});
                weights.push_back(weight * read.radius / 2.0 * r * 2.0 * pi / 24);
            }
        }
        const auto found = respond(section, {{loaded}, 0.0}, at);
        double sum = 0.0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            sum += weights[i] * found[i].uz;
        }
        return sum;
    };
    const Circle small{0.1, 0.2, 0.05};
    const Circle large{0.7, -0.1, 0.2};
    const double one = work(small, large);
    EXPECT_NEAR(work(large, small), one, 1e-8 * one);
}

TEST(LayeredResponse, CirclesAddUpAndTurn) {
    const Section section = four_layers(false);
    const Circles pair{{{0.3, 0.1, radius}, {-0.4, 0.0, 0.1}}, 0.2};
    for (const double z : {0.0, 0.05, 0.4}) {
        const auto both = numbers(respond(section, pair, 0.2, 0.6, z));
        const auto first = numbers(respond(section, {{pair.circles[0]}, 0.2}, 0.2, 0.6, z));
        const auto second = numbers(respond(section, {{pair.circles[1]}, 0.2}, 0.2, 0.6, z));
        for (std::size_t i = 0; i < both.size(); ++i) {
            EXPECT_NEAR(both[i], first[i] + second[i], 1e-9 * std::abs(both[i])) << i;
        }
        // A quarter turn changes x and y; an eighth mixes them with the shear, but their sum stays.
        const Field there = respond(section, one_circle(), 0.25, 0.0, z);
        const Field turned = respond(section, one_circle(), 0.0, 0.25, z);
        EXPECT_NEAR(turned.strain_yy, there.strain_xx, 1e-12 * std::abs(there.strain_xx));
        EXPECT_NEAR(turned.stress_xx, there.stress_yy, 1e-12 * std::abs(there.stress_yy));
        const Field eighth = respond(section, one_circle(), 0.25 * std::sqrt(0.5), 0.25 * std::sqrt(0.5), z);
        EXPECT_NEAR(eighth.strain_xx, (there.strain_xx + there.strain_yy) / 2.0, 1e-12 * std::abs(there.strain_xx));
        EXPECT_NEAR(eighth.stress_yy, (there.stress_xx + there.stress_yy) / 2.0, 1e-12 * std::abs(there.stress_yy));
    }
}

// A pressure p(r) is p(a) on the whole circle less the integral of p' over the circles within: p' = 4 s r/a^2.
TEST(LayeredResponse, AShapedPressureIsASumOfUniformCircles) {
    const Section section = four_layers(true);
    constexpr double shape = 0.6;
    for (const auto& [r, z] : {std::pair{0.05, 0.0}, {0.4, 0.0}, {1.5, 0.0}, {0.1, 0.08}, {0.3, 0.3}}) {
        const auto shaped = numbers(respond(section, one_circle(shape), r, 0.0, z));
        auto sum = numbers(respond(section, one_circle(), r, 0.0, z));
        for (double& number : sum) {
            number *= 1.0 + shape;
        }
        const double edge = z == 0.0 && r < radius ? r : radius / 2.0; // where the integrand may jump
        for (const auto& [from, to] : {std::pair{0.0, edge}, {edge, radius}}) {
            for (const auto& [x, weight] : gauss_legendre(30)) {
                const double t = from + (to - from) / 2.0 * (1.0 + x);
                const auto one = numbers(respond(section, {{{0.0, 0.0, t}}, 0.0}, r, 0.0, z));
                for (std::size_t i = 0; i < sum.size(); ++i) {
                    sum[i] -= weight * (to - from) / 2.0 * 4.0 * shape * t / (radius * radius) * one[i];
                }
            }
        }
        const double tolerance = z == 0.0 && r < radius ? 1e-4 : 1e-8; // the deflection has a kink there
        for (std::size_t i = 0; i < sum.size(); ++i) {
            EXPECT_NEAR(shaped[i], sum[i], tolerance * std::abs(sum[i]) + 1e-9 * (i > 3 ? 1.0 : 1e-9))
                << r << " " << z << " " << i;
        }
    }
}

TEST(LayeredResponse, AnInterfaceThatSlidesFreelyIsTheLimitOfASoftOne) {
    Section section = four_layers(true);
    const auto with = [&](double compliance) {
        section.layers[1].compliance = compliance;
        return numbers(respond(section, one_circle(), 0.1, 0.0, 0.36));
    };
    const auto bonded = with(0.0);
    const auto stiff = with(1e-20);
    const auto soft = with(1.0);
    const auto free = with(1e6);
    for (std::size_t i = 0; i < bonded.size(); ++i) {
        EXPECT_NEAR(stiff[i], bonded[i], 1e-8 * std::abs(bonded[i])) << i;
        EXPECT_NEAR(soft[i], free[i], 1e-6 * std::abs(free[i])) << i;
    }
    EXPECT_GT(std::abs(free[1]), 1.05 * std::abs(bonded[1]));
}

TEST(LayeredResponse, IsContinuousInTheThicknessOfALayerThatVanishesOrHidesTheRest) {
    const Layer stiff{isotropic(1e9, 0.3), 0.0};
    const Layer soft{isotropic(50e6, 0.4), 0.0};
    const auto two = [&](double thickness) {
        Section section{{stiff, soft}, true};
        section.layers[0].thickness = thickness;
        return respond(section, one_circle(), 0.1, 0.0, 0.0).uz;
    };
    const double without = respond({{soft}, true}, one_circle(), 0.1, 0.0, 0.0).uz;
    const double alone = respond({{stiff}, true}, one_circle(), 0.1, 0.0, 0.0).uz;
    EXPECT_NEAR(two(1e-6), without, 1e-4 * without);
    EXPECT_NEAR(two(1e-4), without, 1e-2 * without);
    EXPECT_NEAR(two(1e5), alone, 1e-4 * alone);
    // A floor far below is none; a soft layer of contrast 10,000 on a half-space is a floor.
    const Section deep{{{isotropic(50e6, 0.4), 1e5}}, false};
    EXPECT_NEAR(respond(deep, one_circle(), 0.1, 0.0, 0.0).uz, without, 1e-5 * without);
    const Section on_rock{{{isotropic(50e6, 0.4), 2.0}, {isotropic(5e13, 0.3), 0.0}}, true};
    const Section on_floor{{{isotropic(50e6, 0.4), 2.0}}, false};
    const double floor = respond(on_floor, one_circle(), 0.1, 0.0, 0.0).uz;
    EXPECT_NEAR(respond(on_rock, one_circle(), 0.1, 0.0, 0.0).uz, floor, 1e-5 * floor);
}

TEST(LayeredResponse, DerivativesAreThoseOfDifferences) {
    for (const bool half_space : {true, false}) {
        const Section section = four_layers(half_space);
        const std::size_t last = section.layers.size() - 1;
        std::vector<std::vector<Layer>> directions;
        std::vector<double> sizes; // of a step
        const auto add = [&](std::size_t layer, const Layer& rate, double size) {
            directions.emplace_back(section.layers.size(), Layer{.stiffness = mechanics::Stiffness<6>::Zero()});
            directions.back()[layer] = rate;
            sizes.push_back(size);
        };
        for (std::size_t l = 0; l <= last; ++l) {
            add(l, {.stiffness = section.layers[l].stiffness}, 1e-3);
            if (l < last || !half_space) {
                add(l, {.stiffness = mechanics::Stiffness<6>::Zero(), .thickness = 1.0},
                    1e-3 * section.layers[l].thickness);
            }
        }
        add(1,
            {.stiffness = 150e6 * anisotropy(0.4).unit_stiffness_derivative(mechanics::CrossAnisotropy::Variable::n)},
            1e-3);
        add(2, {.stiffness = 120e6 * mechanics::CrossAnisotropy::isotropic_derivative(0.4)}, 1e-5);
        add(1, {.stiffness = mechanics::Stiffness<6>::Zero(), .compliance = 1.0}, 1e-12);
        std::vector<Place> places{{0.0, 0.0, true}, {0.5, 0.2, true}};
        std::vector<Point> points;
        std::vector<double> depths;
        for (const double z : {0.0, 0.05, 0.2, 0.5, 1.0}) {
            points.push_back({0, z});
            points.push_back({1, z});
            depths.push_back(z);
        }
        Weights weights(one_circle(), places);
        const Transform transform(section, directions, depths);
        const auto values = transform.fields(weights, points);
        for (std::size_t d = 0; d < directions.size(); ++d) {
            const auto exact = transform.rates(weights, points, d);
            std::vector<std::array<double, 7>> quotient(points.size());
            for (const auto& [offset, weight] :
                 {std::pair{-2, 1.0 / 12}, {-1, -8.0 / 12}, {1, 8.0 / 12}, {2, -1.0 / 12}}) {
                Section moved = section;
                for (std::size_t l = 0; l <= last; ++l) {
                    moved.layers[l].stiffness += offset * sizes[d] * directions[d][l].stiffness;
                    moved.layers[l].thickness += offset * sizes[d] * directions[d][l].thickness;
                    moved.layers[l].compliance += offset * sizes[d] * directions[d][l].compliance;
                }
                const auto there = Transform(moved, {}, depths).fields(weights, points);
                for (std::size_t i = 0; i < points.size(); ++i) {
                    for (std::size_t k = 0; k < 7; ++k) {
                        quotient[i][k] += weight * numbers(there[i])[k] / sizes[d];
                    }
                }
            }
            for (std::size_t k = 0; k < 7; ++k) {
                double largest = 0.0;
                double worst = 0.0;
                double scale = 0.0;
                for (std::size_t i = 0; i < points.size(); ++i) {
                    largest = std::max(largest, std::abs(quotient[i][k]));
                    worst = std::max(worst, std::abs(quotient[i][k] - numbers(exact[i])[k]));
                    scale = std::max(scale, std::abs(numbers(values[i])[k]));
                }
                EXPECT_LE(worst, 1e-6 * largest + 1e-11 * scale / sizes[d]) << "direction " << d << " number " << k;
            }
        }
    }
}

} // namespace
} // namespace pave::layered
