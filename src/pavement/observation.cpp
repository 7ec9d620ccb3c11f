#include "pavement/observation.h"

#include <algorithm>
#include <cmath>

namespace pave::pavement {
namespace {

using Element = fe::AxisymmetricQ8;

// The cell of the lines that holds x; on a line the one behind it, at the end the last. A depth built from sums of
// layer thicknesses may miss its line by rounding.
int cell_of(const std::vector<double>& lines, double x) {
    const auto above = std::upper_bound(lines.begin(), lines.end(), x + 1e-9 * lines.back());
    return std::clamp(static_cast<int>(above - lines.begin()) - 1, 0, static_cast<int>(lines.size()) - 2);
}

double local_of(const std::vector<double>& lines, int cell, double x) {
    return std::clamp(2.0 * (x - lines[cell]) / (lines[cell + 1] - lines[cell]) - 1.0, -1.0, 1.0);
}

// Lagrange weights on the (at most four) Gauss positions nearest to x among the cells first .. last.
// Position 2 c + k is the k-th of cell c.
std::vector<std::pair<int, double>> interpolation(const std::vector<double>& lines, int first, int last, double x) {
    const auto position = [&](int index) {
        const int c = index / 2;
        const double half = (lines[c + 1] - lines[c]) / 2.0;
        return lines[c] + half * (1.0 + (index % 2 == 0 ? -1.0 : 1.0) * std::numbers::inv_sqrt3);
    };
    const int begin = 2 * first;
    const int end = 2 * (last + 1);
    int behind = begin;
    while (behind < end && position(behind) < x) {
        ++behind;
    }
    const int count = std::min(4, end - begin);
    const int start = std::clamp(behind - count / 2, begin, end - count);
    std::vector<std::pair<int, double>> weights;
    for (int i = start; i < start + count; ++i) {
        double weight = 1.0;
        for (int j = start; j < start + count; ++j) {
            weight *= i == j ? 1.0 : (x - position(j)) / (position(i) - position(j));
        }
        weights.emplace_back(i, weight);
    }
    return weights;
}

} // namespace

Observation observe(const Sensor& sensor, const mesh::AxisymmetricMesh& mesh, const fe::Model<Element>& model) {
    const double r = std::hypot(sensor.x, sensor.y);
    Observation o;
    const int column = cell_of(mesh.r_lines, r);
    const auto add_uz = [&](double z, double factor) {
        const int row = cell_of(mesh.z_lines, z);
        const int element = column * mesh.z_cells() + row;
        const auto shape = Element::shape(local_of(mesh.r_lines, column, r), local_of(mesh.z_lines, row, z));
        for (int k = 0; k < Element::nodes; ++k) {
            if (const int unknown = model.unknowns[element][2 * k + 1]; unknown >= 0) {
                o.on_displacement.emplace_back(unknown, factor * shape[k]);
            }
        }
    };
    if (sensor.quantity == Quantity::deflection) {
        add_uz(sensor.depth, 1.0);
        return o;
    }
    if (sensor.quantity == Quantity::strain_zz && sensor.gauge > 0.0) {
        add_uz(sensor.depth - sensor.gauge / 2.0, 1.0 / sensor.gauge);
        add_uz(sensor.depth + sensor.gauge / 2.0, -1.0 / sensor.gauge);
        return o;
    }

    const double cos2 = r > 0.0 ? sensor.x * sensor.x / (r * r) : 1.0;
    bool is_stress = false;
    switch (sensor.quantity) { // compression positive: minus
    case Quantity::stress_zz: is_stress = true; [[fallthrough]];
    case Quantity::strain_zz: o.direction[2] = -1.0; break;
    case Quantity::stress_xx: is_stress = true; [[fallthrough]];
    case Quantity::strain_xx: o.direction[0] = -cos2, o.direction[1] = cos2 - 1.0; break;
    case Quantity::stress_yy: is_stress = true; [[fallthrough]];
    default: o.direction[0] = cos2 - 1.0, o.direction[1] = -cos2; break;
    }
    // The rows of cells of the layer.
    const int row = cell_of(mesh.z_lines, sensor.depth);
    int top = row;
    int bottom = row;
    while (top > 0 && mesh.layer[top - 1] == mesh.layer[row]) {
        --top;
    }
    while (bottom + 1 < mesh.z_cells() && mesh.layer[bottom + 1] == mesh.layer[row]) {
        ++bottom;
    }
    static constexpr int gauss_number[2][2] = {{0, 3}, {1, 2}}; // [in r][in z]
    for (const auto& [i, in_r] : interpolation(mesh.r_lines, 0, mesh.r_cells() - 1, r)) {
        for (const auto& [j, in_z] : interpolation(mesh.z_lines, top, bottom, sensor.depth)) {
            const int element = i / 2 * mesh.z_cells() + j / 2;
            o.on_stress.emplace_back(element * Element::gauss + gauss_number[i % 2][j % 2], in_r * in_z);
        }
    }
    if (is_stress) {
        return o;
    }
    for (const auto& [point, weight] : o.on_stress) {
        Element::Vector on_element = Element::Vector::Zero();
        Element::add_force(model.points[point], o.direction, weight, on_element);
        for (int k = 0; k < Element::dofs; ++k) {
            if (const int unknown = model.unknowns[point / Element::gauss][k]; unknown >= 0) {
                o.on_displacement.emplace_back(unknown, on_element[k]);
            }
        }
    }
    o.on_stress.clear();
    return o;
}

} // namespace pave::pavement
