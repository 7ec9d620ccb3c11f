#include "pavement/buried.h"
#include "pavement/effects/effect.h"
#include "reduced/calibration.h"
#include "reduced/cubature.h"
#include "reduced/projection.h"
#include "reduced/pulse_build.h"
#include "reduced/reduced_load.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace pave::reduced {
namespace {

using namespace pavement;

// The record of a run of the full model: the rates along its load path, and its readings.
struct Snapshots {
    std::vector<Eigen::VectorXd> rates;  // d(displacement)/d(load factor)
    std::vector<Eigen::VectorXd> moduli; // at the Gauss points of the stress-dependent elements
    std::vector<double> lengths;         // in load factor, that each rate stands for
    std::vector<fe::LayerMaterial> layers;
    Eigen::VectorXd force;
    Eigen::MatrixXd duals;      // displacements under what the sensors read as a load, at the end
    std::vector<double> values; // of the sensors
    std::size_t sample = 0;
};

template <class Kind>
class Builder {
public:
    using Element = typename Kind::Element;
    static constexpr int N = Element::voigt;
    using Strains = Eigen::Matrix<double, N, Eigen::Dynamic>;

    Builder(const Case& nominal, int load, std::span<const Case> samples, const BuildSettings& settings,
            const ForEach& for_each)
        : nominal_(nominal),
          load_(load),
          samples_(samples),
          settings_(settings),
          for_each_(for_each),
          own_(with_effects(nominal, load)),
          mesh_(Kind::nominal_mesh(own_, load)),
          model_(fe::make_model(mesh_, linear_layers(own_))),
          active_(stress_dependent_elements(own_, model_)) {
        for (const Sensor& sensor : own_.sensors) {
            observations_.push_back(sensor.load == load
                                        ? observe(sensor, mesh_, model_, mesh_, incompressible_layers(own_))
                                        : Observation<Element>{});
        }
    }

    Outcome<Basis> build(BuildReport& report) {
        const auto calibration = static_cast<std::size_t>(settings_.calibration);
        if (samples_.size() < 2 * calibration) {
            return Failure{Status::failed, "too few samples to build a reduced model from"};
        }
        const std::size_t candidates = samples_.size() - calibration;
        std::vector<char> used(candidates, 0);
        std::vector<std::size_t> chosen;
        for (std::size_t i = 0; i < std::min<std::size_t>(first_runs, candidates); ++i) {
            chosen.push_back(i);
        }
        Basis basis;
        for (;;) {
            for (const std::size_t i : chosen) {
                used[i] = 1;
            }
            add_runs(chosen);
            report.full_runs += static_cast<int>(chosen.size());
            if (runs_.size() < 2) {
                return Failure{Status::failed, "the full model has no answer at the samples of the build"};
            }
            basis = make_basis();
            // Where the estimate is worst, the full model is run next.
            const auto trial = make_load_model(nominal_, load_, basis);
            std::vector<double> estimate(candidates, -1.0);
            for_each_(candidates, [&](std::size_t i) {
                if (used[i] == 0) {
                    estimate[i] = indicator(*trial, samples_[i]);
                }
            });
            std::vector<std::size_t> order(candidates);
            std::iota(order.begin(), order.end(), 0);
            std::stable_sort(order.begin(), order.end(),
                             [&](std::size_t a, std::size_t b) { return estimate[a] > estimate[b]; });
            const int left = settings_.most_runs - settings_.calibration - report.full_runs;
            if (left < runs_a_round || estimate[order[0]] < settings_.tolerance) {
                break;
            }
            const int next = std::min(left, std::max(runs_a_round, report.full_runs / 2));
            chosen.assign(order.begin(), order.begin() + next);
        }
        report.modes = static_cast<int>(basis.modes.cols());
        report.points = static_cast<int>(basis.points.size());
        if (!judge(basis, candidates, report)) {
            return Failure{Status::failed, "the reduced model has no answer at the samples of the build"};
        }
        return basis;
    }

private:
    static constexpr std::size_t first_runs = 12;
    static constexpr int runs_a_round = 8;

