#include "fe/lanes/layout.h"

#include <algorithm>

namespace pave::fe::lanes {
namespace {

int strips_of(int rows) {
    return (rows + tile - 1) / tile;
}
std::size_t tiles_of(int strips) {
    return static_cast<std::size_t>(strips) * static_cast<std::size_t>(strips + 1) / 2 * tile * tile;
}

// Where a row of a front begins in its columns.
int place_in_columns(const Node& node, int row) {
    const int filled = row < node.columns ? row : node.column_strips * tile + row - node.columns;
    return filled / tile * tile * node.columns + filled % tile;
}

} // namespace

Layout::Layout(const Topology<AxisymmetricQ8>& topology) : layer(topology.layer) {
    const FactorStructure& s = topology.analysis->structure();
    const std::size_t count = s.supernodes.size() - 1;
    nodes.resize(count + 1);
    first_row = s.permutation.size();
    for (std::size_t n = 0; n < count; ++n) {
        const auto& from = s.supernodes[n];
        Node& node = nodes[n];
        node.first_column = from.first_column;
        node.columns = from.columns;
        node.rows_below = from.rows_below;
        node.column_strips = strips_of(from.columns);
        node.strips_below = strips_of(from.rows_below);
        node.first_child = from.first_child;
        node.next_sibling = from.next_sibling;
        node.is_constant = from.is_constant;
        node.is_kept = from.is_constant && from.parent >= 0 && !s.supernodes[from.parent].is_constant;
        node.row_start = rows.size();
        const auto below = s.rows.begin() + static_cast<std::ptrdiff_t>(from.row_start) + from.columns;
        rows.insert(rows.end(), below, below + from.rows_below);
        node.entry_start = from.entry_start;
        node.factor_start = factor;
        const auto filled = static_cast<std::size_t>(node.column_strips + node.strips_below) * tile;
        factor += filled * static_cast<std::size_t>(node.columns);
        most_rows = std::max(most_rows, filled);
        if (node.is_kept) {
            node.kept_start = kept;
            kept += tiles_of(node.strips_below);
        }
        if (!node.is_constant) {
            first_row = std::min(first_row, static_cast<std::size_t>(node.first_column));
            const std::size_t end = s.supernodes[n + 1].entry_start;
            if (!changing_entries.empty() && changing_entries.back().second == node.entry_start) {
                changing_entries.back().second = end;
            } else {
                changing_entries.emplace_back(node.entry_start, end);
            }
        }
    }
    nodes[count].entry_start = s.entry_value.size();
    for (std::size_t n = count; n-- > 0;) {
        const int parent = s.supernodes[n].parent;
        nodes[n].is_odd = parent >= 0 && !nodes[static_cast<std::size_t>(parent)].is_odd;
    }
    std::size_t stack[2][2] = {{0, 0}, {0, 0}}; // of the part and the stack
    strip_in_parent.assign(rows.size(), -1);
    tile_in_parent.assign(rows.size(), -1);
    column_in_parent.assign(rows.size(), -1);
    for (std::size_t n = 0; n < count; ++n) {
        Node& node = nodes[n];
        auto& tops = stack[node.is_constant ? 1 : 0];
        const std::size_t own = node.is_odd ? 1 : 0;
        for (int c = node.first_child; c >= 0; c = nodes[c].next_sibling) {
            tops[1 - own] -= nodes[c].is_constant == node.is_constant ? tiles_of(nodes[c].strips_below) : 0;
        }
        // It is written before what its children left is given up, but on the other stack.
        tops[own] += node.is_kept ? 0 : tiles_of(node.strips_below);
        largest_stack[own] = std::max(largest_stack[own], tops[own]);
        if (node.rows_below == 0) {
            continue;
        }
        const auto& from = s.supernodes[n];
        const Node& parent = nodes[from.parent];
        const int* in_parent = s.place_in_parent.data() + from.row_start + from.columns;
        for (int i = 0; i < node.rows_below; ++i) {
            const std::size_t at = node.row_start + static_cast<std::size_t>(i);
            const int row = in_parent[i];
            strip_in_parent[at] = place_in_columns(parent, row);
            if (row < parent.columns) {
                ++node.rows_into_columns;
                column_in_parent[at] = row * tile;
            } else {
                const int below = row - parent.columns;
                tile_in_parent[at] = static_cast<int>(tiles_of(below / tile)) + below % tile;
                column_in_parent[at] = below * tile;
            }
        }
    }
    entry_place.resize(s.entry_value.size());
    std::vector<int> place_of_value(s.entry_value.size());
    for (std::size_t n = 0; n < count; ++n) {
        const auto stride = static_cast<int>(s.supernodes[n].stride());
        for (std::size_t k = nodes[n].entry_start; k < nodes[n + 1].entry_start; ++k) {
            const int column = s.entry_place[k] / stride;
            entry_place[k] = place_in_columns(nodes[n], s.entry_place[k] % stride) + column * tile;
            place_of_value[static_cast<std::size_t>(s.entry_value[k])] = static_cast<int>(k);
        }
    }
    inverse.resize(s.permutation.size());
    for (std::size_t i = 0; i < inverse.size(); ++i) {
        inverse[static_cast<std::size_t>(s.permutation[i])] = static_cast<int>(i);
    }
    for (const auto& of_element : topology.unknowns) {
        for (const int k : of_element) {
            unknowns.push_back(k >= 0 ? inverse[static_cast<std::size_t>(k)] : -1);
        }
    }
    for (const auto& of_element : topology.scatter) {
        for (const int k : of_element) {
            places.push_back(k >= 0 ? place_of_value[static_cast<std::size_t>(k)] : -1);
        }
    }
}

Structure Layout::structure() const {
    return {.nodes = nodes.data(),
            .count = static_cast<int>(nodes.size()) - 1,
            .rows = rows.data(),
            .entry_place = entry_place.data(),
            .strip_in_parent = strip_in_parent.data(),
            .tile_in_parent = tile_in_parent.data(),
            .column_in_parent = column_in_parent.data()};
}

Elements Layout::elements(const std::vector<double>& shapes) const {
    return {.layer = layer.data(), .unknowns = unknowns.data(), .places = places.data(), .shapes = shapes.data()};
}

std::vector<double> Layout::shapes(const Model<AxisymmetricQ8>& model) {
    std::vector<double> all;
    all.reserve(model.points.size() * numbers_of_shape);
    for (const auto& point : model.points) {
        all.push_back(point.weight);
        for (Eigen::Index row = 0; row < 3; ++row) {
            for (Eigen::Index i = 0; i < nodes_of_element; ++i) {
                all.push_back(point.rows(row, i));
            }
        }
    }
    return all;
}

} // namespace pave::fe::lanes
