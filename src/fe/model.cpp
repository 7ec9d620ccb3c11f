#include "fe/model.h"

#include <algorithm>

namespace pave::fe {

template <class Element>
void build_pattern(Model<Element>& model) {
    const int n = model.free_unknowns;
    std::vector<std::vector<int>> columns(n);
    for (const auto& unknowns : model.unknowns) {
        for (const int i : unknowns) {
            for (const int j : unknowns) {
                if (j >= 0 && i >= j) {
                    columns[j].push_back(i);
                }
            }
        }
    }
    Pattern& lower = model.lower;
    lower.size = n;
    lower.column_start.assign(1, 0);
    lower.row.clear();
    for (auto& rows : columns) {
        std::sort(rows.begin(), rows.end());
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
        lower.row.insert(lower.row.end(), rows.begin(), rows.end());
        lower.column_start.push_back(static_cast<int>(lower.row.size()));
    }
    const auto place = [&lower](int i, int j) {
        const auto first = lower.row.begin() + lower.column_start[j];
        const auto last = lower.row.begin() + lower.column_start[j + 1];
        return static_cast<int>(std::lower_bound(first, last, i) - lower.row.begin());
    };
    model.scatter.resize(model.unknowns.size());
    for (std::size_t e = 0; e < model.unknowns.size(); ++e) {
        int entry = 0;
        for (int a = 0; a < Element::dofs; ++a) {
            for (int b = 0; b <= a; ++b, ++entry) {
                const int i = model.unknowns[e][a];
                const int j = model.unknowns[e][b];
                model.scatter[e][entry] = i < 0 || j < 0 ? -1 : place(std::max(i, j), std::min(i, j));
            }
        }
    }
}

Model<AxisymmetricQ8> axisymmetric_model(const mesh::AxisymmetricMesh& mesh) {
    using Element = AxisymmetricQ8;
    Model<Element> model;
    model.layers = mesh.layers;
    model.layer = mesh.layer;
    const double wall = mesh.r_lines.back();
    const double floor = mesh.z_lines.back();
    std::vector<std::array<int, 2>> number(mesh.nodes.size());
    for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
        const auto [r, z] = mesh.nodes[k];
        const bool on_floor = z == floor;
        number[k][0] = r == 0.0 || r == wall || on_floor ? -1 : model.free_unknowns++;
        number[k][1] = on_floor ? -1 : model.free_unknowns++;
    }
    const auto positions = Element::gauss_positions();
    for (const auto& nodes : mesh.elements) {
        Element::Coordinates x;
        std::array<int, Element::dofs> unknowns{};
        for (int i = 0; i < Element::nodes; ++i) {
            x.col(i) << mesh.nodes[nodes[i]].r, mesh.nodes[nodes[i]].z;
            unknowns[2 * i] = number[nodes[i]][0];
            unknowns[2 * i + 1] = number[nodes[i]][1];
        }
        model.coordinates.push_back(x);
        model.unknowns.push_back(unknowns);
        for (const auto& position : positions) {
            model.points.push_back(Element::point(x, position));
            model.depth.push_back(Element::depth(x, position));
        }
    }
    build_pattern(model);
    return model;
}

template void build_pattern(Model<AxisymmetricQ8>&);

} // namespace pave::fe
