#include "fe/model.h"

#include "fe/gauss_rule.h"

#include <algorithm>
#include <functional>
#include <map>
#include <mutex>
#include <numbers>

namespace pave::fe {

template <class Element>
bool Topology<Element>::is_like(const Topology& other) const {
    return free_unknowns == other.free_unknowns && layers == other.layers && wall_is_open == other.wall_is_open &&
           bottom_is_open == other.bottom_is_open && linear == other.linear && coupled == other.coupled &&
           layer == other.layer && endless == other.endless && unknowns == other.unknowns;
}

template <class Element>
void Topology<Element>::build_pattern() {
    std::vector<std::vector<int>> columns(free_unknowns);
    const auto couple = [&columns](const auto& numbers) {
        for (const int i : numbers) {
            for (const int j : numbers) {
                if (j >= 0 && i >= j) {
                    columns[j].push_back(i);
                }
            }
        }
    };
    for (const auto& of_element : unknowns) {
        couple(of_element);
    }
    for (const auto& of_springs : coupled) {
        couple(of_springs);
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
    // The unknowns of no layer but linear ones from that one down.
    const auto constant_below = [this](int first) {
        std::vector<bool> constant(static_cast<std::size_t>(free_unknowns), true);
        for (std::size_t e = 0; e < unknowns.size(); ++e) {
            for (const int i : unknowns[e]) {
                if (i >= 0 && (!linear[layer[e]] || layer[e] < first)) {
                    constant[i] = false;
                }
            }
        }
        return constant;
    };
    const std::vector<bool> constant = constant_below(0);
    // In three dimensions a separator across the layers costs less than one along them.
    constexpr bool constant_first = Element::dim == 2;
    analysis =
        std::make_shared<const CholeskyAnalysis>(lower, constant, constant_first ? constant : std::vector<bool>());
    const auto changing = std::find(linear.rbegin(), linear.rend(), false);
    const auto below = static_cast<int>(linear.rend() - changing);
    const bool has_linear_above = std::find(linear.begin(), changing.base(), true) != changing.base();
    if (constant_first && has_linear_above && below > 0) {
        // A thin layer on top, eliminated first, would couple all unknowns of the face below it.
        auto other = std::make_shared<const CholeskyAnalysis>(lower, constant, constant_below(below));
        if (other->structure().changing_operations() < analysis->structure().changing_operations()) {
            analysis = std::move(other);
        }
    }
}

namespace {

// The faces of elements that springs act on. lower: local nodes of the lower face, upper: of the upper one, in the same
// order. integrate(x, at) calls at(shape of the face's nodes, weight [m2]) at points that integrate products of two
// shape functions: 3 Gauss points a direction.
template <class Element>
struct Face;

template <>
struct Face<AxisymmetricQ8> {
    static constexpr int nodes = 3;
    static constexpr int upper[nodes] = {0, 4, 1};
    static constexpr int lower[nodes] = {3, 6, 2};
    template <class F>
    static void integrate(const AxisymmetricQ8::Coordinates& x, F at) {
        const double half = (x(0, 1) - x(0, 0)) / 2.0;
        for (const auto& [xi, weight] : three_points) {
            const auto shape = AxisymmetricQ8::shape({xi, -1.0});
            Eigen::Matrix<double, nodes, 1> n;
            for (int i = 0; i < nodes; ++i) {
                n[i] = shape[upper[i]];
            }
            at(n, 2.0 * std::numbers::pi * (x(0, 0) + half * (1.0 + xi)) * half * weight);
        }
    }
};

template <>
struct Face<Hex20> {
    static constexpr int nodes = 8;
    static constexpr int upper[nodes] = {0, 1, 2, 3, 8, 9, 10, 11};
    static constexpr int lower[nodes] = {4, 5, 6, 7, 12, 13, 14, 15};
    template <class F>
    static void integrate(const Hex20::Coordinates& x, F at) {
        const double area = (x(0, 1) - x(0, 0)) * (x(1, 3) - x(1, 0)) / 4.0;
        for (const auto& [xi, in_x] : three_points) {
            for (const auto& [eta, in_y] : three_points) {
                const auto shape = Hex20::shape({xi, eta, -1.0});
                Eigen::Matrix<double, nodes, 1> n;
                for (int i = 0; i < nodes; ++i) {
                    n[i] = shape[upper[i]];
                }
                at(n, in_x * in_y * area);
            }
        }
    }
};

// Whether an element is the last of its layer from above: cells of a column follow each other downwards.
template <class Mesh>
bool is_lowest_of(const Mesh& mesh, int element, int layer) {
    return mesh.layer[element] == layer && mesh.layer[element + 1] == layer + 1;
}

// Gives the lower face of a layer horizontal unknowns of its own.
template <class Mesh, class Element>
void part_layer(const Mesh& mesh, int layer, Topology<Element>& topology) {
    std::map<int, int> own; // of an unknown shared so far
    for (int e = 0; e + 1 < topology.elements(); ++e) {
        if (!is_lowest_of(mesh, e, layer)) {
            continue;
        }
        for (const int node : Face<Element>::lower) {
            for (int d = 0; d < Element::down; ++d) {
                int& unknown = topology.unknowns[e][Element::dim * node + d];
                if (unknown >= 0) {
                    const auto [entry, is_new] = own.try_emplace(unknown, topology.free_unknowns);
                    topology.free_unknowns += is_new ? 1 : 0;
                    unknown = entry->second;
                }
            }
        }
    }
}

// Columns of cells under the plate; its edge is a line of the mesh.
template <class Mesh>
std::vector<int> elements_under(const Mesh& mesh, double radius) {
    std::vector<int> elements;
    if constexpr (requires { mesh.r_lines; }) {
        for (int i = 0; i < mesh.r_cells() && mesh.r_lines[i + 1] <= radius * (1.0 + 1e-12); ++i) {
            elements.push_back(i * mesh.z_cells());
        }
    }
    return elements;
}

// The vertical unknowns of the surface under the plate.
template <class Mesh, class Element>
std::vector<int> unknowns_under(const Mesh& mesh, double radius, const Topology<Element>& topology) {
    std::vector<int> unknowns;
    for (const int e : elements_under(mesh, radius)) {
        for (const int node : Face<Element>::upper) {
            unknowns.push_back(topology.unknowns[e][Element::dim * node + Element::down]);
        }
    }
    return unknowns;
}

template <class Mesh, class Element>
std::vector<std::vector<int>> coupled_by(const Mesh& mesh, const Springs& springs, const Topology<Element>& topology) {
    std::vector<std::vector<int>> coupled;
    for (const int layer : springs.slipping_layers) {
        for (int e = 0; e + 1 < topology.elements(); ++e) {
            if (!is_lowest_of(mesh, e, layer)) {
                continue;
            }
            for (int d = 0; d < Element::down; ++d) {
                auto& group = coupled.emplace_back();
                for (int i = 0; i < Face<Element>::nodes; ++i) {
                    group.push_back(topology.unknowns[e][Element::dim * Face<Element>::lower[i] + d]);
                    group.push_back(topology.unknowns[e + 1][Element::dim * Face<Element>::upper[i] + d]);
                }
            }
        }
    }
    if (springs.plate_radius > 0.0) {
        coupled.push_back(unknowns_under(mesh, springs.plate_radius, topology));
    }
    return coupled;
}

// Collects entries of a spring's matrix.
class SpringBuilder {
public:
    void add(int i, int j, double value) {
        if (i >= 0 && j >= 0 && i >= j) {
            sum_[{i, j}] += value;
        }
    }
    Spring on(const Pattern& lower) const {
        Spring spring;
        for (const auto& [at, value] : sum_) {
            const auto first = lower.row.begin() + lower.column_start[at.second];
            const auto last = lower.row.begin() + lower.column_start[at.second + 1];
            spring.entries.push_back({at.first, at.second,
                                      static_cast<int>(std::lower_bound(first, last, at.first) - lower.row.begin()),
                                      value});
        }
        return spring;
    }

private:
    std::map<std::pair<int, int>, double> sum_;
};

template <class Mesh, class Element>
Spring interface_spring(const Mesh& mesh, int layer, const Model<Element>& model) {
    SpringBuilder builder;
    for (int e = 0; e + 1 < model.elements(); ++e) {
        if (!is_lowest_of(mesh, e, layer)) {
            continue;
        }
        Face<Element>::integrate(model.coordinates[e], [&](const auto& n, double weight) {
            for (int d = 0; d < Element::down; ++d) {
                for (int i = 0; i < Face<Element>::nodes; ++i) {
                    for (int j = 0; j < Face<Element>::nodes; ++j) {
                        const double value = weight * n[i] * n[j];
                        const auto above = [&](int k) {
                            return model.topology->unknowns[e][Element::dim * Face<Element>::lower[k] + d];
                        };
                        const auto below = [&](int k) {
                            return model.topology->unknowns[e + 1][Element::dim * Face<Element>::upper[k] + d];
                        };
                        builder.add(above(i), above(j), value);
                        builder.add(below(i), below(j), value);
                        builder.add(above(i), below(j), -value);
                        builder.add(below(i), above(j), -value);
                    }
                }
            }
        });
    }
    return builder.on(model.topology->lower);
}

template <class Mesh, class Element>
Spring plate_spring(const Mesh& mesh, double radius, const Model<Element>& model) {
    SpringBuilder builder;
    std::map<int, double> area; // the integral of each shape function
    double whole = 0.0;
    for (const int e : elements_under(mesh, radius)) {
        Face<Element>::integrate(model.coordinates[e], [&](const auto& n, double weight) {
            whole += weight;
            const auto unknown = [&](int k) {
                return model.topology->unknowns[e][Element::dim * Face<Element>::upper[k] + Element::down];
            };
            for (int i = 0; i < Face<Element>::nodes; ++i) {
                area[unknown(i)] += weight * n[i];
                for (int j = 0; j < Face<Element>::nodes; ++j) {
                    builder.add(unknown(i), unknown(j), weight * n[i] * n[j]);
                }
            }
        });
    }
    for (const auto& [i, of_i] : area) {
        for (const auto& [j, of_j] : area) {
            builder.add(i, j, -of_i * of_j / whole);
        }
    }
    return builder.on(model.topology->lower);
}

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

// The directions of every element that have no end.
template <class Element, class Mesh>
std::vector<unsigned> endless_of(const Mesh& mesh, const std::vector<std::vector<double>>& lines) {
    std::vector<unsigned> endless;
    const auto nodes = positions_of<Element>(mesh);
    for (const auto& element : mesh.elements) {
        unsigned bits = 0;
        for (int d = 0; d < Element::dim; ++d) {
            for (const int node : element) {
                if (nodes[static_cast<std::size_t>(node)][d] == lines[static_cast<std::size_t>(d)].back()) {
                    bits |= 1U << d;
                }
            }
        }
        endless.push_back(bits);
    }
    return endless;
}

// A place in an element that is a box whose sides follow the axes: x = (x0 + x1)/2 + (x1 - x0)/2 xi, or in a direction
// without end 2 x0/(1 - xi); and dx/dxi.
template <class Element>
struct InBox {
    Eigen::Matrix<double, Element::dim, 1> at, slope;

    InBox(const typename Element::Coordinates& x, const typename Element::Position& position, unsigned endless) {
        for (int d = 0; d < Element::dim; ++d) {
            const double low = x.row(d).minCoeff();
            const double half = (x.row(d).maxCoeff() - low) / 2.0;
            const bool ends = (endless >> d & 1U) == 0;
            at[d] = ends ? low + half * (1.0 + position[d]) : 2.0 * low / (1.0 - position[d]);
            slope[d] = ends ? half : at[d] / (1.0 - position[d]);
        }
    }
};

// Element::point() of an element without end.
template <class Element>
typename Element::Point endless_point(const InBox<Element>& box, const typename Element::Position& position) {
    typename Element::Point point;
    point.weight = box.slope.prod();
    point.rows.template topRows<Element::dim>() =
        box.slope.cwiseInverse().asDiagonal() * Element::shape_gradient(position);
    if constexpr (Element::dim == 2) {
        point.weight *= 2.0 * std::numbers::pi * box.at[0];
        point.rows.row(2) = Element::shape(position).transpose() / box.at[0];
    }
    return point;
}

// Models of one section, each with something else that may be amiss, have one mesh: what was made of the same before
// is taken again while another model has it. May be called from many threads.
template <class Element>
std::shared_ptr<const Topology<Element>> with_pattern(std::shared_ptr<Topology<Element>> made) {
    static std::mutex mutex;
    static std::vector<std::weak_ptr<const Topology<Element>>> known;
    {
        const std::scoped_lock lock(mutex);
        std::erase_if(known, [](const auto& one) { return one.expired(); });
        for (const auto& one : known) {
            if (auto kept = one.lock(); kept && kept->is_like(*made)) {
                return kept;
            }
        }
    }
    made->build_pattern();
    const std::scoped_lock lock(mutex);
    known.push_back(made);
    return made;
}

template <class Element, class Mesh>
std::shared_ptr<const Topology<Element>>
make_topology(const Mesh& mesh, const std::vector<bool>& linear,
              const std::function<bool(std::size_t node, int direction)>& is_held, const Springs& springs,
              const std::vector<std::vector<double>>& lines) {
    auto topology = std::make_shared<Topology<Element>>();
    topology->layers = mesh.layers;
    topology->layer = mesh.layer;
    topology->linear = linear;
    topology->wall_is_open = mesh.wall_is_open;
    topology->bottom_is_open = mesh.bottom_is_open;
    if (mesh.endless) {
        topology->endless = endless_of<Element>(mesh, lines);
    }
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
    for (const int layer : springs.slipping_layers) {
        part_layer(mesh, layer, *topology);
    }
    topology->coupled = coupled_by(mesh, springs, *topology);
    return with_pattern<Element>(std::move(topology));
}

template <class Element, class Mesh>
Model<Element> build(const Mesh& mesh, std::shared_ptr<const Topology<Element>> topology, const Springs& springs) {
    Model<Element> model;
    model.topology = std::move(topology);
    const auto nodes = positions_of<Element>(mesh);
    const auto positions = Element::gauss_positions();
    for (const auto& element : mesh.elements) {
        typename Element::Coordinates x;
        for (int i = 0; i < Element::nodes; ++i) {
            x.col(i) = nodes[element[i]];
        }
        const std::size_t e = model.coordinates.size();
        const unsigned endless = model.topology->endless.empty() ? 0U : model.topology->endless[e];
        model.coordinates.push_back(x);
        for (const auto& position : positions) {
            if (endless != 0) {
                const InBox<Element> box(x, position, endless);
                model.points.push_back(endless_point<Element>(box, position));
                model.depth.push_back(box.at[Element::down]);
                continue;
            }
            model.points.push_back(Element::point(x, position));
            model.depth.push_back(Element::depth(x, position));
        }
    }
    for (const int layer : springs.slipping_layers) {
        model.springs.push_back(interface_spring(mesh, layer, model));
    }
    if (springs.plate_radius > 0.0) {
        model.springs.push_back(plate_spring(mesh, springs.plate_radius, model));
    }
    return model;
}

} // namespace

template <class Element>
Eigen::Vector3d position_of(const Model<Element>& model, int element, int gauss) {
    const auto position = Element::gauss_positions()[gauss];
    Eigen::Matrix<double, Element::dim, 1> at = model.coordinates[element] * Element::shape(position);
    const auto& endless = model.topology->endless;
    if (!endless.empty() && endless[static_cast<std::size_t>(element)] != 0) {
        at = InBox<Element>(model.coordinates[element], position, endless[static_cast<std::size_t>(element)]).at;
    }
    if constexpr (Element::dim == 2) {
        return {at[0], 0.0, at[1]};
    } else {
        return at;
    }
}

Model<AxisymmetricQ8> make_model(const mesh::AxisymmetricMesh& mesh, const std::vector<bool>& linear,
                                 const Springs& springs) {
    const auto is_held = [&](std::size_t k, int d) {
        const auto [r, z] = mesh.nodes[k];
        return (z == mesh.z_lines.back() && !mesh.bottom_is_open) || (d == 0 && r == 0.0) ||
               ((d == 0 || mesh.endless) && r == mesh.r_lines.back() && !mesh.wall_is_open);
    };
    return build(mesh, make_topology<AxisymmetricQ8>(mesh, linear, is_held, springs, {mesh.r_lines, mesh.z_lines}),
                 springs);
}

Model<Hex20> make_model(const mesh::SolidMesh& mesh, const std::vector<bool>& linear, const Springs& springs) {
    const auto is_held = [&](std::size_t k, int d) {
        const auto [x, y, z] = mesh.nodes[k];
        return (z == mesh.z_lines.back() && !mesh.bottom_is_open) || (d == 0 && x == 0.0) || (d == 1 && y == 0.0) ||
               (!mesh.wall_is_open && (((d == 0 || mesh.endless) && x == mesh.x_lines.back()) ||
                                       ((d == 1 || mesh.endless) && y == mesh.y_lines.back())));
    };
    return build(mesh, make_topology<Hex20>(mesh, linear, is_held, springs, {mesh.x_lines, mesh.y_lines, mesh.z_lines}),
                 springs);
}

Model<AxisymmetricQ8> make_model(const mesh::AxisymmetricMesh& mesh, const Model<AxisymmetricQ8>& like,
                                 const Springs& springs) {
    return build(mesh, like.topology, springs);
}
Model<Hex20> make_model(const mesh::SolidMesh& mesh, const Model<Hex20>& like, const Springs& springs) {
    return build(mesh, like.topology, springs);
}

template struct Topology<AxisymmetricQ8>;
template struct Topology<Hex20>;
template Eigen::Vector3d position_of(const Model<AxisymmetricQ8>&, int, int);
template Eigen::Vector3d position_of(const Model<Hex20>&, int, int);

} // namespace pave::fe
