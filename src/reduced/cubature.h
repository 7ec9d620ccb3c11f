// Few Gauss points with weights that stand for all of them (empirical cubature: Farhat et al. 2014, doi
// 10.1002/nme.4668).
#pragma once

#include "fe/materials.h"
#include "reduced/nonnegative.h"
#include "reduced/reduced_load.h"

#include <numeric>
#include <random>

namespace pave::reduced {

// A displacement field whose forces the cubature has to give.
struct ForceSnapshot {
    const Eigen::VectorXd* field;   // free unknowns
    const Eigen::VectorXd* modulus; // of the Gauss points of the active elements [Pa]
    const std::vector<fe::LayerMaterial>* layers;
    double counts; // factor on its forces
};

// Of the points of these elements, at most so many, whose weights give the forces of the snapshots on the modes.
template <class Element>
std::vector<Basis::Point> cubature(const fe::Model<Element>& model, const std::vector<int>& active,
                                   const Eigen::MatrixXd& modes, std::vector<ForceSnapshot> snapshots, int most_points,
                                   std::uint64_t seed, const ForEach& for_each) {
    constexpr int N = Element::voigt;
    using Strains = Eigen::Matrix<double, N, Eigen::Dynamic>;
    constexpr double tolerance = 3e-4;
    constexpr std::size_t most_snapshots = 120;
    constexpr std::size_t most_candidates = 6000;
    std::mt19937_64 random(seed);
    std::shuffle(snapshots.begin(), snapshots.end(), random);
    snapshots.resize(std::min(snapshots.size(), most_snapshots));
    const auto taken = static_cast<Eigen::Index>(snapshots.size());
    Eigen::MatrixXd fields(model.free_unknowns(), taken);
    std::vector<std::vector<mechanics::Stiffness<N>>> units(snapshots.size());
    for (std::size_t k = 0; k < snapshots.size(); ++k) {
        fields.col(static_cast<Eigen::Index>(k)) = *snapshots[k].field;
        for (const auto& layer : *snapshots[k].layers) {
            units[k].push_back(layer.template unit_stiffness<N>());
        }
    }
    const Eigen::Index count = modes.cols();
    const Eigen::Index forces = count * taken;
    // Random combinations of the forces keep their distances (Johnson and Lindenstrauss); the volume is kept as it is.
    const auto rows = Eigen::Index{3} * most_points;
    std::normal_distribution<double> normal;
    Eigen::MatrixXd mix(rows, forces);
    for (double& x : mix.reshaped()) {
        x = normal(random) / std::sqrt(static_cast<double>(rows));
    }
    for (std::size_t k = 0; k < snapshots.size(); ++k) {
        mix.middleCols(static_cast<Eigen::Index>(k) * count, count) *= snapshots[k].counts;
    }
    const auto points = static_cast<Eigen::Index>(active.size()) * Element::gauss;
    // All points make the forces that are wanted; some of them, drawn at random, are candidates for the cubature.
    std::vector<Eigen::Index> candidates(static_cast<std::size_t>(points));
    std::iota(candidates.begin(), candidates.end(), 0);
    std::shuffle(candidates.begin(), candidates.end(), random);
    candidates.resize(std::min<std::size_t>(candidates.size(), most_candidates));
    std::vector<Eigen::Index> column_of(static_cast<std::size_t>(points), -1);
    for (std::size_t j = 0; j < candidates.size(); ++j) {
        column_of[static_cast<std::size_t>(candidates[j])] = static_cast<Eigen::Index>(j);
    }
    Eigen::MatrixXd columns(rows + 1, static_cast<Eigen::Index>(candidates.size()));
    constexpr std::size_t parts = 32; // of the elements: sums in a fixed order, whoever makes them
    std::vector<Eigen::VectorXd> force_of_part(parts, Eigen::VectorXd::Zero(forces));
    std::vector<double> volume_of_part(parts, 0.0);
    for_each(parts, [&](std::size_t part) {
        constexpr Eigen::Index together = 32;
        Eigen::MatrixXd works(forces, together); // of candidates
        std::vector<Eigen::Index> columns_of_works;
        const auto mix_works = [&] {
            const auto filled = static_cast<Eigen::Index>(columns_of_works.size());
            const Eigen::MatrixXd mixed = mix * works.leftCols(filled);
            for (Eigen::Index k = 0; k < filled; ++k) {
                columns.col(columns_of_works[static_cast<std::size_t>(k)]).head(rows) = mixed.col(k);
            }
            columns_of_works.clear();
        };
        for (std::size_t a = part * active.size() / parts; a < (part + 1) * active.size() / parts; ++a) {
            const auto layer = static_cast<std::size_t>(model.topology->layer[static_cast<std::size_t>(active[a])]);
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = active[a] * Element::gauss + g;
                const auto at = static_cast<Eigen::Index>(a) * Element::gauss + g;
                const double weight = model.points[static_cast<std::size_t>(q)].weight;
                const Strains of_modes = fe::strains(model, q, modes);
                Strains stress = fe::strains(model, q, fields);
                for (std::size_t k = 0; k < snapshots.size(); ++k) {
                    const auto column = static_cast<Eigen::Index>(k);
                    const Eigen::Matrix<double, N, 1> strain = stress.col(column);
                    stress.col(column) = weight * (*snapshots[k].modulus)[at] * (units[k][layer] * strain);
                }
                const Eigen::MatrixXd work = of_modes.transpose() * stress; // modes x snapshots
                force_of_part[part] += work.reshaped();
                volume_of_part[part] += weight;
                if (const Eigen::Index j = column_of[static_cast<std::size_t>(at)]; j >= 0) {
                    works.col(static_cast<Eigen::Index>(columns_of_works.size())) = work.reshaped();
                    columns_of_works.push_back(j);
                    columns(rows, j) = weight;
                    if (columns_of_works.size() == together) {
                        mix_works();
                    }
                }
            }
        }
        mix_works();
    });
    Eigen::VectorXd whole(rows + 1);
    whole.head(rows) = mix * std::accumulate(force_of_part.begin() + 1, force_of_part.end(), force_of_part[0]);
    whole[rows] = std::accumulate(volume_of_part.begin(), volume_of_part.end(), 0.0);
    const double volume_counts = 0.05 * whole.head(rows).norm() / whole[rows]; // a little
    columns.row(rows) *= volume_counts;
    whole[rows] *= volume_counts;
    const Eigen::VectorXd weights = nonnegative_least_squares(columns, whole, tolerance, most_points);
    std::vector<Basis::Point> chosen;
    for (std::size_t j = 0; j < candidates.size(); ++j) {
        if (const double weight = weights[static_cast<Eigen::Index>(j)]; weight > 0.0) {
            const int q = active[static_cast<std::size_t>(candidates[j] / Element::gauss)] * Element::gauss +
                          static_cast<int>(candidates[j] % Element::gauss);
            chosen.push_back({q, weight * model.points[static_cast<std::size_t>(q)].weight});
        }
    }
    return chosen;
}

} // namespace pave::reduced
