#include "reduced/calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pave::reduced {

using namespace pavement;

namespace {

// At runs that were not learnt from, runs x sensors: what the correction adds to a reading, and by how much that is
// still missed; the square of its reach.
struct Unseen {
    Eigen::MatrixXd missed, added, reach;
};

// The errors of the readings, learnt from all these runs: the modes are few beside the snapshots of the runs that they
// are from (the first of them), so that the readings lack there hardly less than elsewhere.
Unseen learn_correction(Basis& basis, const Case& c, int load, const std::vector<Comparison>& runs,
                        std::size_t of_modes, const ForEach& for_each) {
    std::vector<std::vector<fe::LayerMaterial>> layers;
    std::vector<Load> loads;
    for (const Comparison& run : runs) {
        layers.push_back(run.layers);
        loads.push_back(run.load);
    }
    basis.coordinates = coordinates_of(layers, loads);
    const auto count = static_cast<Eigen::Index>(runs.size());
    const auto known = static_cast<Eigen::Index>(of_modes);
    Eigen::MatrixXd places(static_cast<Eigen::Index>(basis.coordinates.size()), count);
    Eigen::MatrixXd lacks(count, static_cast<Eigen::Index>(c.sensors.size()));
    Eigen::MatrixXd scale(lacks.rows(), lacks.cols());
    for (Eigen::Index k = 0; k < count; ++k) {
        const Comparison& run = runs[static_cast<std::size_t>(k)];
        for (std::size_t d = 0; d < basis.coordinates.size(); ++d) {
            places(static_cast<Eigen::Index>(d), k) = basis.coordinates[d].at(run.layers, run.load);
        }
        const auto own = smooth_scales(c, load, run.quick.values);
        for (Eigen::Index i = 0; i < scale.cols(); ++i) {
            const auto sensor = static_cast<std::size_t>(i);
            scale(k, i) = own[sensor];
            lacks(k, i) = (run.full[sensor] - run.quick.values[sensor]) / own[sensor];
        }
    }
    Unseen unseen{.missed = lacks.cwiseProduct(scale).bottomRows(count - known).cwiseAbs(),
                  .added = Eigen::MatrixXd::Zero(count - known, lacks.cols()),
                  .reach = Eigen::MatrixXd::Ones(count - known, lacks.cols())};
    if (basis.coordinates.empty()) {
        return unseen;
    }
    basis.correction.resize(c.sensors.size());
    for_each(c.sensors.size(), [&](std::size_t i) {
        if (c.sensors[i].load != load) {
            return;
        }
        const auto sensor = static_cast<Eigen::Index>(i);
        const Eigen::VectorXd all = lacks.col(sensor);
        const Kriging first = krige(places.leftCols(known), all.head(known));
        for (Eigen::Index k = known; k < count; ++k) {
            const double added = first.at(places.col(k), nullptr);
            unseen.missed(k - known, sensor) = std::abs(all[k] - added) * scale(k, sensor);
            unseen.added(k - known, sensor) = std::abs(added) * scale(k, sensor);
            unseen.reach(k - known, sensor) = std::pow(first.reach(places.col(k)), 2);
        }
        basis.correction[i] = krige(places, all);
    });
    return unseen;
}

} // namespace

double calibrate(Basis& basis, const Case& c, int load, const std::vector<Comparison>& runs, std::size_t of_modes,
                 const ForEach& for_each) {
    const std::size_t count = runs.size() - of_modes;
    const Unseen unseen = learn_correction(basis, c, load, runs, of_modes, for_each);
    const std::size_t sensors = c.sensors.size();
    std::vector<std::vector<double>> error(count), within(count), estimate(count); // within: by the reach
    for (std::size_t k = 0; k < count; ++k) {
        const Comparison& run = runs[of_modes + k];
        const auto scale = scales(c, load, run.full);
        for (std::size_t i = 0; i < sensors; ++i) {
            const auto row = static_cast<Eigen::Index>(k);
            const auto sensor = static_cast<Eigen::Index>(i);
            error[k].push_back(unseen.missed(row, sensor) / scale[i]);
            within[k].push_back(error[k].back() / unseen.reach(row, sensor));
            estimate[k].push_back((run.quick.errors[i] + unseen.added(row, sensor)) / scale[i]);
        }
    }
    const auto quantile = [](std::vector<double> values, double share) {
        std::sort(values.begin(), values.end());
        return values.empty() ? 0.0 : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    };
    basis.floor.assign(sensors, 0.0);
    for (std::size_t i = 0; i < sensors; ++i) {
        std::vector<double> own(within.size());
        std::transform(within.begin(), within.end(), own.begin(), [i](const auto& e) { return e[i]; });
        basis.floor[i] = quantile(own, 0.5);
    }
    std::vector<double> largest(error.size());
    std::transform(error.begin(), error.end(), largest.begin(),
                   [](const auto& e) { return *std::max_element(e.begin(), e.end()); });
    // Of each sensor: the mixture of gap and floor with the smallest estimates that cover nine errors of ten; then
    // one factor, so that together they cover the errors at nearly every sample.
    for (std::size_t i = 0; i < sensors; ++i) {
        double least = std::numeric_limits<double>::infinity();
        basis.factor.push_back(0.0);
        const double floor = basis.floor[i];
        for (const double share : {0.1, 0.3, 1.0, 3.0, 10.0}) {
            std::vector<double> ratio, guesses;
            for (std::size_t k = 0; k < count; ++k) {
                if (floor > 0.0) {
                    guesses.push_back(share * estimate[k][i] + floor);
                    ratio.push_back(within[k][i] / guesses.back());
                }
            }
            const double factor = quantile(ratio, 0.95);
            const double typical = factor * quantile(guesses, 0.8);
            if (floor > 0.0 && typical < least) {
                least = typical;
                basis.factor[i] = factor * share;
                basis.floor[i] = factor * floor;
            }
        }
    }
    std::vector<double> ratio;
    for (std::size_t k = 0; k < count; ++k) {
        double worst = 0.0;
        for (std::size_t i = 0; i < within[k].size(); ++i) {
            const double guess = basis.factor[i] * estimate[k][i] + basis.floor[i];
            worst = std::max(worst, guess > 0.0 ? within[k][i] / guess : 0.0);
        }
        ratio.push_back(worst);
    }
    const double together = quantile(ratio, 0.99);
    for (std::size_t i = 0; i < sensors; ++i) {
        basis.factor[i] *= together;
        basis.floor[i] *= together;
    }
    return quantile(largest, 0.95);
}

} // namespace pave::reduced