    std::optional<Snapshots> full_run(const Case& values, bool with_path) const {
        const auto possible = as_met(values, load_);
        if (!possible) {
            return std::nullopt;
        }
        const Case& c = *possible;
        Snapshots s;
        s.layers = materials_of(c);
        const Load& load = c.loads[static_cast<std::size_t>(load_)];
        s.force = load.pressure * load.factor * Kind::unit_load(mesh_, model_, load);
        fe::Solver<Element> solver(model_);
        std::vector<double> factors;
        if (with_path) {
            solver.on_step([&](double factor, const Eigen::VectorXd& rate, const Eigen::VectorXd& modulus) {
                factors.push_back(factor);
                s.rates.push_back(rate);
                s.moduli.push_back(modulus);
            });
        }
        const auto solved = solver.incremental(s.layers, s.force, {}, c.settings.solver);
        if (!solved) {
            return std::nullopt;
        }
        for (std::size_t i = 0; i < factors.size(); ++i) { // half the steps before and after
            const double before = i > 0 ? factors[i] - factors[i - 1] : 0.0;
            const double after = i + 1 < factors.size() ? factors[i + 1] - factors[i] : 0.0;
            s.lengths.push_back((before + after) / 2.0);
        }
        if (with_path && most_dual_modes() > 0) {
            std::vector<Observation<Element>> own;
            for (std::size_t i = 0; i < c.sensors.size(); ++i) {
                if (c.sensors[i].load == load_) {
                    own.push_back(observations_[i]);
                }
            }
            s.duals = as_loads(model_, own, s.layers, solved->modulus);
            if (!solver.solve_at_end(s.duals)) {
                return std::nullopt;
            }
        }
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            const auto& o = observations_[i];
            s.values.push_back(c.sensors[i].load != load_ ? 0.0
                               : o.on_stress.empty()      ? o.of_displacement(solved->displacement.data())
                                                          : o.of_stress(solved->stress, 1, 0));
        }
        return s;
    }

    void add_runs(const std::vector<std::size_t>& chosen) {
        std::vector<std::optional<Snapshots>> done(chosen.size());
        for_each_(chosen.size(), [&](std::size_t i) { done[i] = full_run(samples_[chosen[i]], true); });
        for (std::size_t i = 0; i < done.size(); ++i) {
            if (done[i]) {
                done[i]->sample = chosen[i];
                runs_.push_back(std::move(*done[i]));
            }
        }
    }

    // A case as the load model of a run meets it; the largest estimate over the sensors, relative.
    double indicator(const LoadModel& reduced, const Case& values) const {
        const auto reading = read(reduced, values);
        if (!reading) {
            return -1.0;
        }
        const auto scale = scales(own_, load_, reading->values);
        double largest = 0.0;
        for (std::size_t i = 0; i < scale.size(); ++i) {
            largest = std::max(largest, reading->errors[i] / scale[i]);
        }
        return largest;
    }
    std::optional<LoadModel::Reading> read(const LoadModel& reduced, const Case& values) const {
        const auto possible = as_met(values, load_);
        if (!possible) {
            return std::nullopt;
        }
        const Case& c = *possible;
        const auto workspace = reduced.make_workspace();
        auto outcome = reduced.run(c, materials_of(c), {}, {}, *workspace);
        if (!outcome) {
            return std::nullopt;
        }
        return std::move(outcome).value();
    }

