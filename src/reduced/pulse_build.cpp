#include "reduced/pulse_build.h"

#include "pavement/effects/effect.h"
#include "pavement/pulse.h"
#include "reduced/cubature.h"
#include "reduced/projection.h"

#include <algorithm>
#include <cmath>

namespace pave::reduced {
namespace {

using namespace pavement;

// The record of a run of the full model.
struct Motion {
    std::vector<Eigen::VectorXd> fields; // displacements at some of its instants
    Eigen::MatrixXd modes;               // what they are made of, by their energy; of energy 1 the largest of them
    struct Acting {                      // at some of the instants
        Eigen::VectorXd field, modulus;
    };
    std::vector<Acting> acting;
    std::vector<fe::LayerMaterial> layers;
    std::vector<double> values; // of the sensors
};

template <class Kind>
class PulseBuilder {
public:
    using Element = typename Kind::Element;

    PulseBuilder(const Case& nominal, int load, std::span<const Case> samples, const BuildSettings& settings,
                 const ForEach& for_each)
        : nominal_(nominal),
          load_(load),
          samples_(samples),
          settings_(settings),
          for_each_(for_each),
          own_(with_effects(nominal, load)),
          full_(make_finite_element_model(own_, load)),
          model_(fe::make_model(Kind::nominal_mesh(own_, load), linear_layers(own_))),
          active_(stress_dependent_elements(own_, model_)) {}

    Outcome<Basis> build(BuildReport& report) {
        const auto calibration = static_cast<std::size_t>(std::min(settings_.calibration, most_calibration));
        const auto most = static_cast<std::size_t>(std::min(settings_.most_runs, most_runs)) - calibration;
        if (samples_.size() < first_runs + first_runs / 2 + calibration) {
            return Failure{Status::failed, "too few samples to build a reduced model from"};
        }
        std::size_t next = 0; // sample
        const auto take = [&](std::size_t count, bool with_path) {
            std::vector<std::optional<Motion>> done(std::min(count, samples_.size() - next));
            for_each_(done.size(), [&](std::size_t i) { done[i] = run(*full_, samples_[next + i], with_path); });
            report.full_runs += static_cast<int>(done.size());
            return done;
        };
        const auto add = [&](std::vector<std::optional<Motion>> done) {
            next += done.size();
            for (auto& motion : done) {
                if (motion) {
                    compress(*motion);
                    runs_.push_back(std::move(*motion));
                }
            }
        };
        add(take(first_runs, true));
        Basis basis;
        for (;;) {
            if (runs_.size() < 2) {
                return Failure{Status::failed, "the full model has no answer at the samples of the build"};
            }
            basis = make_basis();
            const std::size_t more = next / 2;
            if (next + more + calibration > samples_.size() || next + more > most) {
                break;
            }
            auto unseen = take(more, true);
            const auto errors = errors_of(basis, unseen, next);
            const auto largest = largest_of_each(errors);
            add(std::move(unseen));
            if (std::all_of(largest.begin(), largest.end(), [](double error) { return error < tolerance; })) {
                break;
            }
        }
        report.modes = static_cast<int>(basis.modes.cols());
        report.points = static_cast<int>(basis.points.size());
        const auto errors = errors_of(basis, take(calibration, false), next);
        if (errors.empty()) {
            return Failure{Status::failed, "the reduced model has no answer at the samples of the build"};
        }
        report.error_95 = quantile(largest_of_each(errors), 0.95);
        basis.factor.assign(own_.sensors.size(), 0.0);
        for (std::size_t i = 0; i < own_.sensors.size(); ++i) {
            std::vector<double> own(errors.size());
            std::transform(errors.begin(), errors.end(), own.begin(), [i](const auto& e) { return e[i]; });
            basis.floor.push_back(quantile(own, 0.95));
        }
        // One factor, so that together they cover all readings at most samples.
        std::vector<double> ratio;
        for (const auto& of_run : errors) {
            double& worst = ratio.emplace_back(0.0);
            for (std::size_t i = 0; i < of_run.size(); ++i) {
                worst = basis.floor[i] > 0.0 ? std::max(worst, of_run[i] / basis.floor[i]) : worst;
            }
        }
        const double together = quantile(ratio, 0.95);
        for (double& floor : basis.floor) {
            floor *= together;
        }
        return basis;
    }

private:
    static constexpr std::size_t first_runs = 24;
    static constexpr double tolerance = 0.01; // of all readings, at samples that were not built from
    static constexpr int most_runs = 140;
    static constexpr int most_calibration = 40;
    static constexpr std::size_t fields_a_run = 24;
    static constexpr std::size_t forces_a_run = 6;
    static constexpr Eigen::Index most_modes = 80;
    static constexpr int most_points = 80;

