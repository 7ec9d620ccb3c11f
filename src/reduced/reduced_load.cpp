#include "reduced/reduced_load.h"

#include "reduced/projection.h"
#include "reduced/reduced_pulse.h"

#include "fe/load_path.h"
#include "pavement/effects/effect.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pave::reduced {

using namespace pavement;

namespace {

template <class Kind>
class ReducedLoad final : public LoadModel {
public:
    using Element = typename Kind::Element;
    static constexpr int N = Element::voigt;
    using Stress = typename Element::Stress;
    using Stiffness = mechanics::Stiffness<N>;

    ReducedLoad(const Case& nominal, int load, Basis basis)
        : load_(load),
          basis_(std::move(basis)),
          nominal_(with_effects(nominal, load)),
          mesh_(Kind::nominal_mesh(nominal_, load)),
          model_(fe::make_model(mesh_, linear_layers(nominal_))),
          breaks_(Kind::breaks(nominal_, load)),
          unit_load_(basis_.modes.transpose() * Kind::unit_load(mesh_, model_, nominal_.loads[load])) {
        for (const Sensor& sensor : nominal_.sensors) {
            observations_.push_back(
                sensor.load == load ? project(observe(sensor, mesh_, model_, mesh_, incompressible_layers(nominal_)))
                                    : Reduced{});
        }
        linear_ = projected_linear_layers(nominal_, model_, basis_.modes);
        project_points();
    }

    std::unique_ptr<Workspace> make_workspace(Lent&) const override { return std::make_unique<Own>(); }
    int unknowns() const override { return modes(); }

    Outcome<Reading> run(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                         const std::vector<fe::Variation>& variations, const std::vector<Neighbours>& moving,
                         Workspace& workspace) const override;

    Outcome<Fields> fields(const Case&, const std::vector<fe::LayerMaterial>&, Workspace&) const override {
        return Failure{Status::failed, "a reduced model knows readings, not fields"};
    }

private:
    // A functional on the factors of the modes, and on the stress of points that are followed.
    struct Reduced {
        Eigen::RowVectorXd on_modes;
        struct AtPoint {
            std::size_t point; // of points_ or linear_points_
            bool linear;
            Stress weight;
        };
        std::vector<AtPoint> on_stress;
    };
    struct Point {
        int gauss = 0;
        int layer = 0;
        double weight = 0.0; // 0: only followed, for what is read there
        double depth = 0.0;
    };
    struct State {
        Eigen::VectorXd a;      // factors of the modes
        Eigen::VectorXd stress; // N of each point
        // The errors of the coarse model: of a, and of the N stresses of each point that is only followed.
        Eigen::VectorXd gap, stress_gap;
        Eigen::MatrixXd da, d_stress; // a column a variation

        void set_zero(Eigen::Index modes, Eigen::Index points, Eigen::Index followed, Eigen::Index count) {
            a.setZero(modes);
            gap.setZero(modes);
            stress.setZero(N * points);
            stress_gap.setZero(N * followed);
            da.setZero(modes, count);
            d_stress.setZero(N * points, count);
        }
        void set_sum(const State& from, std::span<const double> factors, std::span<const State* const> rates) {
            *this = from;
            for (std::size_t j = 0; j < rates.size(); ++j) {
                a += factors[j] * rates[j]->a;
                stress += factors[j] * rates[j]->stress;
                gap += factors[j] * rates[j]->gap;
                stress_gap += factors[j] * rates[j]->stress_gap;
                da += factors[j] * rates[j]->da;
                d_stress += factors[j] * rates[j]->d_stress;
            }
        }
    };
    struct Own : Workspace {
        fe::LoadPath<State> path;
        // Squares of the strains of the modes at the points of the cubature, in the metric of C, a column a point:
        // lower triangles, column by column.
        Eigen::MatrixXf squares;
        Eigen::VectorXf stiffness; // weight E of each point
        Eigen::VectorXf packed;    // lower triangle of the part of the matrix from stress-dependent layers
        Eigen::MatrixXd matrix;
        Eigen::LLT<Eigen::MatrixXd> factor;
        Eigen::VectorXd modulus, strain;
        Eigen::VectorXf weight, force, d_modes, d_strain; // of derivatives
    };

    int modes() const { return static_cast<int>(basis_.modes.cols()); }

    Eigen::Matrix<double, N, Eigen::Dynamic> strains(int gauss) const {
        return fe::strains(model_, gauss, basis_.modes);
    }