    Basis make_basis() const {
        Basis basis;
        // Snapshots: what each rate adds to the displacement, relative to all of it in energy.
        std::vector<std::pair<std::size_t, std::size_t>> which;
        for (std::size_t r = 0; r < runs_.size(); ++r) {
            for (std::size_t s = 0; s < runs_[r].rates.size(); ++s) {
                which.emplace_back(r, s);
            }
        }
        Eigen::MatrixXd snapshots(model_.free_unknowns(), static_cast<Eigen::Index>(which.size()));
        for (std::size_t k = 0; k < which.size(); ++k) {
            const auto& run = runs_[which[k].first];
            snapshots.col(static_cast<Eigen::Index>(k)) = run.lengths[which[k].second] * run.rates[which[k].second];
        }
        const Eigen::SparseMatrix<double> metric =
            energy(model_, runs_.front().layers, runs_.front().moduli.back().mean());
        Eigen::MatrixXd gram = snapshots.transpose() * Eigen::MatrixXd(metric * snapshots);
        // A run counts as much as another: by the energy of its own sum.
        Eigen::VectorXd scale(gram.rows());
        for (std::size_t begin = 0; begin < which.size();) {
            std::size_t end = begin;
            while (end < which.size() && which[end].first == which[begin].first) {
                ++end;
            }
            const auto from = static_cast<Eigen::Index>(begin);
            const auto size = static_cast<Eigen::Index>(end - begin);
            scale.segment(from, size).setConstant(1.0 / std::sqrt(gram.block(from, from, size, size).sum()));
            begin = end;
        }
        basis.modes = proper_modes(snapshots, gram, scale, most_modes(), mode_tolerance);
        const Eigen::Index modes = basis.modes.cols();
        if (most_dual_modes() > 0) {
            add_dual_modes(metric, basis.modes);
            basis.coarse = static_cast<int>(modes);
        } else {
            basis.coarse = static_cast<int>(modes) * 4 / 5;
        }
        make_cubature(basis, which);
        return basis;
    }

