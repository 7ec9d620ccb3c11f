// Memory of the displacement in layers that relax. Private to fe/.
#pragma once

#include "fe/materials.h"

#include <cmath>

namespace pave::fe {

// A displacement that fades with a time of relaxation: v' = u' - v/time. Stress in a layer that
// relaxes is E C B f with f = (1 - sum of shares) u + sum of share v, for v of its terms: the strains of its memory are
// those of displacements.
struct Term {
    material::Relaxation is;
    std::vector<material::Relaxation> rates; // by every variation
    Eigen::VectorXd v;
    Eigen::MatrixXd dv;
};

// A step of a term: v becomes kept v + grown (change of u), exact where u changes evenly.
struct Fading {
    double kept, grown;
    double d_kept, d_grown; // by the time of relaxation
    Fading(double time, double step) {
        const double x = step / time;
        kept = std::exp(-x);
        grown = -std::expm1(-x) / x;
        d_kept = kept * x / time;
        d_grown = (grown - kept) / time;
    }
};

struct Memory {
    std::size_t layer = 0;
    std::vector<Term> terms;

    // f after a step: before + share (change of u).
    double share(double step) const {
        double s = 1.0;
        for (const Term& t : terms) {
            s -= t.is.share * (1.0 - Fading(t.is.time, step).grown);
        }
        return s;
    }
    double share_rate(double step, int k) const {
        double s = 0.0;
        for (const Term& t : terms) {
            const Fading f(t.is.time, step);
            const material::Relaxation& d = t.rates[static_cast<std::size_t>(k)];
            s += t.is.share * f.d_grown * d.time - d.share * (1.0 - f.grown);
        }
        return s;
    }
    Eigen::VectorXd before(double step, const Eigen::VectorXd& u) const {
        Eigen::VectorXd f = u;
        for (const Term& t : terms) {
            f += t.is.share * (Fading(t.is.time, step).kept * t.v - u);
        }
        return f;
    }
    Eigen::VectorXd before_rate(double step, const Eigen::VectorXd& u, const Eigen::VectorXd& du, int k) const {
        Eigen::VectorXd f = du;
        for (const Term& t : terms) {
            const Fading fading(t.is.time, step);
            const material::Relaxation& d = t.rates[static_cast<std::size_t>(k)];
            f += t.is.share * (fading.kept * t.dv.col(k) + fading.d_kept * d.time * t.v - du) +
                 d.share * (fading.kept * t.v - u);
        }
        return f;
    }
    // Of the change of u in a step.
    void advance(double step, const Eigen::VectorXd& change, const Eigen::MatrixXd& d_change) {
        for (Term& t : terms) {
            const Fading f(t.is.time, step);
            for (Eigen::Index k = 0; k < d_change.cols(); ++k) {
                const double d_time = t.rates[static_cast<std::size_t>(k)].time;
                t.dv.col(k) =
                    f.kept * t.dv.col(k) + f.grown * d_change.col(k) + d_time * (f.d_kept * t.v + f.d_grown * change);
            }
            t.v = f.kept * t.v + f.grown * change;
        }
    }
    // f itself.
    Eigen::VectorXd felt(const Eigen::VectorXd& u) const {
        Eigen::VectorXd f = u;
        for (const Term& t : terms) {
            f += t.is.share * (t.v - u);
        }
        return f;
    }
    Eigen::MatrixXd felt_rates(const Eigen::VectorXd& u, const Eigen::MatrixXd& du) const {
        Eigen::MatrixXd f = du;
        for (const Term& t : terms) {
            f += t.is.share * (t.dv - du);
            for (Eigen::Index k = 0; k < du.cols(); ++k) {
                f.col(k) += t.rates[static_cast<std::size_t>(k)].share * (t.v - u);
            }
        }
        return f;
    }
};

inline std::vector<Memory> memories_of(const std::vector<LayerMaterial>& layers,
                                       const std::vector<Variation>& variations, Eigen::Index unknowns) {
    const auto count = static_cast<Eigen::Index>(variations.size());
    std::vector<Memory> memories;
    for (std::size_t l = 0; l < layers.size(); ++l) {
        const LayerMaterial& layer = layers[l];
        std::vector<Term> terms;
        for (const material::Relaxation& r : layer.law->relaxation(layer.parameters)) {
            terms.push_back({r, {}, Eigen::VectorXd::Zero(unknowns), Eigen::MatrixXd::Zero(unknowns, count)});
        }
        for (const Variation& v : variations) {
            const bool own = v.kind == Variation::Kind::law_parameter && v.layer == static_cast<int>(l);
            const auto rates = own ? layer.law->relaxation_derivative(layer.parameters, v.index)
                                   : std::vector<material::Relaxation>(terms.size());
            for (std::size_t i = 0; i < terms.size(); ++i) {
                Term& t = terms[i];
                t.rates.push_back(rates[i]);
                if (v.kind == Variation::Kind::duration) { // shorter steps fade as longer times do
                    t.rates.back().time -= t.is.time;
                }
            }
        }
        if (!terms.empty()) {
            memories.push_back({l, std::move(terms)});
        }
    }
    return memories;
}

} // namespace pave::fe
