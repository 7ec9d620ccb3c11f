// Gauss points of layers whose law has an energy: stress as a function of strain and back, tangents, rates. Private to
// fe/.
#pragma once

#include "fe/materials.h"
#include "fe/model.h"

#include <algorithm>
#include <vector>

namespace pave::fe {

// The law at a point: strain = A stress / (factor E(Q)), Q = stress : A : stress, of the whole stress. Fields within
// the layer are in A, or in the factor.
template <int N>
class EnergyMaterial {
public:
    using Stress = mechanics::Voigt<N>;
    using Matrix = mechanics::Stiffness<N>;

    // Of A or of the factor by a variation; the law's own number may change too.
    struct Rate {
        Matrix unit = Matrix::Zero(); // of C = A^-1
        double factor = 0.0;          // of its logarithm
        std::optional<std::size_t> parameter;
    };

    EnergyMaterial(const LayerMaterial& layer, int number, const Eigen::Vector3d& at,
                   const std::vector<Variation>& variations)
        : energy_(layer.law->energy()),
          parameters_(&layer.parameters),
          factor_(local_factor(layer, at)) {
        unit_ = cut(local_stiffness(layer, at, {})) / factor_;
        compliance_ = unit_.inverse();
        rates_.reserve(variations.size());
        for (const Variation& v : variations) {
            Rate rate;
            rate.factor = local_factor_rate(layer, number, at, v);
            if (rate.factor == 0.0) {
                rate.unit = cut(local_stiffness_rate(layer, number, at, {}, v)) / factor_;
            }
            if (v.kind == Variation::Kind::law_parameter && v.layer == number) {
                rate.parameter = v.index;
            }
            rates_.push_back(std::move(rate));
        }
    }

    // At a whole stress. The tangent stiffness is modulus (unit + along stress (x) stress), its inverse
    // (compliance - hardening direction (x) direction)/modulus.
    struct State {
        Stress direction; // A stress
        double q = 0.0;
        material::Energy::Secant secant;
        double modulus = 0.0; // factor E
        double along = 0.0;   // hardening/(1 - hardening Q)
    };
    State at(const Stress& stress) const {
        State s;
        s.direction = compliance_ * stress;
        s.q = stress.dot(s.direction);
        s.secant = energy_->secant(*parameters_, s.q);
        s.modulus = factor_ * s.secant.value;
        s.along = s.secant.hardening / (1.0 - s.secant.hardening * s.q);
        return s;
    }
    const Matrix& unit() const { return unit_; }
    Matrix tangent_unit(const State& s, const Stress& stress) const {
        return unit_ + s.along * (stress * stress.transpose());
    }
    Matrix tangent_compliance(const State& s) const {
        return compliance_ - s.secant.hardening * (s.direction * s.direction.transpose());
    }
    Stress times_tangent(const State& s, const Stress& stress, const Stress& strain) const {
        return s.modulus * (unit_ * strain + (s.along * stress.dot(strain)) * stress);
    }

    static Stress strain(const State& s) { return s.direction / s.modulus; }
    // The whole stress that belongs to a strain counted from no stress.
    Stress stress(const Stress& strain) const {
        const Stress c = unit_ * strain;
        const double square = factor_ * factor_ * strain.dot(c);
        const double q = energy_->stress_square(*parameters_, square);
        return factor_ * energy_->secant(*parameters_, q).value * c;
    }
    // Stored by the strain that belongs to the stress [J/m3].
    double stored(const State& s) const {
        return s.q / s.modulus - energy_->complementary(*parameters_, s.q) / factor_;
    }

    // Of the strain at a held stress by variation k.
    Stress strain_rate(const State& s, int k) const {
        const Rate& rate = rates_[static_cast<std::size_t>(k)];
        const Stress turned = rate.unit * s.direction;
        return -(compliance_ * turned + (log_modulus_rate(rate, s, -s.direction.dot(turned))) * s.direction) /
               s.modulus;
    }
    // Of modulus and tangent unit stiffness by variation k, where the stress changes by this.
    struct TangentRate {
        double modulus = 0.0;
        Matrix unit;
    };
    TangentRate tangent_rate(const State& s, const Stress& stress, const Stress& stress_rate, int k) const {
        const Rate& rate = rates_[static_cast<std::size_t>(k)];
        const double q_rate = 2.0 * s.direction.dot(stress_rate) - s.direction.dot(rate.unit * s.direction);
        const double h = s.secant.hardening;
        const double h_rate = s.secant.d_hardening * q_rate + own_rate(rate, s).hardening;
        const double left = 1.0 - h * s.q;
        const double along_rate = (h_rate + h * h * q_rate) / (left * left);
        TangentRate r;
        r.modulus = s.modulus * log_modulus_rate(rate, s, q_rate);
        r.unit = rate.unit + along_rate * (stress * stress.transpose()) +
                 s.along * (stress_rate * stress.transpose() + stress * stress_rate.transpose());
        return r;
    }

private:
    static Matrix cut(const mechanics::Stiffness<6>& c) { return c.template topLeftCorner<N, N>(); }
    material::Energy::SecantRate own_rate(const Rate& rate, const State& s) const {
        return rate.parameter ? energy_->secant_rate(*parameters_, s.q, s.secant, *rate.parameter)
                              : material::Energy::SecantRate{};
    }
    double log_modulus_rate(const Rate& rate, const State& s, double q_rate) const {
        return rate.factor + s.secant.hardening / 2.0 * q_rate + own_rate(rate, s).value / s.secant.value;
    }

