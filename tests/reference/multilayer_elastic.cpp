#include "multilayer_elastic.h"

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

// With J0, J1 of k r and the shear modulus G of the first layer,
//   u_r = U J1 / (2 G k), u_z = W J0 / (2 G k), sigma_rz = T J1, sigma_zz = S J0, y = (U, W, T, S)
// Hooke's law and equilibrium become dy/dz = k M y, M constant in a layer. M has the double eigenvalues 1 and -1.
namespace pave::reference {
namespace {

using Matrix2 = Eigen::Matrix2d;
using Matrix4 = Eigen::Matrix4d;
using Vector2 = Eigen::Vector2d;
using Vector4 = Eigen::Vector4d;
using std::numbers::pi;

constexpr double same_depth = 1e-12;

struct GaussPoint {
    double x; // in (-1, 1)
    double weight;
};

// Gauss-Legendre rule of 16 points: Newton's method on the Legendre polynomial.
const std::array<GaussPoint, 16>& gauss_rule() {
    static const auto rule = [] {
        constexpr unsigned n = 16;
        std::array<GaussPoint, n> points{};
        for (unsigned i = 0; i < n; ++i) {
            double x = std::cos(pi * (i + 0.75) / (n + 0.5));
            double slope = 0.0;
            for (int step = 0; step < 10; ++step) {
                slope = n * (std::legendre(n - 1, x) - x * std::legendre(n, x)) / (1.0 - x * x);
                x -= std::legendre(n, x) / slope;
            }
            points[i] = {x, 2.0 / ((1.0 - x * x) * slope * slope)};
        }
        return points;
    }();
    return rule;
}

template <class Function>
void gauss(double from, double to, Function&& add) {
    const double half = (to - from) / 2.0;
    for (const GaussPoint& point : gauss_rule()) {
        add(from + half * (1.0 + point.x), half * point.weight);
    }
}

double shear_modulus(const ElasticLayer& layer) {
    return layer.modulus / (2.0 * (1.0 + layer.poisson));
}

// The integrals that every component follows from, by Hooke's law and u_r = r eps_tt. Stresses are in units of
// pressure radius, the others of pressure radius / (2 G).
struct Sums {
    double u_z = 0.0;
    double eps_rr_plus_tt = 0.0;
    double eps_tt = 0.0;
    double sigma_zz = 0.0;
    double sigma_rz = 0.0;
};

// One layer, or the part of a layer above or below the depth asked for.
class Slab {
public:
    // g: shear modulus of the first layer over that of this one
    Slab(double slab_thickness, double g, double nu) : thickness(slab_thickness) {
        const double side = nu / (1.0 - nu);
        m_ << 0.0, 1.0, 2.0 * g, 0.0, -side, 0.0, 0.0, (1.0 - 2.0 * nu) / (1.0 - nu) * g, 1.0 / ((1.0 - nu) * g), 0.0,
            0.0, side, 0.0, 0.0, -1.0, 0.0;
        n_ = m_ * m_ - Matrix4::Identity();
        mn_ = m_ * n_;
    }

    // exp(-k h M) exp(-k h): the state at the top from the state at the bottom, without the growth exp(k h).
    // As (M^2 - 1)^2 = 0, exp(-t M) = cosh t + (t sinh t)/2 N - M (sinh t + (t cosh t - sinh t)/2 N), N = M^2 - 1.
    Matrix4 upwards(double t) const {
        const double sinh = -std::expm1(-2.0 * t) / 2.0;
        const double cosh = 1.0 - sinh;
        return cosh * Matrix4::Identity() + (t * sinh / 2.0) * n_ - sinh * m_ - ((t * cosh - sinh) / 2.0) * mn_;
    }