    // The error that a projection makes in a reading is the product of two errors, that of the displacement and that of
    // the dual one, the answer to the reading as a load: both belong to the space (Becker and Rannacher 2001). What the
    // modes lack of the duals, by proper orthogonal decomposition, each dual relative to its own energy.
    void add_dual_modes(const Eigen::SparseMatrix<double>& metric, Eigen::MatrixXd& modes) const {
        const Eigen::Index each = runs_.front().duals.cols();
        const auto known = static_cast<Eigen::Index>(runs_.size());
        const Eigen::Index taken = std::clamp<Eigen::Index>(most_dual_fields / each, 1, known); // spread over the runs
        const Eigen::Index count = taken * each;
        Eigen::MatrixXd fields(model_.free_unknowns(), count);
        for (Eigen::Index i = 0; i < taken; ++i) {
            fields.middleCols(i * each, each) = runs_[static_cast<std::size_t>(i * known / taken)].duals;
        }
        for (auto field : fields.colwise()) {
            field /= std::sqrt(field.dot(metric * field));
        }
        const auto leave_out = [&metric, &modes](Eigen::MatrixXd& of) {
            of -= modes * (modes.transpose() * Eigen::MatrixXd(metric * of));
        };
        leave_out(fields);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
            Eigen::MatrixXd(fields.transpose() * Eigen::MatrixXd(metric * fields)));
        const Eigen::VectorXd& lack = eigen.eigenvalues(); // increasing
        Eigen::Index duals = 0;
        while (duals < std::min(most_dual_modes(), count) && lack[count - 1 - duals] > mode_tolerance) {
            ++duals;
        }
        Eigen::MatrixXd added = fields * eigen.eigenvectors().rightCols(duals).rowwise().reverse();
        leave_out(added);
        for (auto field : added.colwise()) {
            field /= std::sqrt(field.dot(metric * field));
        }
        modes.conservativeResize(Eigen::NoChange, modes.cols() + duals);
        modes.rightCols(duals) = added;
    }

    // Points and weights that give the forces of the snapshots on the modes. Forces of a snapshot are relative to the
    // work of the load, and count as what happens over its step.
    void make_cubature(Basis& basis, const std::vector<std::pair<std::size_t, std::size_t>>& which) const {
        std::vector<ForceSnapshot> forces;
        for (const auto& [r, step] : which) {
            const auto& run = runs_[r];
            double total = 0.0;
            for (std::size_t s = 0; s < run.rates.size(); ++s) {
                total += run.lengths[s] * run.force.dot(run.rates[s]);
            }
            const double work = run.force.dot(run.rates[step]);
            const double own = std::sqrt(run.lengths[step] * work / total);
            forces.push_back({&run.rates[step], &run.moduli[step], &run.layers, own / std::sqrt(work)});
        }
        basis.points =
            cubature(model_, active_, basis.modes, std::move(forces), most_points(), settings_.seed, for_each_);
    }

    // At the runs that the modes are from, then at the samples that the build has not seen (from `first`), where both
    // have an answer. The second: how many are of the modes.
    std::pair<std::vector<Comparison>, std::size_t> compare(const Basis& basis, std::size_t first) const {
        const auto reduced = make_load_model(nominal_, load_, basis);
        std::vector<std::optional<Comparison>> at(runs_.size() + samples_.size() - first);
        for_each_(at.size(), [&](std::size_t k) {
            const bool of_modes = k < runs_.size();
            const Case& sample = samples_[of_modes ? runs_[k].sample : first + k - runs_.size()];
            const auto unseen = of_modes ? std::nullopt : full_run(sample, false);
            const Snapshots* full = of_modes ? &runs_[k] : unseen ? &*unseen : nullptr;
            auto quick = read(*reduced, sample);
            if (full != nullptr && quick) {
                at[k] = Comparison{.layers = full->layers,
                                   .load = as_met(sample, load_)->loads[static_cast<std::size_t>(load_)],
                                   .full = full->values,
                                   .quick = std::move(*quick)};
            }
        });
        std::vector<Comparison> both;
        std::size_t of_modes = 0;
        for (std::size_t k = 0; k < at.size(); ++k) {
            if (at[k]) {
                both.push_back(std::move(*at[k]));
                of_modes += k < runs_.size() ? 1 : 0;
            }
        }
        return {std::move(both), of_modes};
    }

    // The quality of the estimates, learnt. False: there is an answer at none of the samples from `first`.
    bool judge(Basis& basis, std::size_t first, BuildReport& report) const {
        const auto [runs, of_modes] = compare(basis, first);
        report.full_runs += static_cast<int>(samples_.size() - first);
        if (of_modes == 0 || runs.size() == of_modes) {
            return false;
        }
        report.error_95 = calibrate(basis, own_, load_, runs, of_modes, for_each_);
        return true;
    }

    static constexpr Eigen::Index most_dual_fields = 240;
    // Deflections need fewer modes than what is read within a layer.
    bool reads_within() const {
        return std::any_of(own_.sensors.begin(), own_.sensors.end(),
                           [&](const Sensor& s) { return s.load == load_ && is_buried(s); });
    }
    Eigen::Index most_modes() const { return reads_within() ? 64 : 16; }
    // The dual of a strain is sharper than any mode: as many modes more serve it better.
    Eigen::Index most_dual_modes() const { return reads_within() ? 0 : 8; }
    int most_points() const { return reads_within() ? 220 : 64; }

    const Case& nominal_;
    int load_;
    std::span<const Case> samples_;
    BuildSettings settings_;
    const ForEach& for_each_;
    Case own_;
    typename Kind::Mesh mesh_;
    fe::Model<Element> model_;
    std::vector<int> active_; // stress-dependent elements
    std::vector<Observation<Element>> observations_;
    std::vector<Snapshots> runs_;
};

} // namespace

Outcome<Basis> build(const Case& nominal, int load, std::span<const Case> samples, const BuildSettings& settings,
                     const ForEach& for_each, BuildReport* report) {
    BuildReport own;
    BuildReport& said = report != nullptr ? *report : own;
    said = {};
    if (nominal.loads[static_cast<std::size_t>(load)].is_pulse()) {
        return build_pulse(nominal, load, samples, settings, for_each, said);
    }
    if (nominal.loads[static_cast<std::size_t>(load)].is_axisymmetric()) {
        return Builder<Axisymmetric>(nominal, load, samples, settings, for_each).build(said);
    }
    return Builder<Solid>(nominal, load, samples, settings, for_each).build(said);
}

} // namespace pave::reduced
