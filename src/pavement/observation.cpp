#include "pavement/observation.h"

#include "pavement/device.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace pave::pavement {
namespace {

// The cell of the lines that holds x; on a line the one behind it, at the end the last. A depth built from sums of
// layer thicknesses may miss its line by rounding.
int cell_of(const std::vector<double>& lines, double x) {
    const auto above = std::upper_bound(lines.begin(), lines.end(), x + 1e-9 * lines.back());
    return std::clamp(static_cast<int>(above - lines.begin()) - 1, 0, static_cast<int>(lines.size()) - 2);
}

double local_of(const std::vector<double>& lines, int cell, double x) {
    return 2.0 * (x - lines[cell]) / (lines[cell + 1] - lines[cell]) - 1.0;
}

// Lagrange weights on the (at most four) Gauss positions nearest to x among the cells first .. last.
// Position 2 c + k is the k-th of cell c. even: what is read is even about line 0, which is the first; position -1 - i
// beyond it is position i before it (a reading there is not extrapolated). chosen: the lines that tell which are
// nearest.
std::vector<std::pair<int, double>> interpolation(const std::vector<double>& lines, const std::vector<double>& chosen,
                                                  int first, int last, double x, bool even) {
    const int begin = 2 * first;
    const int end = 2 * (last + 1);
    const auto position_on = [&](const std::vector<double>& on, int index) {
        const int inside = index >= 0 ? index : -1 - index;
        const int c = inside / 2;
        const double half = (on[c + 1] - on[c]) / 2.0;
        const double at = on[c] + half * (1.0 + (inside % 2 == 0 ? -1.0 : 1.0) * std::numbers::inv_sqrt3);
        return index >= 0 ? at : 2.0 * on[0] - at;
    };
    const auto position = [&](int index) { return position_on(lines, index); };
    int behind = begin;
    while (behind < end && position_on(chosen, behind) < x) {
        ++behind;
    }
    const int lowest = even ? std::max(-2, -end) : begin;
    const int count = std::min(4, end - lowest);
    const int start = std::clamp(behind - count / 2, lowest, end - count);
    std::vector<std::pair<int, double>> weights;
    for (int i = start; i < start + count; ++i) {
        double weight = 1.0;
        for (int j = start; j < start + count; ++j) {
            weight *= i == j ? 1.0 : (x - position(j)) / (position(i) - position(j));
        }
        weights.emplace_back(i >= 0 ? i : -1 - i, weight);
    }
    return weights;
}

// Weights on the means of the (at most four) cells nearest to x among the cells first .. last: what the polynomial that
// has these means is at x. even, chosen: as above; cell -1 - i is cell i on the other side of line 0.
std::vector<std::pair<int, double>> reconstruction(const std::vector<double>& lines, const std::vector<double>& chosen,
                                                   int first, int last, double x, bool even) {
    const auto line_on = [](const std::vector<double>& on, int index) {
        return index >= 0 ? on[index] : 2.0 * on[0] - on[-index];
    };
    const int end = last + 1;
    int behind = first; // its middle is the first that does not lie before x
    while (behind < end && line_on(chosen, behind) + line_on(chosen, behind + 1) < 2.0 * x) {
        ++behind;
    }
    const int lowest = even ? std::max(-2, -end) : first;
    const int count = std::min(4, end - lowest);
    const int start = std::clamp(behind - count / 2, lowest, end - count);
    const auto line = [&](int k) { return line_on(lines, start + k); };
    // The integral of the polynomial is known on the lines. Slope at x of the Lagrange polynomial of line k:
    const auto slope = [&](int k) {
        double sum = 0.0;
        for (int out = 0; out <= count; ++out) {
            double product = out == k ? 0.0 : 1.0 / (line(k) - line(out));
            for (int j = 0; j <= count; ++j) {
                product *= j == k || j == out ? 1.0 : (x - line(j)) / (line(k) - line(j));
            }
            sum += product;
        }
        return sum;
    };
    std::vector<std::pair<int, double>> weights;
    double behind_cell = 0.0; // slopes of the lines behind it
    for (int k = count - 1; k >= 0; --k) {
        behind_cell += slope(k + 1);
        const int cell = start + k;
        weights.emplace_back(cell >= 0 ? cell : -1 - cell, behind_cell * (line(k + 1) - line(k)));
    }
    return weights;
}

// The cells of the layer that holds `depth`: first and last. layer: of the cells of one column, top to bottom.
std::pair<int, int> cells_of_layer(const std::vector<double>& z_lines, const int* layer, double depth) {
    const int cells = static_cast<int>(z_lines.size()) - 1;
    int first = cell_of(z_lines, depth);
    int last = first;
    while (first > 0 && layer[first - 1] == layer[first]) {
        --first;
    }
    while (last + 1 < cells && layer[last + 1] == layer[last]) {
        ++last;
    }
    return {first, last};
}

// add_uz(z, factor) adds factor times the downward displacement at depth z below (or above) the sensor. False: the
// sensor reads a strain or stress at a point.
bool observe_displacement(const Sensor& sensor, const auto& add_uz) {
    if (sensor.quantity == Quantity::deflection) {
        add_uz(sensor.depth, 1.0);
        return true;
    }
    if (sensor.quantity == Quantity::strain_zz && sensor.gauge > 0.0) {
        add_uz(sensor.depth - sensor.gauge / 2.0, 1.0 / sensor.gauge);
        add_uz(sensor.depth + sensor.gauge / 2.0, -1.0 / sensor.gauge);
        return true;
    }
    return false;
}

template <class Element>
void add_down(Observation<Element>& o, const fe::Model<Element>& model, int element,
              const typename Element::Position& at, double factor) {
    const auto shape = Element::shape(at);
    for (int k = 0; k < Element::nodes; ++k) {
        if (const int unknown = model.topology->unknowns[element][Element::dim * k + Element::down]; unknown >= 0) {
            o.on_displacement.emplace_back(unknown, factor * shape[k]);
        }
    }
}

bool is_stress(Quantity quantity) {
    return quantity == Quantity::stress_zz || quantity == Quantity::stress_xx || quantity == Quantity::stress_yy;
}

// Weights on the stress of Gauss points become weights on displacements when the sensor reads the strain there.
template <class Element>
Observation<Element> strain_or_stress(Observation<Element> o, const Sensor& sensor, const fe::Model<Element>& model) {
    if (is_stress(sensor.quantity)) {
        return o;
    }
    for (const auto& [point, weight, direction] : o.on_stress) {
        typename Element::Vector on_element = Element::Vector::Zero();
        Element::add_force(model.points[point], direction, weight, on_element);
        for (int k = 0; k < Element::dofs; ++k) {
            if (const int unknown = model.topology->unknowns[point / Element::gauss][k]; unknown >= 0) {
                o.on_displacement.emplace_back(unknown, on_element[k]);
            }
        }
    }
    o.on_stress.clear();
    return o;
}

// Where a layer hardly changes its volume, the mean stress at Gauss points swings about the right one, the more the
// nearer Poisson's ratio is to 1/2; its mean over a cell does not. elements: weights that make it at the sensor.
template <class Element>
void take_mean_stress_of_cells(Observation<Element>& o, const typename Element::Stress& direction,
                               const std::vector<std::pair<int, double>>& elements) {
    const double mean = direction.template head<3>().sum() / 3.0;
    typename Element::Stress trace = Element::Stress::Zero();
    trace.template head<3>().setOnes();
    for (std::size_t i = 0, count = o.on_stress.size(); i < count; ++i) {
        o.on_stress.push_back({o.on_stress[i].point, -mean * o.on_stress[i].weight, trace});
    }
    for (const auto& [element, weight] : elements) {
        for (int g = 0; g < Element::gauss; ++g) {
            o.on_stress.push_back({element * Element::gauss + g, mean * weight / Element::gauss, trace});
        }
    }
}

bool holds(const std::vector<bool>& layers, int layer) {
    return !layers.empty() && layers[layer];
}

// The observation of a sensor without shares.
Observation<fe::AxisymmetricQ8> observe_place(const Sensor& sensor, const mesh::AxisymmetricMesh& mesh,
                                              const fe::Model<fe::AxisymmetricQ8>& model,
                                              const mesh::AxisymmetricMesh& chosen,
                                              const std::vector<bool>& incompressible) {
    using Element = fe::AxisymmetricQ8;
    const double r = std::hypot(sensor.x, sensor.y);
    Observation<Element> o;
    const int column = cell_of(chosen.r_lines, r);
    const auto add_uz = [&](double z, double factor) {
        const int row = cell_of(chosen.z_lines, z);
        add_down(o, model, column * mesh.z_cells() + row,
                 {local_of(mesh.r_lines, column, r), local_of(mesh.z_lines, row, z)}, factor);
    };
    if (observe_displacement(sensor, add_uz)) {
        return o;
    }
    Element::Stress direction = Element::Stress::Zero();
    const double cos2 = r > 0.0 ? sensor.x * sensor.x / (r * r) : 1.0;
    switch (sensor.quantity) { // compression positive: minus
    case Quantity::stress_zz:
    case Quantity::strain_zz: direction[2] = -1.0; break;
    case Quantity::stress_xx:
    case Quantity::strain_xx: direction[0] = -cos2, direction[1] = cos2 - 1.0; break;
    default: direction[0] = cos2 - 1.0, direction[1] = -cos2; break;
    }
    static constexpr int gauss_number[2][2] = {{0, 3}, {1, 2}}; // [in r][in z]
    const auto [top, bottom] = cells_of_layer(chosen.z_lines, mesh.layer.data(), sensor.depth);
    for (const auto& [i, in_r] : interpolation(mesh.r_lines, chosen.r_lines, 0, mesh.r_cells() - 1, r, true)) {
        for (const auto& [j, in_z] : interpolation(mesh.z_lines, chosen.z_lines, top, bottom, sensor.depth, false)) {
            const int element = i / 2 * mesh.z_cells() + j / 2;
            o.on_stress.push_back({element * Element::gauss + gauss_number[i % 2][j % 2], in_r * in_z, direction});
        }
    }
    if (is_stress(sensor.quantity) && holds(incompressible, mesh.layer[top])) {
        std::vector<std::pair<int, double>> elements;
        for (const auto& [i, in_r] : reconstruction(mesh.r_lines, chosen.r_lines, 0, mesh.r_cells() - 1, r, true)) {
            for (const auto& [j, in_z] :
                 reconstruction(mesh.z_lines, chosen.z_lines, top, bottom, sensor.depth, false)) {
                elements.emplace_back(i * mesh.z_cells() + j, in_r * in_z);
            }
        }
        take_mean_stress_of_cells(o, direction, elements);
    }
    return strain_or_stress(std::move(o), sensor, model);
}

Observation<fe::Hex20> observe_place(const Sensor& sensor, const mesh::SolidMesh& mesh,
                                     const fe::Model<fe::Hex20>& model, const mesh::SolidMesh& chosen,
                                     const std::vector<bool>& incompressible) {
    using Element = fe::Hex20;
    const double x = std::abs(sensor.x);
    const double y = std::abs(sensor.y);
    Observation<Element> o;
    const int i = cell_of(chosen.x_lines, x);
    const int j = cell_of(chosen.y_lines, y);
    const auto add_uz = [&](double z, double factor) {
        const int k = cell_of(chosen.z_lines, z);
        add_down(o, model, mesh.element(i, j, k),
                 {local_of(mesh.x_lines, i, x), local_of(mesh.y_lines, j, y), local_of(mesh.z_lines, k, z)}, factor);
    };
    if (observe_displacement(sensor, add_uz)) {
        return o;
    }
    Element::Stress direction = Element::Stress::Zero();
    switch (sensor.quantity) { // compression positive: minus
    case Quantity::stress_zz:
    case Quantity::strain_zz: direction[2] = -1.0; break;
    case Quantity::stress_xx:
    case Quantity::strain_xx: direction[0] = -1.0; break;
    default: direction[1] = -1.0; break;
    }
    const auto [top, bottom] = cells_of_layer(chosen.z_lines, mesh.layer.data(), sensor.depth);
    for (const auto& [a, in_x] : interpolation(mesh.x_lines, chosen.x_lines, 0, mesh.x_cells() - 1, x, true)) {
        for (const auto& [b, in_y] : interpolation(mesh.y_lines, chosen.y_lines, 0, mesh.y_cells() - 1, y, true)) {
            for (const auto& [c, in_z] :
                 interpolation(mesh.z_lines, chosen.z_lines, top, bottom, sensor.depth, false)) {
                o.on_stress.push_back(
                    {mesh.element(a / 2, b / 2, c / 2) * Element::gauss + 4 * (a % 2) + 2 * (b % 2) + c % 2,
                     in_x * in_y * in_z, direction});
            }
        }
    }
    if (is_stress(sensor.quantity) && holds(incompressible, mesh.layer[top])) {
        std::vector<std::pair<int, double>> elements;
        for (const auto& [a, in_x] : reconstruction(mesh.x_lines, chosen.x_lines, 0, mesh.x_cells() - 1, x, true)) {
            for (const auto& [b, in_y] : reconstruction(mesh.y_lines, chosen.y_lines, 0, mesh.y_cells() - 1, y, true)) {
                for (const auto& [c, in_z] :
                     reconstruction(mesh.z_lines, chosen.z_lines, top, bottom, sensor.depth, false)) {
                    elements.emplace_back(mesh.element(a, b, c), in_x * in_y * in_z);
                }
            }
        }
        take_mean_stress_of_cells(o, direction, elements);
    }
    return strain_or_stress(std::move(o), sensor, model);
}

template <class Element, class Mesh>
Observation<Element> observe_shares(const Sensor& sensor, const Mesh& mesh, const fe::Model<Element>& model,
                                    const Mesh& chosen, const std::vector<bool>& incompressible) {
    if (sensor.shares.empty() && !is_of_device(sensor.quantity)) {
        return observe_place(sensor, mesh, model, chosen, incompressible);
    }
    // Shares beside each other read the same cells: each is weighed once.
    std::map<int, double> on_displacement;
    std::map<int, typename Element::Stress> on_stress;
    for (const PlainReading& plain : plain_readings(sensor)) {
        const auto o = observe_place(plain.sensor, mesh, model, chosen, incompressible);
        for (const auto& [unknown, weight] : o.on_displacement) {
            on_displacement[unknown] += plain.weight * weight;
        }
        for (const auto& [point, weight, direction] : o.on_stress) {
            auto& sum = on_stress.try_emplace(point, Element::Stress::Zero()).first->second;
            sum += plain.weight * weight * direction;
        }
    }
    Observation<Element> sum;
    sum.on_displacement.assign(on_displacement.begin(), on_displacement.end());
    for (const auto& [point, direction] : on_stress) {
        sum.on_stress.push_back({point, 1.0, direction});
    }
    return sum;
}

} // namespace

Observation<fe::AxisymmetricQ8> observe(const Sensor& sensor, const mesh::AxisymmetricMesh& mesh,
                                        const fe::Model<fe::AxisymmetricQ8>& model,
                                        const mesh::AxisymmetricMesh& chosen, const std::vector<bool>& incompressible) {
    return observe_shares(sensor, mesh, model, chosen, incompressible);
}

Observation<fe::Hex20> observe(const Sensor& sensor, const mesh::SolidMesh& mesh, const fe::Model<fe::Hex20>& model,
                               const mesh::SolidMesh& chosen, const std::vector<bool>& incompressible) {
    return observe_shares(sensor, mesh, model, chosen, incompressible);
}

} // namespace pave::pavement