    double thickness;

private:
    Matrix4 m_, n_, mn_;
};

// (T, S) = K (U, W) at the top of a half-space.
Matrix2 half_space_stiffness(double g, double nu) {
    const double c = 1.0 / (3.0 - 4.0 * nu);
    Matrix2 k;
    k << -1.0 + (1.0 - 2.0 * nu) * c, -(1.0 - 2.0 * nu) * c, -1.0 + (2.0 - 2.0 * nu) * c, -(2.0 - 2.0 * nu) * c;
    return k / g;
}

// The stack cut at the depth asked for, solved for one wave number at a time. From the floor upwards each slab turns
// the stiffness of all that lies below it into the stiffness at its top, which keeps only the solutions that decay
// downwards; from the surface downwards displacements then follow by decaying exponentials alone.
class CutStack {
public:
    CutStack(std::span<const ElasticLayer> layers, Floor floor, double z) : rigid_(floor == Floor::rigid_rough) {
        const double g_first = shear_modulus(layers.front());
        double top = 0.0;
        bool found = false;
        for (std::size_t i = 0; i < layers.size(); ++i) {
            const ElasticLayer& layer = layers[i];
            const double g = g_first / shear_modulus(layer);
            const bool endless = !rigid_ && i + 1 == layers.size();
            const double bottom = top + layer.thickness;
            const double tolerance = same_depth * std::max(z, top);
            if (!found && (endless || z < bottom - same_depth * bottom)) {
                found = true;
                layer_ = i;
                if (z > top + tolerance) {
                    slabs_.emplace_back(z - top, g, layer.poisson);
                    half_spaces_.push_back(half_space_stiffness(g, layer.poisson));
                    top = z;
                }
                level_ = slabs_.size();
            }
            if (endless) {
                floor_stiffness_ = half_space_stiffness(g, layer.poisson);
            } else {
                slabs_.emplace_back(bottom - top, g, layer.poisson);
                half_spaces_.push_back(half_space_stiffness(g, layer.poisson));
                top = bottom;
            }
        }
        if (!found) { // on the rigid floor
            layer_ = layers.size() - 1;
            level_ = slabs_.size();
        }
        down_.resize(slabs_.size());
    }

    std::size_t layer() const { return layer_; }

