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
    std::vector<bool> constant(static_cast<std::size_t>(free_unknowns), true);
    for (std::size_t e = 0; e < unknowns.size(); ++e) {
        for (const int i : unknowns[e]) {
            if (i >= 0 && !linear[layer[e]]) {
                constant[i] = false;
            }
        }
    }
    // In three dimensions a separator across the layers costs less than one along them.
    analysis = std::make_shared<const CholeskyAnalysis>(lower, constant, Element::dim == 2);
}

namespace {

template <class Element, class Mesh>
std::vector<Eigen::Matrix<double, Element::dim, 1>> positions_of(const Mesh& mesh) {
    std::vector<Eigen::Matrix<double, Element::dim, 1>> nodes;
    for (const auto& node : mesh.nodes) {
        if constexpr (Element::dim == 2) {
            nodes.emplace_back(node.r, node.z);
        } else {
            nodes.emplace_back(node.x, node.y, node.z);
        }
    }
    return nodes;
}

template <class Element, class Mesh>
std::shared_ptr<const Topology<Element>>
make_topology(const Mesh& mesh, const std::vector<bool>& linear,
              const std::function<bool(std::size_t node, int direction)>& is_held) {
    auto topology = std::make_shared<Topology<Element>>();
    topology->layers = mesh.layers;
    topology->layer = mesh.layer;
    topology->linear = linear;
    std::vector<std::array<int, Element::dim>> number(mesh.nodes.size()); // the unknown of each displacement, or -1
    for (std::size_t k = 0; k < number.size(); ++k) {
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
    return topology;
}

template <class Element, class Mesh>
Model<Element> build(const Mesh& mesh, std::shared_ptr<const Topology<Element>> topology) {
    Model<Element> model;
    model.topology = std::move(topology);
    const auto nodes = positions_of<Element>(mesh);
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

Model<AxisymmetricQ8> make_model(const mesh::AxisymmetricMesh& mesh, const std::vector<bool>& linear) {
    return build<AxisymmetricQ8>(mesh, make_topology<AxisymmetricQ8>(mesh, linear, [&](std::size_t k, int d) {
                                     const auto [r, z] = mesh.nodes[k];
                                     return z == mesh.z_lines.back() ||
                                            (d == 0 && (r == 0.0 || r == mesh.r_lines.back()));
                                 }));
}

Model<Hex20> make_model(const mesh::SolidMesh& mesh, const std::vector<bool>& linear) {
    return build<Hex20>(mesh, make_topology<Hex20>(mesh, linear, [&](std::size_t k, int d) {
                            const auto [x, y, z] = mesh.nodes[k];
                            return z == mesh.z_lines.back() || (d == 0 && (x == 0.0 || x == mesh.x_lines.back())) ||
                                   (d == 1 && (y == 0.0 || y == mesh.y_lines.back()));
                        }));
}

Model<AxisymmetricQ8> make_model(const mesh::AxisymmetricMesh& mesh, const Model<AxisymmetricQ8>& like) {
    return build<AxisymmetricQ8>(mesh, like.topology);
}
Model<Hex20> make_model(const mesh::SolidMesh& mesh, const Model<Hex20>& like) {
    return build<Hex20>(mesh, like.topology);
}

template struct Topology<AxisymmetricQ8>;
template struct Topology<Hex20>;

} // namespace pave::fe