    static std::vector<double> largest_of_each(const std::vector<std::vector<double>>& errors) {
        std::vector<double> largest(errors.size());
        std::transform(errors.begin(), errors.end(), largest.begin(),
                       [](const auto& of_run) { return *std::max_element(of_run.begin(), of_run.end()); });
        return largest;
    }
    static double quantile(std::vector<double> values, double share) {
        std::sort(values.begin(), values.end());
        return values[static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size() - 1)))];
    }

    // Nothing: no answer, or no material has these parameters.
    std::optional<Motion> run(const LoadModel& model, const Case& values, bool with_path) const {
        const auto met = as_met(values, load_);
        if (!met) {
            return std::nullopt;
        }
        const Case& c = *met;
        Motion motion;
        motion.layers = materials_of(c);
        const auto workspace = model.make_workspace();
        const std::size_t steps = steps_of(c, load_);
        const std::size_t every = std::max<std::size_t>(1, steps / fields_a_run);
        const std::size_t every_force = std::min(steps, every * (fields_a_run / forces_a_run));
        std::size_t step = 0;
        if (with_path) {
            model.watch(*workspace, [&](const Eigen::VectorXd& displacement, const Eigen::VectorXd& modulus) {
                ++step;
                if (step % every == 0) {
                    motion.fields.push_back(displacement);
                    if (step % every_force == 0) {
                        motion.acting.push_back({displacement, modulus});
                    }
                }
            });
        }
        auto outcome = model.run(c, motion.layers, {}, {}, *workspace);
        if (!outcome) {
            return std::nullopt;
        }
        motion.values = outcome->values;
        return motion;
    }

    // Of the reduced model at the samples from `first` on whose full runs these are, relative, of every sensor.
    std::vector<std::vector<double>> errors_of(const Basis& basis, const std::vector<std::optional<Motion>>& full,
                                               std::size_t first) const {
        const auto reduced = make_load_model(nominal_, load_, basis);
        std::vector<std::optional<Motion>> quick(full.size());
        for_each_(full.size(), [&](std::size_t i) {
            quick[i] = full[i] ? run(*reduced, samples_[first + i], false) : std::nullopt;
        });
        std::vector<std::vector<double>> errors;
        for (std::size_t i = 0; i < full.size(); ++i) {
            if (full[i] && quick[i]) {
                const auto scale = scales(own_, load_, full[i]->values);
                auto& own = errors.emplace_back(scale.size());
                for (std::size_t k = 0; k < scale.size(); ++k) {
                    own[k] = std::abs(quick[i]->values[k] - full[i]->values[k]) / scale[k];
                }
            }
        }
        return errors;
    }

    // The fields of a run to few, relative to the largest of their energies.
    void compress(Motion& motion) {
        if (metric_.size() == 0) {
            metric_ = energy(model_, motion.layers, motion.acting.front().modulus.mean());
        }
        Eigen::MatrixXd fields(model_.free_unknowns(), static_cast<Eigen::Index>(motion.fields.size()));
        for (std::size_t i = 0; i < motion.fields.size(); ++i) {
            fields.col(static_cast<Eigen::Index>(i)) = motion.fields[i];
        }
        motion.fields.clear();
        Eigen::MatrixXd gram = fields.transpose() * Eigen::MatrixXd(metric_ * fields);
        const double largest = gram.diagonal().maxCoeff();
        gram /= largest;
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
        const Eigen::Index kept = (eigen.eigenvalues().array() > mode_tolerance).count();
        motion.modes = fields * (eigen.eigenvectors().rightCols(kept) / std::sqrt(largest));
        for (Motion::Acting& acting : motion.acting) {
            acting.field /= std::sqrt(largest);
        }
    }

    Basis make_basis() const {
        Eigen::Index count = 0;
        for (const Motion& run : runs_) {
            count += run.modes.cols();
        }
        Eigen::MatrixXd snapshots(model_.free_unknowns(), count);
        std::vector<ForceSnapshot> forces;
        Eigen::Index at = 0;
        for (const Motion& run : runs_) {
            snapshots.middleCols(at, run.modes.cols()) = run.modes;
            at += run.modes.cols();
            for (const Motion::Acting& acting : run.acting) {
                forces.push_back({&acting.field, &acting.modulus, &run.layers, 1.0});
            }
        }
        Basis basis;
        basis.modes = proper_modes(snapshots, snapshots.transpose() * Eigen::MatrixXd(metric_ * snapshots),
                                   Eigen::VectorXd::Ones(count), most_modes, mode_tolerance);
        basis.coarse = static_cast<int>(basis.modes.cols());
        basis.points =
            cubature(model_, active_, basis.modes, std::move(forces), most_points, settings_.seed, for_each_);
        return basis;
    }

    const Case& nominal_;
    int load_;
    std::span<const Case> samples_;
    BuildSettings settings_;
    const ForEach& for_each_;
    Case own_;
    std::unique_ptr<const LoadModel> full_;
    fe::Model<Element> model_;
    std::vector<int> active_; // stress-dependent elements
    std::vector<Motion> runs_;
    Eigen::SparseMatrix<double> metric_; // energy of displacement fields
};

} // namespace

Outcome<Basis> build_pulse(const Case& nominal, int load, std::span<const Case> samples, const BuildSettings& settings,
                           const ForEach& for_each, BuildReport& report) {
    if (nominal.loads[static_cast<std::size_t>(load)].is_axisymmetric()) {
        return PulseBuilder<Axisymmetric>(nominal, load, samples, settings, for_each).build(report);
    }
    return PulseBuilder<Solid>(nominal, load, samples, settings, for_each).build(report);
}

} // namespace pave::reduced