    // The state at the depth of the cut for T = 0, S = -1 at the surface.
    Vector4 state(double k) {
        constexpr double deep = 30.0; // of k h: what lies below is not felt at the top
        const Matrix2 identity = Matrix2::Identity();
        const Matrix2 zero = Matrix2::Zero();
        // At the top of what is done so far: displacements = shape c, stresses = force c.
        Matrix2 shape = rigid_ ? zero : identity;
        Matrix2 force = rigid_ ? identity : floor_stiffness_;
        Matrix2 cut_shape = shape;
        Matrix2 cut_force = force;
        for (std::size_t i = slabs_.size(); i-- > 0;) {
            const double t = k * slabs_[i].thickness;
            if (i >= level_ && t > deep) {
                force = half_spaces_[i];
            } else {
                const Matrix4 up = slabs_[i].upwards(t);
                const Matrix2 u = up.topLeftCorner<2, 2>() * shape + up.topRightCorner<2, 2>() * force;
                const Matrix2 s = up.bottomLeftCorner<2, 2>() * shape + up.bottomRightCorner<2, 2>() * force;
                const Matrix2 inverse = u.inverse();
                down_[i] = std::exp(-t) * inverse;
                force = t > deep ? half_spaces_[i] : Matrix2(s * inverse);
            }
            shape = identity;
            if (i == level_) {
                cut_shape = shape;
                cut_force = force;
            }
        }
        Vector2 c = force.inverse() * Vector2(0.0, -1.0);
        for (std::size_t i = 0; i < level_; ++i) {
            c = down_[i] * c;
        }
        Vector4 y;
        y << cut_shape * c, cut_force * c;
        return y;
    }

private:
    bool rigid_;
    std::vector<Slab> slabs_;          // all but an endless last layer
    std::vector<Matrix2> half_spaces_; // stiffness of a half-space of each slab
    Matrix2 floor_stiffness_ = Matrix2::Zero();
    std::size_t layer_ = 0; // that the depth belongs to
    std::size_t level_ = 0; // number of slabs above the depth
    std::vector<Matrix2> down_;
};

// The state in a half-space for T = 0, S = -1 at its surface.
Vector4 half_space_state(double kz, double nu) {
    return std::exp(-kz) * Vector4(kz - (1.0 - 2.0 * nu), kz + 2.0 * (1.0 - nu), -kz, -(1.0 + kz));
}

// The half-space under the circle: integrals of exp(-k z) k^m J1(k a) Jn(k r) over k. Neumann's addition theorem
// makes each the mean over the angle phi between two radii a and r of an elementary function of D, the distance from
// the point to the edge of the circle. Panels shrink towards phi = 0, where D is least.
Sums half_space_sums(double nu, double a, double r, double z) {
    double zero_order_m0 = 0.0;  // n = 0, m = 0
    double zero_order_m1 = 0.0;  // n = 0, m = -1
    double zero_order_p1 = 0.0;  // n = 0, m = 1
    double first_order_m0 = 0.0; // n = 1, m = 0, over r
    double first_order_m1 = 0.0; // n = 1, m = -1, over r
    double first_order_p1 = 0.0; // n = 1, m = 1
    const auto add = [&](double phi, double weight) {
        const double w = weight / pi;
        const double chord = 2.0 * std::sin(phi / 2.0);
        const double normal = (a - r) + r * chord * chord / 2.0; // a - r cos(phi)
        const double d = std::sqrt((a - r) * (a - r) + z * z + a * r * chord * chord);
        const double sine2 = std::sin(phi) * std::sin(phi);
        zero_order_m1 += w * normal / (d + z);
        first_order_m1 += w * a * sine2 / (d * (d + z));
        if (z > 0.0) {
            zero_order_m0 += w * normal / (d * (d + z));
            zero_order_p1 += w * normal / (d * d * d);
            first_order_m0 += w * a * sine2 / (d * d * d);
            first_order_p1 += w * 3.0 * a * r * z * sine2 / (d * d * d * d * d);
        }
    };
    const double least = std::max(std::hypot(a - r, z) / std::max(a, r), 1e-15);
    double to = pi;
    while (to > least) {
        gauss(to / 2.0, to, add);
        to /= 2.0;
    }
    gauss(0.0, to, add);
    if (z == 0.0) {
        zero_order_m0 = r < a ? 1.0 / a : r > a ? 0.0 : 0.5 / a;
    }
    return {.u_z = z * zero_order_m0 + 2.0 * (1.0 - nu) * zero_order_m1,
            .eps_rr_plus_tt = z * zero_order_p1 - (1.0 - 2.0 * nu) * zero_order_m0,
            .eps_tt = z * first_order_m0 - (1.0 - 2.0 * nu) * first_order_m1,
            .sigma_zz = -(zero_order_m0 + z * zero_order_p1),
            .sigma_rz = -z * first_order_p1};
}

struct Bessel {
    double j0, j1;
};

// J0 and J1, for large x by Hankel's asymptotic series, whose terms fall below 1e-16 there.
Bessel bessel(double x) {
    if (x < 25.0) {
        return {std::cyl_bessel_j(0.0, x), std::cyl_bessel_j(1.0, x)};
    }
    const auto value = [x](double order) {
        double p = 0.0;
        double q = 0.0;
        double term = 1.0;
        for (int i = 0; std::abs(term) > 1e-17; ++i) {
            const double sign = i % 4 < 2 ? 1.0 : -1.0;
            (i % 2 == 0 ? p : q) += sign * term;
            const double odd = 2.0 * i + 1.0;
            term *= (4.0 * order * order - odd * odd) / (8.0 * x * (i + 1));
        }
        const double phase = x - (order / 2.0 + 0.25) * pi;
        return std::sqrt(2.0 / (pi * x)) * (p * std::cos(phase) - q * std::sin(phase));
    };
    return {value(0.0), value(1.0)};
}

// The integral over all wave numbers. In the first layer the half-space is taken off under the integral and added in
// closed form: what remains decays as exp(-k (2 h - z)) even at the surface.
Sums stack_sums(std::span<const ElasticLayer> layers, Floor floor, double a, double r, double z) {
    CutStack stack(layers, floor, z);
    const double nu = layers.front().poisson;
    const bool first = stack.layer() == 0;
    const bool endless = layers.size() == 1 && floor == Floor::half_space;
    Sums sums;
    if (first) {
        sums = half_space_sums(nu, a, r, z);
        if (endless) {
            return sums;
        }
    }
    const auto add = [&](double k, double weight) {
        Vector4 y = stack.state(k);
        if (first) {
            y -= half_space_state(k * z, nu);
        }
        const double w = weight * bessel(k * a).j1;
        const auto [j0, j1] = bessel(k * r);
        sums.u_z += w * y[1] * j0 / k;
        sums.eps_rr_plus_tt += w * y[0] * j0;
        sums.eps_tt += w * y[0] * (k * r > 0.0 ? j1 / (k * r) : 0.5);
        sums.sigma_zz += w * y[3] * j0;
        sums.sigma_rz += w * y[2] * j1;
    };
    double size = a + r + z;
    for (const ElasticLayer& layer : layers) {
        size += &layer == &layers.back() && floor == Floor::half_space ? 0.0 : layer.thickness;
    }
    const double last = 40.0 / (first ? 2.0 * layers.front().thickness - z : z);
    double from = 0.0;
    while (from < last) {
        // Panels grow in proportion to k until one spans two and a half waves of J1(k a) J0(k r).
        const double width = std::min(std::max(1e-4 / size, from / 2.0), 5.0 * pi / (a + r));
        gauss(from, from + width, add);
        from += width;
    }
    return sums;
}

void check(std::span<const ElasticLayer> layers, Floor floor, double radius, double pressure, double r, double z) {
    const auto require = [](bool possible, const char* what) {
        if (!possible) {
            throw std::invalid_argument(what);
        }
    };
    require(!layers.empty(), "multilayer_elastic: no layer");
    double depth = 0.0;
    for (const ElasticLayer& layer : layers) {
        const bool endless = floor == Floor::half_space && &layer == &layers.back();
        require(layer.modulus > 0.0 && std::isfinite(layer.modulus), "multilayer_elastic: modulus not positive");
        require(layer.poisson > -1.0 && layer.poisson <= 0.5, "multilayer_elastic: Poisson's ratio outside (-1, 0.5]");
        require(endless || (layer.thickness > 0.0 && std::isfinite(layer.thickness)),
                "multilayer_elastic: thickness not positive");
        depth += layer.thickness;
    }
    require(radius > 0.0 && std::isfinite(radius), "multilayer_elastic: radius not positive");
    require(std::isfinite(pressure), "multilayer_elastic: pressure not finite");
    require(r >= 0.0 && std::isfinite(r), "multilayer_elastic: r negative");
    require(z >= 0.0 && std::isfinite(z), "multilayer_elastic: point above the surface");
    require(floor == Floor::half_space || z <= depth * (1.0 + same_depth), "multilayer_elastic: point below the floor");
}

} // namespace

ElasticField multilayer_elastic(std::span<const ElasticLayer> layers, Floor floor, double radius, double pressure,
                                double r, double z) {
    check(layers, floor, radius, pressure, r, z);
    const Sums sums = stack_sums(layers, floor, radius, r, z);
    const ElasticLayer& layer = layers[CutStack(layers, floor, z).layer()];
    const double nu = layer.poisson;
    const double load = pressure * radius;
    const double compliance = load / (2.0 * shear_modulus(layers.front()));
    const double plane = layer.modulus / (1.0 - nu * nu);

    ElasticField field{};
    field.u_z = compliance * sums.u_z;
    field.sigma_zz = load * sums.sigma_zz;
    field.sigma_rz = load * sums.sigma_rz;
    field.eps_tt = compliance * sums.eps_tt;
    field.eps_rr = compliance * (sums.eps_rr_plus_tt - sums.eps_tt);
    field.u_r = r * field.eps_tt;
    field.eps_zz =
        ((1.0 - 2.0 * nu) * field.sigma_zz / (2.0 * shear_modulus(layer)) - nu * (field.eps_rr + field.eps_tt)) /
        (1.0 - nu);
    const double side = nu / (1.0 - nu) * field.sigma_zz;
    field.sigma_rr = side + plane * (field.eps_rr + nu * field.eps_tt);
    field.sigma_tt = side + plane * (field.eps_tt + nu * field.eps_rr);
    return field;
}

} // namespace pave::reference