    Reduced project(const Observation<Element>& o) {
        Reduced r;
        r.on_modes = Eigen::RowVectorXd::Zero(modes());
        for (const auto& [unknown, weight] : o.on_displacement) {
            r.on_modes += weight * basis_.modes.row(unknown);
        }
        for (const auto& [gauss, weight, direction] : o.on_stress) {
            const int layer = model_.topology->layer[static_cast<std::size_t>(gauss / Element::gauss)];
            const bool linear = !nominal_.layers[static_cast<std::size_t>(layer)].law->stress_dependent();
            auto& list = linear ? linear_points_ : followed_;
            auto known =
                std::find_if(list.begin(), list.end(), [&, g = gauss](const Point& p) { return p.gauss == g; });
            if (known == list.end()) {
                known = list.insert(list.end(), {gauss, layer, 0.0, model_.depth[static_cast<std::size_t>(gauss)]});
            }
            r.on_stress.push_back({static_cast<std::size_t>(known - list.begin()), linear, weight * direction});
        }
        return r;
    }

    void project_points() {
        for (const auto& p : basis_.points) {
            points_.push_back({p.gauss, model_.topology->layer[static_cast<std::size_t>(p.gauss / Element::gauss)],
                               p.weight, model_.depth[static_cast<std::size_t>(p.gauss)]});
        }
        cubature_ = points_.size();
        points_.insert(points_.end(), followed_.begin(), followed_.end());
        strains_.resize(N * static_cast<Eigen::Index>(points_.size()), modes());
        for (std::size_t q = 0; q < points_.size(); ++q) {
            strains_.middleRows<N>(N * static_cast<Eigen::Index>(q)) = strains(points_[q].gauss);
        }
        strains_single_ = strains_.cast<float>();
        for (const Point& p : linear_points_) {
            linear_strains_.push_back(strains(p.gauss));
        }
    }

    static double linear_modulus(const fe::LayerMaterial& layer) {
        return layer.law->modulus(layer.parameters, {}).value;
    }
    Eigen::MatrixXd linear_stiffness(std::size_t layer, const Stiffness& d) const {
        Eigen::MatrixXd k = Eigen::MatrixXd::Zero(modes(), modes());
        std::size_t entry = 0;
        for (int i = 0; i < N; ++i) {
            for (int j = i; j < N; ++j, ++entry) {
                if (d(i, j) != 0.0) {
                    k += d(i, j) * linear_[layer][entry];
                }
            }
        }
        return k;
    }

