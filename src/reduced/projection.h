// The full model's part in reduced models: stiffness, readings as loads, projections on displacement fields.
#pragma once

#include "fe/element_matrix.h"
#include "fe/materials.h"
#include "pavement/effects/effect.h"
#include "pavement/observation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <optional>

namespace pave::reduced {

// The case as a load meets it; nothing: no material has these parameters.
inline std::optional<pavement::Case> as_met(const pavement::Case& values, int load) {
    pavement::Case c = pavement::with_effects(values, load);
    const bool possible = std::all_of(c.layers.begin(), c.layers.end(), [](const pavement::Layer& layer) {
        return layer.law->impossible(layer.parameters).empty();
    });
    return possible ? std::optional(std::move(c)) : std::nullopt;
}

template <class Element>
std::vector<int> stress_dependent_elements(const pavement::Case& c, const fe::Model<Element>& model) {
    std::vector<int> elements;
    for (int e = 0; e < model.elements(); ++e) {
        const auto layer = static_cast<std::size_t>(model.topology->layer[static_cast<std::size_t>(e)]);
        if (c.layers[layer].law->stress_dependent()) {
            elements.push_back(e);
        }
    }
    return elements;
}

// The stiffness of a section as a measure of displacement fields; modulus: of all that depends on stress [Pa].
template <class Element>
Eigen::SparseMatrix<double> energy(const fe::Model<Element>& model, const std::vector<fe::LayerMaterial>& layers,
                                   double modulus) {
    constexpr int N = Element::voigt;
    std::vector<Eigen::Triplet<double>> entries;
    for (int e = 0; e < model.elements(); ++e) {
        const auto& layer = layers[static_cast<std::size_t>(model.topology->layer[static_cast<std::size_t>(e)])];
        const double own_modulus =
            layer.law->stress_dependent() ? modulus : layer.law->modulus(layer.parameters, {}).value;
        const mechanics::Stiffness<N> d = own_modulus * layer.template unit_stiffness<N>();
        fe::ElementMatrix<Element> own = fe::ElementMatrix<Element>::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const auto& point =
                model.points[static_cast<std::size_t>(e) * Element::gauss + static_cast<std::size_t>(g)];
            own += fe::point_matrix<Element>(point, d, point, point.weight);
        }
        const auto& unknowns = model.topology->unknowns[static_cast<std::size_t>(e)];
        for (int i = 0; i < Element::dofs; ++i) {
            for (int j = 0; j < Element::dofs; ++j) {
                if (unknowns[static_cast<std::size_t>(i)] >= 0 && unknowns[static_cast<std::size_t>(j)] >= 0) {
                    entries.emplace_back(unknowns[static_cast<std::size_t>(i)], unknowns[static_cast<std::size_t>(j)],
                                         own(i, j));
                }
            }
        }
    }
    Eigen::SparseMatrix<double> k(model.free_unknowns(), model.free_unknowns());
    k.setFromTriplets(entries.begin(), entries.end());
    return k;
}

constexpr double mode_tolerance = 1e-8; // of the energy of snapshots (and duals), that modes leave out

// Proper orthogonal decomposition: the fields with most of the energy of snapshots, each times its scale; a column a
// field, of energy 1. gram: energies of the unscaled snapshots with each other.
inline Eigen::MatrixXd proper_modes(const Eigen::MatrixXd& snapshots, Eigen::MatrixXd gram,
                                    const Eigen::VectorXd& scale, Eigen::Index most, double tolerance) {
    gram = scale.asDiagonal() * gram * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
    const Eigen::VectorXd& values = eigen.eigenvalues(); // increasing
    const double all = values.sum();
    Eigen::Index modes = 0;
    double left = all;
    while (modes < std::min(most, values.size()) && left > tolerance * all) {
        left -= values[values.size() - 1 - modes];
        ++modes;
    }
    Eigen::MatrixXd factors(values.size(), modes);
    for (Eigen::Index i = 0; i < modes; ++i) {
        const Eigen::Index from = values.size() - 1 - i;
        factors.col(i) = scale.asDiagonal() * eigen.eigenvectors().col(from) / std::sqrt(values[from]);
    }
    return snapshots * factors;
}

// Observations as forces, a column each: their work on a displacement is its reading (of a stress, with
// the modulus of every Gauss point as it is [Pa]).
template <class Element>
Eigen::MatrixXd as_loads(const fe::Model<Element>& model,
                         const std::vector<pavement::Observation<Element>>& observations,
                         const std::vector<fe::LayerMaterial>& layers, const Eigen::VectorXd& modulus) {
    constexpr int N = Element::voigt;
    Eigen::MatrixXd loads =
        Eigen::MatrixXd::Zero(model.free_unknowns(), static_cast<Eigen::Index>(observations.size()));
    for (std::size_t i = 0; i < observations.size(); ++i) {
        auto f = loads.col(static_cast<Eigen::Index>(i));
        for (const auto& [unknown, weight] : observations[i].on_displacement) {
            f[unknown] += weight;
        }
        for (const auto& [q, weight, direction] : observations[i].on_stress) {
            const int e = q / Element::gauss;
            const auto& layer = layers[static_cast<std::size_t>(model.topology->layer[static_cast<std::size_t>(e)])];
            typename Element::Vector on_element = Element::Vector::Zero();
            Element::add_force(model.points[static_cast<std::size_t>(q)],
                               modulus[q] * (layer.template unit_stiffness<N>() * direction), weight, on_element);
            model.scatter_add(e, on_element, f.data());
        }
    }
    return loads;
}

// Of every linear layer (empty: it depends on stress) and every entry (i, j), i <= j, of D, row by row: the projected
// stiffness of a D of ones there, modes x modes.
template <class Element>
std::vector<std::vector<Eigen::MatrixXd>>
projected_linear_layers(const pavement::Case& c, const fe::Model<Element>& model, const Eigen::MatrixXd& modes) {
    constexpr int N = Element::voigt;
    std::vector<std::vector<Eigen::MatrixXd>> linear(c.layers.size());
    for (std::size_t l = 0; l < c.layers.size(); ++l) {
        if (c.layers[l].law->stress_dependent()) {
            continue;
        }
        linear[l].assign(N * (N + 1) / 2, Eigen::MatrixXd::Zero(modes.cols(), modes.cols()));
        std::array<Eigen::MatrixXd, N> rows; // strain component at every point, times the root of the weight
        std::vector<int> own;
        for (int e = 0; e < model.elements(); ++e) {
            if (model.topology->layer[static_cast<std::size_t>(e)] == static_cast<int>(l)) {
                own.push_back(e);
            }
        }
        for (auto& r : rows) {
            r.resize(static_cast<Eigen::Index>(own.size()) * Element::gauss, modes.cols());
        }
        Eigen::Index at = 0;
        for (const int e : own) {
            for (int g = 0; g < Element::gauss; ++g, ++at) {
                const int q = e * Element::gauss + g;
                const auto b = fe::strains(model, q, modes);
                const double root = std::sqrt(model.points[static_cast<std::size_t>(q)].weight);
                for (int i = 0; i < N; ++i) {
                    rows[static_cast<std::size_t>(i)].row(at) = root * b.row(i);
                }
            }
        }
        std::size_t entry = 0;
        for (std::size_t i = 0; i < N; ++i) {
            for (std::size_t j = i; j < N; ++j, ++entry) {
                linear[l][entry] = rows[i].transpose() * rows[j];
                if (i != j) {
                    linear[l][entry] += rows[j].transpose() * rows[i];
                }
            }
        }
    }
    return linear;
}

} // namespace pave::reduced
