#include "fe/model.h"

#include <algorithm>
#include <functional>

namespace pave::fe {

template <class Element>
void Topology<Element>::build_pattern() {
    std::vector<std::vector<int>> columns(free_unknowns);
    for (const auto& of_element : unknowns) {
        for (const int i : of_element) {
            for (const int j : of_element) {
                if (j >= 0 && i >= j) {
                    columns[j].push_back(i);
                }
            }
        }
    }
    lower.size = free_unknowns;
    lower.column_start.assign(1, 0);
    lower.row.clear();
    for (auto& rows : columns) {
        std::sort(rows.begin(), rows.end());
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
        lower.row.insert(lower.row.end(), rows.begin(), rows.end());
        lower.column_start.push_back(static_cast<int>(lower.row.size()));
    }
    const auto place = [this](int i, int j) {
        const auto first = lower.row.begin() + lower.column_start[j];
        const auto last = lower.row.begin() + lower.column_start[j + 1];
        return static_cast<int>(std::lower_bound(first, last, i) - lower.row.begin());
    };
    scatter.resize(unknowns.size());
    for (std::size_t e = 0; e < unknowns.size(); ++e) {
        int entry = 0;
        for (int a = 0; a < Element::dofs; ++a) {
            for (int b = 0; b <= a; ++b, ++entry) {
                const int i = unknowns[e][a];
                const int j = unknowns[e][b];
                scatter[e][entry] = i < 0 || j < 0 ? -1 : place(std::max(i, j), std::min(i, j));
            }
        }
    }
    analysis = std::make_shared<const CholeskyAnalysis>(lower);
}

namespace {

// number[node][d]: the unknown of displacement d of a node, or -1.
template <class Element, class Mesh>
Model<Element> build(const Mesh& mesh, const Model<Element>* like,
                     const std::vector<Eigen::Matrix<double, Element::dim, 1>>& nodes,
                     const std::function<bool(std::size_t node, int direction)>& is_held) {
    Model<Element> model;
    if (like != nullptr) {
        model.topology = like->topology;
    } else {
        auto topology = std::make_shared<Topology<Element>>();
        topology->layers = mesh.layers;
        topology->layer = mesh.layer;
        std::vector<std::array<int, Element::dim>> number(nodes.size());
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            for (int d = 0; d < Element::dim; ++d) {
                number[k][d] = is_held(k, d) ? -1 : topology->free_unknowns++;
            }
        }
        for (const auto& element : mesh.elements) {
            std::array<int, Element::dofs> unknowns{};
            for (int i = 0; i < Element::dofs; ++i) {
                unknowns[i] = number[element[i / Element::dim]][i % Element::dim];
            }
            topology->unknowns.push_back(unknowns);
        }
        topology->build_pattern();
        model.topology = std::move(topology);
    }
    const auto positions = Element::gauss_positions();
    for (const auto& element : mesh.elements) {
        typename Element::Coordinates x;
        for (int i = 0; i < Element::nodes; ++i) {
            x.col(i) = nodes[element[i]];
        }
        model.coordinates.push_back(x);
        for (const auto& position : positions) {
            model.points.push_back(Element::point(x, position));
            model.depth.push_back(Element::depth(x, position));
        }
    }
    return model;
}

} // namespace

Model<AxisymmetricQ8> make_model(const mesh::AxisymmetricMesh& mesh, const Model<AxisymmetricQ8>* like) {
    std::vector<Eigen::Vector2d> nodes;
    for (const auto& [r, z] : mesh.nodes) {
        nodes.emplace_back(r, z);
    }
    return build<AxisymmetricQ8>(mesh, like, nodes, [&](std::size_t k, int d) {
        const auto [r, z] = mesh.nodes[k];
        return z == mesh.z_lines.back() || (d == 0 && (r == 0.0 || r == mesh.r_lines.back()));
    });
}

Model<Hex20> make_model(const mesh::SolidMesh& mesh, const Model<Hex20>* like) {
    std::vector<Eigen::Vector3d> nodes;
    for (const auto& [x, y, z] : mesh.nodes) {
        nodes.emplace_back(x, y, z);
    }
    return build<Hex20>(mesh, like, nodes, [&](std::size_t k, int d) {
        const auto [x, y, z] = mesh.nodes[k];
        return z == mesh.z_lines.back() || (d == 0 && (x == 0.0 || x == mesh.x_lines.back())) ||
               (d == 1 && (y == 0.0 || y == mesh.y_lines.back()));
    });
}

template struct Topology<AxisymmetricQ8>;
template struct Topology<Hex20>;

} // namespace pave::fe
