// A stack of layers under the Hankel transform: what a pressure on its surface does at any depth.
//
// The impedance Y of what lies below a depth, (T, S) = k Y (U, W), is carried upwards from the floor. With
// P = exp(-k h M), a tilde for the sign change of the off-diagonal (the mirror image) and D = diag(z11, z22) of a
// layer:
//     A = Z~ + Y,  V = (I + 2 P~ A^-1 D P - P~ P)^-1,  Y of its top = 2 D V - Z~;
// a rigid floor has A^-1 = 0, a half-space Y = Z. Downwards, with a = V u: u = P(k t) a + P~(k (h - t)) c at t below
// the top of the layer, c = (2 A^-1 D - I) P a, u = 2 A^-1 D P a at its bottom. Only decaying exponentials of the
// layer's own thickness occur, so nothing overflows and thin and thick layers are no special cases. A spring of
// compliance s between two layers turns Y into (1/Y + k s e1 e1^T)^-1. (The reflection form of Kennett, "Seismic wave
// propagation in stratified media" (1983), with impedances in place of reflections.)
#pragma once

#include "layered/medium.h"

#include <vector>

namespace pave::layered {

template <class R>
struct ColumnLayer {
    Elastic<R> stiffness;
    R thickness;  // m; of the last layer of a half-space: of no account
    R compliance; // m/Pa, of the interface at its bottom; 0: bonded
};

// Where a column is read: at `below` [m] under the top of layer number `layer`.
template <class R>
struct Level {
    int layer;
    R below;
    bool surface; // the top of the section
};

// Under a surface pressure of -S(k): k U / S, k W / S and s_zz / S.
template <class R>
struct State {
    R u, w, s;
};

template <class R>
class Column {
public:
    // half_space: the last layer goes on for ever; else it stands on a rigid rough floor.
    Column(std::vector<ColumnLayer<R>> layers, bool half_space) : layers_(std::move(layers)), half_space_(half_space) {
        for (const ColumnLayer<R>& layer : layers_) {
            media_.emplace_back(layer.stiffness);
        }
        passes_.resize(layers_.size());
    }

    const std::vector<ColumnLayer<R>>& layers() const { return layers_; }
    const Medium<R>& medium(int layer) const { return media_[static_cast<std::size_t>(layer)]; }
    bool half_space() const { return half_space_; }

    // u and w on the surface as k goes to infinity: those of a half-space of the first layer.
    Vector2<R> surface_limit() const { return surface_of(media_.front().impedance()); }

    // levels: from above. states: one of each.
    void at(double k, const std::vector<Level<R>>& levels, State<R>* states) {
        constexpr double out_of_reach = 45.0; // exp(-45) is below rounding
        std::size_t last = layers_.size() - 1;
        bool open = half_space_;
        double fallen = 0.0;
        for (std::size_t i = 0; i < layers_.size() && !(open && i == last); ++i) {
            fallen += k * media_[i].slowest() * value_of(layers_[i].thickness);
            if (fallen > out_of_reach) {
                last = i;
                open = true;
            }
        }
        Symmetric2<R> y = media_[last].impedance();
        for (std::size_t i = open ? last : last + 1; i-- > 0;) {
            Pass& pass = passes_[i];
            const Medium<R>& medium = media_[i];
            const Symmetric2<R>& z = medium.impedance();
            const R x = k * layers_[i].thickness;
            pass.p = medium.propagate(x);
            const Matrix2<R> mirrored = mirror(pass.p);
            Matrix2<R> t{-1.0, 0.0, 0.0, -1.0}; // 2 A^-1 D - I
            if (i < last) {
                pass.slip = 0.0;
                if (value_of(layers_[i].compliance) > 0.0) {
                    pass.slip = k * layers_[i].compliance;
                    pass.below = y;
                    const R g = 1.0 / (1.0 - pass.slip * y.a11);
                    y = {y.a11 * g, y.a12 * g, y.a22 + pass.slip * y.a12 * y.a12 * g};
                }
                const R a11 = z.a11 + y.a11;
                const R a12 = y.a12 - z.a12;
                const R a22 = z.a22 + y.a22;
                const R two = 2.0 / (a11 * a22 - a12 * a12);
                t = {two * a22 * z.a11 - 1.0, -(two * a12 * z.a22), -(two * a12 * z.a11), two * a11 * z.a22 - 1.0};
            }
            pass.reflect = t * pass.p;
            const Matrix2<R> round = mirrored * pass.reflect;
            const R one_over = 1.0 / ((1.0 + round.a11) * (1.0 + round.a22) - round.a12 * round.a21);
            pass.v = {(1.0 + round.a22) * one_over, -(round.a12 * one_over), -(round.a21 * one_over),
                      (1.0 + round.a11) * one_over};
            y = {2.0 * z.a11 * pass.v.a11 - z.a11, 2.0 * z.a11 * pass.v.a12 + z.a12, 2.0 * z.a22 * pass.v.a22 - z.a22};
        }
        Vector2<R> u = surface_of(y);
        std::size_t level = 0;
        for (std::size_t i = 0; i <= last && level < levels.size(); ++i) {
            const Medium<R>& medium = media_[i];
            const bool endless = open && i == last;
            const Pass& pass = passes_[i];
            const Vector2<R> a = endless ? u : pass.v * u;
            const Vector2<R> c = endless ? Vector2<R>{0.0, 0.0} : pass.reflect * a;
            for (; level < levels.size() && levels[level].layer == static_cast<int>(i); ++level) {
                if (levels[level].surface) {
                    states[level] = {u.a1, u.a2, 1.0};
                    continue;
                }
                const Vector2<R> down = medium.propagate(k * levels[level].below) * a;
                Vector2<R> up{0.0, 0.0};
                if (!endless) {
                    up = mirror(medium.propagate(k * (layers_[i].thickness - levels[level].below))) * c;
                }
                const Symmetric2<R>& z = medium.impedance();
                states[level] = {down.a1 + up.a1, down.a2 + up.a2,
                                 z.a12 * (down.a1 + up.a1) + z.a22 * (down.a2 - up.a2)};
            }
            if (i < last) {
                u = pass.p * a + c;
                if (value_of(pass.slip) > 0.0) {
                    u.a1 = (u.a1 + pass.slip * pass.below.a12 * u.a2) / (1.0 - pass.slip * pass.below.a11);
                }
            }
        }
        for (; level < levels.size(); ++level) {
            states[level] = {0.0, 0.0, 0.0};
        }
    }

private:
    struct Pass { // of one layer at one k
        Matrix2<R> p, reflect, v;
        Symmetric2<R> below; // the impedance under the interface at its bottom
        R slip;              // k times its compliance
    };

    static Matrix2<R> mirror(const Matrix2<R>& m) { return {m.a11, -m.a12, -m.a21, m.a22}; }
    // Y^-1 e2: under a unit s_zz.
    static Vector2<R> surface_of(const Symmetric2<R>& y) {
        const R scale = 1.0 / (y.a11 * y.a22 - y.a12 * y.a12);
        return {-(y.a12 * scale), y.a11 * scale};
    }

    std::vector<ColumnLayer<R>> layers_;
    bool half_space_;
    std::vector<Medium<R>> media_;
    std::vector<Pass> passes_;
};

} // namespace pave::layered