    int load_;
    Basis basis_;
    Case nominal_;
    typename Kind::Mesh mesh_;
    fe::Model<Element> model_;
    Lines breaks_;
    Eigen::VectorXd unit_load_;
    std::vector<Point> linear_points_, followed_;
    std::vector<Reduced> observations_;
    std::vector<std::vector<Eigen::MatrixXd>> linear_;
    std::vector<Point> points_; // those of the cubature first
    std::size_t cubature_ = 0;  // so many
    Eigen::MatrixXd strains_;   // N rows a point
    Eigen::MatrixXf strains_single_;
    std::vector<Eigen::Matrix<double, N, Eigen::Dynamic>> linear_strains_;
};

template <class Kind>
Outcome<LoadModel::Reading> ReducedLoad<Kind>::run(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                                                   const std::vector<fe::Variation>& variations,
                                                   const std::vector<Neighbours>& moving, Workspace& workspace) const {
    const Load& load = values.loads[static_cast<std::size_t>(load_)];
    if (!moving.empty() || Kind::breaks(values, load_) != breaks_ ||
        load.pressure_shape != nominal_.loads[static_cast<std::size_t>(load_)].pressure_shape ||
        !reads_the_same(values.sensors, nominal_.sensors)) {
        return does_not_cover();
    }
    Own& own = static_cast<Own&>(workspace);
    const auto points = static_cast<Eigen::Index>(points_.size());
    const auto cubature = static_cast<Eigen::Index>(cubature_);
    const auto count = static_cast<Eigen::Index>(variations.size());
    const Eigen::VectorXd force = load.pressure * load.factor * unit_load_;

    // Linear layers.
    Eigen::MatrixXd linear = Eigen::MatrixXd::Zero(modes(), modes());
    std::vector<Stiffness> units(layers.size());
    for (std::size_t l = 0; l < layers.size(); ++l) {
        units[l] = layers[l].template unit_stiffness<N>();
        if (!linear_[l].empty()) {
            linear += linear_stiffness(l, linear_modulus(layers[l]) * units[l]);
        }
    }
    // The change by each variation: the stiffness of a linear layer, C of a stress-dependent one, the load.
    std::vector<Eigen::MatrixXd> linear_rate(variations.size());
    std::vector<Stiffness> linear_d_rate(variations.size(), Stiffness::Zero());
    std::vector<Stiffness> unit_rate(variations.size(), Stiffness::Zero());
    std::vector<char> turns(variations.size(), 0);
    Eigen::MatrixXd load_rate = Eigen::MatrixXd::Zero(modes(), count);
    for (std::size_t k = 0; k < variations.size(); ++k) {
        const fe::Variation& v = variations[k];
        switch (v.kind) {
        case fe::Variation::Kind::law_parameter: {
            const auto l = static_cast<std::size_t>(v.layer);
            unit_rate[k] = layers[l].template unit_stiffness_rate<N>(v.index);
            if (!linear_[l].empty()) {
                linear_d_rate[k] = layers[l].law->modulus_derivative(layers[l].parameters, {}, {}, v.index) * units[l] +
                                   linear_modulus(layers[l]) * unit_rate[k];
                linear_rate[k] = linear_stiffness(l, linear_d_rate[k]);
            } else {
                turns[k] = unit_rate[k].isZero(0.0) ? 0 : 1;
            }
            break;
        }
        case fe::Variation::Kind::load_factor: load_rate.col(static_cast<Eigen::Index>(k)) = force; break;
        case fe::Variation::Kind::unit_weight:
        case fe::Variation::Kind::k0:
        case fe::Variation::Kind::residual_stress:
        case fe::Variation::Kind::damping:
        case fe::Variation::Kind::time_shift:
        case fe::Variation::Kind::duration: break; // nothing here relaxes or moves
        default: return Failure{Status::failed, "the reduced model does not cover this derivative"};
        }
    }
    // Points: squares of strains, initial stress and its rates.
    own.squares.resize(modes() * (modes() + 1) / 2, cubature);
    std::vector<Eigen::Matrix<double, N, N>> roots(layers.size());
    for (std::size_t l = 0; l < layers.size(); ++l) {
        roots[l] = Eigen::LLT<Eigen::MatrixXd>(Eigen::MatrixXd(units[l])).matrixU();
    }
    std::vector<Stress> initial(points_.size());
    std::vector<Stress> initial_rate(points_.size() * variations.size());
    for (std::size_t q = 0; q < points_.size(); ++q) {
        const Point& p = points_[q];
        const auto& layer = layers[static_cast<std::size_t>(p.layer)];
        const auto row = N * static_cast<Eigen::Index>(q);
        if (q < cubature_) {
            const Eigen::Matrix<float, N, Eigen::Dynamic> rows =
                (roots[static_cast<std::size_t>(p.layer)] * strains_.middleRows<N>(row)).template cast<float>();
            float* square = own.squares.col(static_cast<Eigen::Index>(q)).data();
            for (Eigen::Index j = 0; j < modes(); ++j) {
                const Eigen::Index length = modes() - j;
                Eigen::Map<Eigen::VectorXf>(square, length).noalias() =
                    rows.rightCols(length).transpose() * rows.col(j);
                square += length;
            }
        }
        initial[q] = layer.template initial_stress<N>(p.depth);
        for (std::size_t k = 0; k < variations.size(); ++k) {
            initial_rate[q * variations.size() + k] =
                fe::initial_stress_rate<N>(layers, p.layer, p.depth, variations[k]);
        }
    }

    auto& path = own.path;
    path.set_zero(modes(), points, points - cubature, count);
    own.modulus.resize(points);
    own.stiffness.resize(cubature);
    own.weight.resize(N * cubature);
    for (Eigen::Index q = 0; q < cubature; ++q) {
        own.weight.template segment<N>(N * q).setConstant(
            static_cast<float>(points_[static_cast<std::size_t>(q)].weight));
    }
    const auto rate = [&](const State& x, int number) {
        State& out = path.slope[number];
        for (std::size_t q = 0; q < points_.size(); ++q) {
            const auto row = N * static_cast<Eigen::Index>(q);
            const auto& layer = layers[static_cast<std::size_t>(points_[q].layer)];
            const Stress total = initial[q] + x.stress.template segment<N>(row);
            const auto at = mechanics::invariants<N>(total);
            const auto m = layer.law->modulus(layer.parameters, at);
            own.modulus[static_cast<Eigen::Index>(q)] = m.value;
            if (count > 0) {
                const Stress gradient = fe::modulus_gradient<N>(m, at, total);
                for (Eigen::Index k = 0; k < count; ++k) {
                    const auto& v = variations[static_cast<std::size_t>(k)];
                    double d = gradient.dot(initial_rate[q * variations.size() + static_cast<std::size_t>(k)] +
                                            x.d_stress.template block<N, 1>(row, k));
                    if (v.kind == fe::Variation::Kind::law_parameter && v.layer == points_[q].layer) {
                        d += layer.law->modulus_derivative(layer.parameters, at, m, v.index);
                    }
                    out.d_stress(row, k) = d / m.value; // for the moment
                }
            }
            if (q < cubature_) {
                own.stiffness[static_cast<Eigen::Index>(q)] = static_cast<float>(points_[q].weight * m.value);
            }
        }
        own.packed.noalias() = own.squares * own.stiffness;
        own.matrix = linear;
        const float* packed = own.packed.data();
        for (Eigen::Index j = 0; j < modes(); ++j) {
            const Eigen::Index length = modes() - j;
            own.matrix.col(j).tail(length) += Eigen::Map<const Eigen::VectorXf>(packed, length).template cast<double>();
            packed += length;
        }
        own.factor.compute(own.matrix);
        if (own.factor.info() != Eigen::Success) {
            return false;
        }
        out.a = own.factor.solve(force);
        // The coarse model has the leading block of the matrix, and of its factor.
        const auto& lower = own.factor.matrixLLT();
        Eigen::VectorXd coarse = force.head(basis_.coarse);
        const auto leading = lower.topLeftCorner(basis_.coarse, basis_.coarse);
        leading.template triangularView<Eigen::Lower>().solveInPlace(coarse);
        leading.template triangularView<Eigen::Lower>().transpose().solveInPlace(coarse);
        out.gap = out.a;
        out.gap.head(basis_.coarse) -= coarse;
        own.strain.noalias() = strains_ * out.a;
        for (std::size_t q = 0; q < points_.size(); ++q) {
            const auto row = N * static_cast<Eigen::Index>(q);
            const auto& c = units[static_cast<std::size_t>(points_[q].layer)];
            const double e = own.modulus[static_cast<Eigen::Index>(q)];
            const Stress unit_stress = c * own.strain.template segment<N>(row);
            out.stress.template segment<N>(row) = e * unit_stress;
            for (Eigen::Index k = 0; k < count; ++k) {
                const double relative = out.d_stress(row, k);
                auto d = out.d_stress.template block<N, 1>(row, k);
                d = relative * out.stress.template segment<N>(row);
                if (turns[static_cast<std::size_t>(k)] != 0 &&
                    variations[static_cast<std::size_t>(k)].layer == points_[q].layer) {
                    d += e * (unit_rate[static_cast<std::size_t>(k)] * own.strain.template segment<N>(row));
                }
            }
        }
        for (std::size_t q = cubature_; q < points_.size(); ++q) {
            const auto row = N * static_cast<Eigen::Index>(q);
            out.stress_gap.template segment<N>(row - N * cubature) = own.modulus[static_cast<Eigen::Index>(q)] *
                                                                     units[static_cast<std::size_t>(points_[q].layer)] *
                                                                     (strains_.middleRows<N>(row) * out.gap);
        }
        if (count == 0) {
            return true;
        }
        out.da = load_rate;
        for (std::size_t k = 0; k < variations.size(); ++k) {
            if (linear_rate[k].size() > 0) {
                out.da.col(static_cast<Eigen::Index>(k)).noalias() -= linear_rate[k] * out.a;
            }
        }
        // Single precision is enough for derivatives.
        for (Eigen::Index k = 0; k < count; ++k) {
            own.force = out.d_stress.col(k).head(N * cubature).template cast<float>().cwiseProduct(own.weight);
            own.d_modes.noalias() = strains_single_.topRows(N * cubature).transpose() * own.force;
            out.da.col(k) -= own.d_modes.template cast<double>();
        }
        own.factor.solveInPlace(out.da);
        for (Eigen::Index k = 0; k < count; ++k) {
            own.d_modes = out.da.col(k).template cast<float>();
            own.d_strain.noalias() = strains_single_ * own.d_modes;
            for (std::size_t q = 0; q < points_.size(); ++q) {
                const auto row = N * static_cast<Eigen::Index>(q);
                const Stress d_strain = own.d_strain.template segment<N>(row).template cast<double>();
                out.d_stress.template block<N, 1>(row, k) +=
                    own.modulus[static_cast<Eigen::Index>(q)] *
                    (units[static_cast<std::size_t>(points_[q].layer)] * d_strain);
            }
        }
        return true;
    };
    const int steps = values.settings.solver.load_steps;
    const fe::Deadline deadline(values.settings.solver.time_limit);
    if (const auto failure = path.follow(steps, false, deadline, rate, [](double) {})) {
        return *failure;
    }

    Reading reading;
    reading.statistics.load_steps = steps;
    reading.values.assign(values.sensors.size(), 0.0);
    reading.errors.assign(values.sensors.size(), 0.0);
    reading.derivatives.setZero(static_cast<Eigen::Index>(values.sensors.size()), count);
    const State& end = path.now;
    for (std::size_t i = 0; i < values.sensors.size(); ++i) {
        if (values.sensors[i].load != load_) {
            continue;
        }
        const Reduced& o = observations_[i];
        const auto row = static_cast<Eigen::Index>(i);
        reading.values[i] = o.on_modes.dot(end.a);
        double gap = o.on_modes.dot(end.gap);
        reading.derivatives.row(row) = o.on_modes * end.da;
        for (const auto& [point, is_linear, weight] : o.on_stress) {
            if (!is_linear) {
                const auto at = N * static_cast<Eigen::Index>(cubature_ + point);
                reading.values[i] += weight.dot(end.stress.template segment<N>(at));
                gap += weight.dot(end.stress_gap.template segment<N>(N * static_cast<Eigen::Index>(point)));
                reading.derivatives.row(row) += weight.transpose() * end.d_stress.template middleRows<N>(at);
                continue;
            }
            const auto l = static_cast<std::size_t>(linear_points_[point].layer);
            const Stiffness d = linear_modulus(layers[l]) * units[l];
            const auto& b = linear_strains_[point];
            reading.values[i] += weight.dot(d * (b * end.a));
            gap += weight.dot(d * (b * end.gap));
            for (Eigen::Index k = 0; k < count; ++k) {
                const auto& v = variations[static_cast<std::size_t>(k)];
                reading.derivatives(row, k) += weight.dot(d * (b * end.da.col(k)));
                if (v.kind == fe::Variation::Kind::law_parameter && v.layer == static_cast<int>(l)) {
                    reading.derivatives(row, k) += weight.dot(linear_d_rate[static_cast<std::size_t>(k)] * (b * end.a));
                }
            }
        }
        reading.errors[i] = std::abs(gap);
    }
    std::vector<double> reaches(reading.errors.size(), 1.0);
    if (!basis_.correction.empty()) {
        reaches = correct(basis_, values, load_, layers, variations, reading);
    }
    const auto scale = scales(values, load_, reading.values);
    for (std::size_t i = 0; i < reading.errors.size(); ++i) {
        if (!basis_.floor.empty()) {
            reading.errors[i] = reaches[i] * (basis_.factor[i] * reading.errors[i] + basis_.floor[i] * scale[i]);
        }
        if (!std::isfinite(reading.values[i]) || !std::isfinite(reading.errors[i])) {
            return Failure{Status::failed, "the solution is not a finite number"};
        }
    }
    if (!reading.derivatives.allFinite()) {
        return Failure{Status::failed, "the derivatives are not finite numbers"};
    }
    return reading;
}

} // namespace

std::unique_ptr<const LoadModel> make_load_model(const Case& nominal, int load, Basis basis) {
    if (nominal.loads[static_cast<std::size_t>(load)].is_pulse()) {
        return make_pulse(nominal, load, std::move(basis));
    }
    if (nominal.loads[static_cast<std::size_t>(load)].is_axisymmetric()) {
        return std::make_unique<ReducedLoad<Axisymmetric>>(nominal, load, std::move(basis));
    }
    return std::make_unique<ReducedLoad<Solid>>(nominal, load, std::move(basis));
}

} // namespace pave::reduced
