// Laws, strains and assembly of many runs on one axisymmetric mesh, one a lane. Private to fe/lanes/.
#pragma once

#include "fe/lanes/factor.h"

namespace pave::fe::lanes::PAVE_LANES {

// Entries of a stiffness as unit_numbers orders them.
struct Stiffness {
    Lanes c11, c12, c13, c33, c44;
};
PAVE_INLINE Stiffness stiffness_at(const double* numbers, std::ptrdiff_t which) {
    const Lanes* c = of(numbers) + which * unit_numbers;
    return {c[0], c[1], c[2], c[3], c[4]};
}
PAVE_INLINE Stiffness times(Lanes m, const Stiffness& c) {
    return {m * c.c11, m * c.c12, m * c.c13, m * c.c33, m * c.c44};
}

// Components rr, tt, zz, rz.
struct Components {
    Lanes rr, tt, zz, rz;
};
PAVE_INLINE Components product(const Stiffness& c, const Components& e) {
    return {fma(c.c13, e.zz, fma(c.c12, e.tt, c.c11 * e.rr)), fma(c.c13, e.zz, fma(c.c11, e.tt, c.c12 * e.rr)),
            fma(c.c33, e.zz, c.c13 * (e.rr + e.tt)), c.c44 * e.rz};
}
PAVE_INLINE Components load(const Lanes* at) {
    return {at[0], at[1], at[2], at[3]};
}
PAVE_INLINE void store(const Components& s, Lanes* at) {
    at[0] = s.rr;
    at[1] = s.tt;
    at[2] = s.zz;
    at[3] = s.rz;
}

// Of a Gauss point: the rates of the shape functions.
struct Shape {
    double weight;
    const double* dr;
    const double* dz;
    const double* n_r;
    PAVE_INLINE Shape(const Elements& mesh, int element, int g) {
        const double* at =
            mesh.shapes + (static_cast<std::ptrdiff_t>(element) * points_of_element + g) * numbers_of_shape;
        weight = at[0];
        dr = at + 1;
        dz = dr + nodes_of_element;
        n_r = dz + nodes_of_element;
    }
};

PAVE_INLINE void gather(const Elements& mesh, int element, const Lanes* u, std::ptrdiff_t stride, Lanes* of_element) {
    const int* unknowns = mesh.unknowns + static_cast<std::ptrdiff_t>(element) * unknowns_of_element;
    for (int i = 0; i < unknowns_of_element; ++i) {
        of_element[i] = unknowns[i] >= 0 ? u[unknowns[i] * stride] : Lanes{};
    }
}
PAVE_INLINE void scatter_add(const Elements& mesh, int element, const Lanes* of_element, std::ptrdiff_t stride,
                             Lanes* to) {
    const int* unknowns = mesh.unknowns + static_cast<std::ptrdiff_t>(element) * unknowns_of_element;
    for (int i = 0; i < unknowns_of_element; ++i) {
        if (unknowns[i] >= 0) {
            to[unknowns[i] * stride] += of_element[i];
        }
    }
}
PAVE_INLINE Components strain(const Shape& p, const Lanes* u) {
    Components e{};
    for (int i = 0; i < nodes_of_element; ++i) {
        e.rr = fma(p.dr[i], u[2 * i], e.rr);
        e.tt = fma(p.n_r[i], u[2 * i], e.tt);
        e.zz = fma(p.dz[i], u[2 * i + 1], e.zz);
        e.rz = fma(p.dr[i], u[2 * i + 1], fma(p.dz[i], u[2 * i], e.rz));
    }
    return e;
}
// force -= B^T stress times the weight
PAVE_INLINE void subtract_force(const Shape& p, const Components& stress, Lanes* force) {
    const Components s{p.weight * stress.rr, p.weight * stress.tt, p.weight * stress.zz, p.weight * stress.rz};
    for (int i = 0; i < nodes_of_element; ++i) {
        force[2 * i] = minus(all(p.dr[i]), s.rr, minus(all(p.n_r[i]), s.tt, minus(all(p.dz[i]), s.rz, force[2 * i])));
        force[2 * i + 1] = minus(all(p.dz[i]), s.zz, minus(all(p.dr[i]), s.rz, force[2 * i + 1]));
    }
}

inline void assemble(const Elements& mesh, const int* elements, int count, const double* unit,
                     const double* modulus_of_points, const double* modulus_of_layers, double* values) {
    // D B by node and Gauss point: of its radial unknown rr, tt, zz, rz, of its vertical one rr (tt too), zz, rz.
    constexpr int numbers = 7;
    Lanes db[nodes_of_element][points_of_element][numbers];
    for (int a = 0; a < count; ++a) {
        const int e = elements[a];
        const int layer = mesh.layer[e];
        const Stiffness c = stiffness_at(unit, layer);
        for (int g = 0; g < points_of_element; ++g) {
            const Shape p(mesh, e, g);
            const Lanes modulus = modulus_of_points != nullptr
                                      ? of(modulus_of_points)[static_cast<std::ptrdiff_t>(a) * points_of_element + g]
                                      : of(modulus_of_layers)[layer];
            const Stiffness d = times(p.weight * modulus, c);
            for (int i = 0; i < nodes_of_element; ++i) {
                Lanes* at = db[i][g];
                at[0] = fma(p.n_r[i], d.c12, p.dr[i] * d.c11);
                at[1] = fma(p.n_r[i], d.c11, p.dr[i] * d.c12);
                at[2] = (p.dr[i] + p.n_r[i]) * d.c13;
                at[3] = p.dz[i] * d.c44;
                at[4] = p.dz[i] * d.c13;
                at[5] = p.dz[i] * d.c33;
                at[6] = p.dr[i] * d.c44;
            }
        }
        const int* place = mesh.places + static_cast<std::ptrdiff_t>(e) * lower_of_element;
        const Shape shape[points_of_element] = {{mesh, e, 0}, {mesh, e, 1}, {mesh, e, 2}, {mesh, e, 3}};
        const auto add = [&](int row, int column, Lanes x) {
            if (const int at = place[row * (row + 1) / 2 + column]; at >= 0) {
                of(values)[at] += x;
            }
        };
        for (int i = 0; i < nodes_of_element; ++i) {
            for (int j = 0; j <= i; ++j) {
                Lanes rr{}, zr{}, rz{}, zz{};
#pragma GCC unroll 4
                for (int g = 0; g < points_of_element; ++g) {
                    const double dr = shape[g].dr[i];
                    const double dz = shape[g].dz[i];
                    const double n_r = shape[g].n_r[i];
                    const Lanes* at = db[j][g];
                    rr = fma(dr, at[0], fma(n_r, at[1], fma(dz, at[3], rr)));
                    zr = fma(dz, at[2], fma(dr, at[3], zr));
                    rz = fma(dr + n_r, at[4], fma(dz, at[6], rz));
                    zz = fma(dz, at[5], fma(dr, at[6], zz));
                }
                add(2 * i, 2 * j, rr);
                add(2 * i + 1, 2 * j, zr);
                if (i != j) {
                    add(2 * i, 2 * j + 1, rz);
                }
                add(2 * i + 1, 2 * j + 1, zz);
            }
        }
    }
}

// E at a stress state, its rates, and what explicit derivatives need.
struct State {
    Lanes theta, tau, value, d_theta, d_tau;
    Mask limited;
    Lanes thp, confinement, distortion; // of a power
    Lanes root;
};

constexpr double reference_pressure = 1e5; // Pa
constexpr double modulus_limit = 1e11;     // Pa

PAVE_INLINE Lanes octahedral_shear(const Components& s) {
    const Lanes a = s.rr - s.tt;
    const Lanes b = s.tt - s.zz;
    const Lanes c = s.zz - s.rr;
    return root(fma(a, a, fma(b, b, fma(c, c, 6.0 * (s.rz * s.rz))))) / 3.0;
}

PAVE_INLINE void follow_power(const double* numbers, State& s) {
    const Lanes* p = of(numbers);
    const Lanes delta = p[3];
    const Lanes eta = p[4];
    const Lanes square = fma(eta * eta, s.tau * s.tau, delta * delta);
    s.root = root(fma(s.theta, s.theta, 4.0 * square));
    s.thp = choose(s.theta >= 0.0, (s.theta + s.root) / 2.0, 2.0 * square / (s.root - s.theta));
    s.confinement = log(s.thp / reference_pressure);
    s.distortion = log_1_plus(s.tau / reference_pressure);
    const Lanes value = p[0] * exp(fma(p[1], s.confinement, p[2] * s.distortion));
    s.limited = ~(value < modulus_limit);
    const Lanes by_thp = value * p[1] / s.thp;
    const Lanes by_tau = value * p[2] / (s.tau + reference_pressure);
    s.value = choose(s.limited, all(modulus_limit), value);
    s.d_theta = choose(s.limited, Lanes{}, by_thp * (s.thp / s.root));
    s.d_tau = choose(s.limited, Lanes{}, fma(by_thp, 2.0 * (eta * eta) * s.tau / s.root, by_tau));
}

// By one of the numbers; k1 itself, in units of pa.
PAVE_INLINE Lanes explicit_rate(const double* numbers, const State& s, Explicit by) {
    const Lanes* p = of(numbers);
    Lanes rate{};
    switch (by) {
    case Explicit::k1: rate = s.value / (p[0] / reference_pressure); break;
    case Explicit::k2: rate = s.value * s.confinement; break;
    case Explicit::k3: rate = s.value * s.distortion; break;
    case Explicit::delta: rate = s.value * p[1] / s.thp * (2.0 * p[3] / s.root); break;
    case Explicit::eta: rate = s.value * p[1] / s.thp * (2.0 * p[4] * (s.tau * s.tau) / s.root); break;
    default: break;
    }
    return choose(s.limited, Lanes{}, rate);
}

// by_variation: explicit rates of `other` ones, lane by lane, where there are any.
PAVE_INLINE State state_at(const Points& points, int layer, const Components& total, double* by_variation) {
    State s{};
    s.theta = -(total.rr + total.tt + total.zz);
    s.tau = octahedral_shear(total);
    const Modulus& law = points.moduli[layer];
    if (law.is_power) {
        follow_power(law.numbers, s);
        return s;
    }
    for (int lane = 0; lane < width; ++lane) {
        ModulusOfLane at{};
        points.function.call(points.function.context, layer, lane, s.theta[lane], s.tau[lane], &at,
                             by_variation + lane * points.variations);
        s.value[lane] = at.value;
        s.d_theta[lane] = at.d_theta;
        s.d_tau[lane] = at.d_tau;
        s.limited[lane] = at.limited;
    }
    return s;
}

constexpr int most_variations = 64;

PAVE_INLINE Components initial_at(const double* initial, std::ptrdiff_t which) {
    const Lanes* at = of(initial) + 2 * which;
    return {at[0], at[0], at[1], Lanes{}};
}
PAVE_INLINE Components sum_of(const Components& a, const Components& b) {
    return {a.rr + b.rr, a.tt + b.tt, a.zz + b.zz, a.rz + b.rz};
}

inline void moduli(const Elements& mesh, const Points& points, const double* stress, const double* d_stress,
                   double* modulus, double* modulus_rate) {
    const int n = points.variations;
    double by_variation[width * most_variations] = {};
    for (int a = 0; a < points.count; ++a) {
        const int layer = mesh.layer[points.elements[a]];
        const Modulus& law = points.moduli[layer];
        for (int g = 0; g < points_of_element; ++g) {
            const std::ptrdiff_t q = static_cast<std::ptrdiff_t>(a) * points_of_element + g;
            const Components total = sum_of(initial_at(points.initial, q), load(of(stress) + 4 * q));
            const State s = state_at(points, layer, total, by_variation);
            of(modulus)[q] = s.value;
            if (n == 0) {
                continue;
            }
            const Lanes by_tau = choose(s.tau > 0.0, s.d_tau / s.tau, Lanes{});
            const Lanes mean = (total.rr + total.tt + total.zz) / 3.0;
            const Components gradient{
                fma(by_tau, (total.rr - mean) / 3.0, -s.d_theta), fma(by_tau, (total.tt - mean) / 3.0, -s.d_theta),
                fma(by_tau, (total.zz - mean) / 3.0, -s.d_theta), by_tau * (total.rz * (2.0 / 3.0))};
            for (int k = 0; k < n; ++k) {
                const std::ptrdiff_t qk = q * n + k;
                Components rate = load(of(d_stress) + 4 * qk);
                if (points.initial_rate != nullptr) {
                    rate = sum_of(rate, initial_at(points.initial_rate, qk));
                }
                Lanes explicitly{};
                const Explicit by = points.explicit_by[layer * n + k];
                if (by == Explicit::other) {
                    for (int lane = 0; lane < width; ++lane) {
                        explicitly[lane] = by_variation[lane * n + k];
                    }
                } else if (by != Explicit::none) {
                    explicitly = explicit_rate(law.numbers, s, by);
                }
                of(modulus_rate)[qk] =
                    fma(gradient.rr, rate.rr,
                        fma(gradient.tt, rate.tt, fma(gradient.zz, rate.zz, fma(gradient.rz, rate.rz, explicitly))));
            }
        }
    }
}

inline void stress_of(const Elements& mesh, const Points& points, const double* modulus, const double* modulus_rate,
                      const double* u, double* stress, double* d_stress, double* right) {
    const int n = points.variations;
    Lanes ue[unknowns_of_element];
    Components strains[points_of_element];
    for (int a = 0; a < points.count; ++a) {
        const int e = points.elements[a];
        const int layer = mesh.layer[e];
        const Stiffness c = stiffness_at(points.unit, layer);
        gather(mesh, e, of(u), 1, ue);
        for (int g = 0; g < points_of_element; ++g) {
            const std::ptrdiff_t q = static_cast<std::ptrdiff_t>(a) * points_of_element + g;
            strains[g] = strain({mesh, e, g}, ue);
            store(product(times(of(modulus)[q], c), strains[g]), of(stress) + 4 * q);
        }
        for (int k = 0; k < n; ++k) {
            Lanes force[unknowns_of_element] = {};
            for (int g = 0; g < points_of_element; ++g) {
                const std::ptrdiff_t q = static_cast<std::ptrdiff_t>(a) * points_of_element + g;
                const Lanes ratio = of(modulus_rate)[q * n + k] / of(modulus)[q];
                const Components s = load(of(stress) + 4 * q);
                Components d{ratio * s.rr, ratio * s.tt, ratio * s.zz, ratio * s.rz};
                if (points.unit_varies[layer * n + k]) {
                    const Stiffness rate = stiffness_at(points.unit_rate, static_cast<std::ptrdiff_t>(layer) * n + k);
                    d = sum_of(d, product(times(of(modulus)[q], rate), strains[g]));
                }
                store(d, of(d_stress) + 4 * (q * n + k));
                subtract_force({mesh, e, g}, d, force);
            }
            scatter_add(mesh, e, force, n, of(right) + k);
        }
    }
}

inline void add_stress_rates(const Elements& mesh, const Points& points, const double* modulus, const double* du,
                             double* d_stress) {
    const int n = points.variations;
    Lanes ue[unknowns_of_element];
    for (int a = 0; a < points.count; ++a) {
        const int e = points.elements[a];
        const Stiffness c = stiffness_at(points.unit, mesh.layer[e]);
        for (int k = 0; k < n; ++k) {
            gather(mesh, e, of(du) + k, n, ue);
            for (int g = 0; g < points_of_element; ++g) {
                const std::ptrdiff_t q = static_cast<std::ptrdiff_t>(a) * points_of_element + g;
                Lanes* at = of(d_stress) + 4 * (q * n + k);
                store(sum_of(load(at), product(times(of(modulus)[q], c), strain({mesh, e, g}, ue))), at);
            }
        }
    }
}

inline void subtract_force_of(const Elements& mesh, const int* elements, int count, const double* d, const double* u,
                              double* right, int column, int columns) {
    Lanes ue[unknowns_of_element];
    for (int a = 0; a < count; ++a) {
        const int e = elements[a];
        gather(mesh, e, of(u), 1, ue);
        Lanes force[unknowns_of_element] = {};
        for (int g = 0; g < points_of_element; ++g) {
            const Shape p(mesh, e, g);
            subtract_force(p, product(stiffness_at(d, 0), strain(p, ue)), force);
        }
        scatter_add(mesh, e, force, columns, of(right) + column);
    }
}

inline void subtract_stress(const Elements& mesh, const Points& points, const double* stress, double* right) {
    for (int a = 0; a < points.count; ++a) {
        const int e = points.elements[a];
        Lanes force[unknowns_of_element] = {};
        for (int g = 0; g < points_of_element; ++g) {
            const std::ptrdiff_t q = static_cast<std::ptrdiff_t>(a) * points_of_element + g;
            subtract_force({mesh, e, g}, load(of(stress) + 4 * q), force);
        }
        scatter_add(mesh, e, force, 1, of(right));
    }
}

inline void shares(const Elements& mesh, const Points& points, const double* compliance, const double* stress,
                   Shares& sums) {
    double by_variation[width * most_variations] = {};
    Lanes energy = *of(sums.energy);
    Lanes tension = *of(sums.tension);
    Lanes unstable = *of(sums.unstable);
    Lanes limited = *of(sums.limited);
    for (int a = 0; a < points.count; ++a) {
        const int e = points.elements[a];
        const int layer = mesh.layer[e];
        const Stiffness inverse = stiffness_at(compliance, layer);
        for (int g = 0; g < points_of_element; ++g) {
            const std::ptrdiff_t q = static_cast<std::ptrdiff_t>(a) * points_of_element + g;
            const Components own = load(of(stress) + 4 * q);
            const State s = state_at(points, layer, sum_of(initial_at(points.initial, q), own), by_variation);
            const Components by = product(inverse, own);
            const Lanes square = fma(own.rr, by.rr, fma(own.tt, by.tt, fma(own.zz, by.zz, own.rz * by.rz)));
            const Lanes w = Shape(mesh, e, g).weight * square / s.value;
            energy += w;
            tension += choose(s.theta < 0.0, w, Lanes{});
            unstable += choose(fma(s.theta, s.d_theta, s.tau * s.d_tau) >= s.value, w, Lanes{});
            limited += choose(s.limited, w, Lanes{});
        }
    }
    *of(sums.energy) = energy;
    *of(sums.tension) = tension;
    *of(sums.unstable) = unstable;
    *of(sums.limited) = limited;
}

inline void combine(double* to, const double* from, int rates, const double* factors, const double* const* rate,
                    std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        Lanes sum = of(from)[i];
        for (int j = 0; j < rates; ++j) {
            sum = fma(factors[j], of(rate[j])[i], sum);
        }
        of(to)[i] = sum;
    }
}

inline void functions(const double* x, double* log_x, double* log_1_plus_x, double* exp_x) {
    *of(log_x) = log(*of(x));
    *of(log_1_plus_x) = log_1_plus(*of(x));
    *of(exp_x) = exp(*of(x));
}

} // namespace pave::fe::lanes::PAVE_LANES