    const material::Energy* energy_;
    const std::vector<double>* parameters_;
    double factor_;
    Matrix unit_, compliance_;
    std::vector<Rate> rates_;
};

// Those of a prepared run, by the numbers of the points of its active elements.
template <class Element>
class EnergyPoints {
public:
    static constexpr int N = Element::voigt;
    using Stress = typename Element::Stress;
    using Material = EnergyMaterial<N>;

    template <class Work>
    void prepare(const Work& w) {
        materials_.clear();
        material_of_.clear();
        const auto has_energy = [](const LayerMaterial& layer) { return layer.law->energy() != nullptr; };
        if (std::none_of(w.layers->begin(), w.layers->end(), has_energy)) {
            return;
        }
        count_ = w.count();
        material_of_.assign(static_cast<std::size_t>(w.points()), -1);
        initial_strain_.resize(material_of_.size());
        initial_strain_rate_.resize(material_of_.size() * static_cast<std::size_t>(count_));
        std::vector<int> of_layer(w.layers->size(), -1); // where nothing varies within it
        for (int q = 0; q < w.points(); ++q) {
            const int e = w.active[static_cast<std::size_t>(q / Element::gauss)];
            const LayerMaterial& layer = w.layer_of(e);
            if (!has_energy(layer)) {
                continue;
            }
            const int number = w.topology->layer[static_cast<std::size_t>(e)];
            int& known = of_layer[static_cast<std::size_t>(number)];
            if (known < 0 || !layer.fields.empty()) {
                known = static_cast<int>(materials_.size());
                materials_.emplace_back(layer, number, position_of(*w.model, e, q % Element::gauss), *w.variations);
            }
            material_of_[static_cast<std::size_t>(q)] = known;
            const auto initial = at(q)->at(w.initial[static_cast<std::size_t>(q)]);
            initial_strain_[static_cast<std::size_t>(q)] = Material::strain(initial);
            for (int k = 0; k < count_; ++k) {
                const std::size_t qk = static_cast<std::size_t>(q) * static_cast<std::size_t>(count_) + k;
                initial_strain_rate_[qk] = at(q)->tangent_compliance(initial) * w.initial_rate[qk] / initial.modulus +
                                           at(q)->strain_rate(initial, k);
            }
        }
    }

    // None: the law there has no energy.
    const Material* at(int q) const {
        const int m = material_of_.empty() ? -1 : material_of_[static_cast<std::size_t>(q)];
        return m < 0 ? nullptr : &materials_[static_cast<std::size_t>(m)];
    }
    bool empty() const { return material_of_.empty(); }

    // Values of a strain of the load at point q: the stress of the load, its state, and by variation k, where the
    // strain changes by this, its rate.
    struct Answer {
        Stress whole;
        typename Material::State state;
    };
    Answer answer(int q, const Stress& strain) const {
        Answer a;
        a.whole = at(q)->stress(initial_strain_[static_cast<std::size_t>(q)] + strain);
        a.state = at(q)->at(a.whole);
        return a;
    }
    // Without that of the initial stress itself.
    Stress whole_rate(int q, const Answer& a, const Stress& strain_rate, int k) const {
        const auto qk = static_cast<std::size_t>(q) * static_cast<std::size_t>(count_) + static_cast<std::size_t>(k);
        const Stress rate = strain_rate + initial_strain_rate_[qk] - at(q)->strain_rate(a.state, k);
        return at(q)->times_tangent(a.state, a.whole, rate);
    }
    // The strain of the load that belongs to a stress of the load.
    Stress strain_of_load(int q, const Stress& whole) const {
        return Material::strain(at(q)->at(whole)) - initial_strain_[static_cast<std::size_t>(q)];
    }

private:
    int count_ = 0;
    std::vector<Material> materials_;
    std::vector<int> material_of_;
    std::vector<Stress> initial_strain_;
    std::vector<Stress> initial_strain_rate_; // [point * variations + k]
};

} // namespace pave::fe
