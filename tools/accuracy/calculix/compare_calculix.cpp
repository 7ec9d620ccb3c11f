// The linear answer of this library against that of CalculiX on the same mesh: same nodes, elements (C3D20R integrates
// by 2 x 2 x 2 points as Hex20 does), held displacements, nodal forces and materials. What is left is rounding, unless
// one of the two is wrong.
// A stress-dependent layer is replaced by a linear one: its directions, and its modulus under the weight of the section
// alone at the middle of the layer.
// usage: compare_calculix STUDY [LOAD]
#include "base/error.h"
#include "base/units.h"
#include "pavement/load_model.h"
#include "run/blas.h"
#include "study/study.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <sstream>

namespace {

using namespace pave;
using pavement::Solid;
using Element = fe::Hex20;

constexpr double allowed_difference = 1e-5;

double seconds_of(const auto& action) {
    const auto begin = std::chrono::steady_clock::now();
    action();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// A layer with the directions of another law and one modulus.
class Frozen final : public material::Law {
public:
    Frozen(double modulus, mechanics::Stiffness<6> unit) : modulus_(modulus), unit_(std::move(unit)) {}

    std::string_view name() const override { return "frozen"; }
    std::string_view summary() const override { return "one modulus of a stress-dependent law"; }
    std::span<const material::ParameterInfo> parameters() const override { return {}; }
    bool stress_dependent() const override { return false; }
    std::span<const std::size_t> scale_parameters() const override { return {}; }
    material::Modulus modulus(std::span<const double>, mechanics::Invariants) const override {
        return {.value = modulus_};
    }
    double modulus_derivative(std::span<const double>, mechanics::Invariants, const pave::material::Modulus&,
                              std::size_t) const override {
        return 0.0;
    }
    mechanics::Stiffness<6> unit_stiffness(std::span<const double>, mechanics::Invariants) const override {
        return unit_;
    }
    mechanics::Stiffness<6> unit_stiffness_derivative(std::span<const double>, mechanics::Invariants,
                                                      std::size_t) const override {
        return mechanics::Stiffness<6>::Zero();
    }
    std::string impossible(std::span<const double>) const override { return {}; }

private:
    double modulus_;
    mechanics::Stiffness<6> unit_;
};

Frozen frozen(const fe::LayerMaterial& layer) {
    const auto at = mechanics::invariants<6>(layer.initial_stress<6>(layer.top + layer.thickness / 2.0));
    return {layer.law->modulus(layer.parameters, at).value, layer.law->unit_stiffness(layer.parameters, at)};
}

// The unknown of each displacement of each node, -1 when it is held.
using Unknowns = std::vector<std::array<int, 3>>;

Unknowns unknowns_of(const pavement::Parts<Solid>& parts) {
    Unknowns unknowns(parts.mesh.nodes.size());
    for (std::size_t e = 0; e < parts.mesh.elements.size(); ++e) {
        for (int k = 0; k < Element::dofs; ++k) {
            unknowns[parts.mesh.elements[e][k / 3]][k % 3] = parts.model.topology->unknowns[e][k];
        }
    }
    return unknowns;
}

// CalculiX reads 20 characters of a number.
std::string number(double value) {
    return fmt::format("{:.13e}", value);
}

// The linear law as CalculiX words it; any other by its stiffness, in CalculiX's order of components.
void write_material(std::ostream& out, const fe::LayerMaterial& layer) {
    const auto poisson = layer.law->index_of("poisson");
    const double modulus = layer.law->modulus(layer.parameters, {}).value;
    if (poisson) {
        out << fmt::format("*ELASTIC\n{}, {}\n", number(modulus), number(layer.parameters[*poisson]));
        return;
    }
    const mechanics::Stiffness<6> d = modulus * layer.law->unit_stiffness(layer.parameters, {});
    out << "*ELASTIC, TYPE=ORTHO\n";
    for (const double value : {d(0, 0), d(0, 1), d(1, 1), d(0, 2), d(1, 2), d(2, 2), d(5, 5)}) {
        out << number(value) << ", ";
    }
    out << number(d(3, 3)) << ",\n" << number(d(4, 4)) << "\n";
}

// Input of CalculiX; nodes and elements are counted from 1.
void write_input(const std::string& file, const pavement::Parts<Solid>& parts, const Unknowns& unknowns) {
    std::ofstream out(file);
    out << "*NODE, NSET=ALL\n";
    for (std::size_t k = 0; k < parts.mesh.nodes.size(); ++k) {
        const auto& [x, y, z] = parts.mesh.nodes[k];
        out << fmt::format("{}, {}, {}, {}\n", k + 1, number(x), number(y), number(z));
    }
    for (int layer = 0; layer < parts.mesh.layers; ++layer) {
        // Middle nodes in the same order as here: upper, lower, vertical edges.
        out << fmt::format("*ELEMENT, TYPE=C3D20R, ELSET=LAYER{}\n", layer + 1);
        for (std::size_t e = 0; e < parts.mesh.elements.size(); ++e) {
            if (parts.mesh.layer[e] != layer) {
                continue;
            }
            out << e + 1;
            for (int k = 0; k < Element::nodes; ++k) {
                out << (k == 10 ? ",\n" : ", ") << parts.mesh.elements[e][k] + 1;
            }
            out << "\n";
        }
        out << fmt::format("*MATERIAL, NAME=LAYER{}\n", layer + 1);
        write_material(out, parts.layers[layer]);
        out << fmt::format("*SOLID SECTION, ELSET=LAYER{0}, MATERIAL=LAYER{0}\n", layer + 1);
    }
    out << "*BOUNDARY\n";
    std::string floor;
    std::string forces;
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
        for (int d = 0; d < 3; ++d) {
            if (unknowns[k][d] < 0) {
                out << fmt::format("{}, {}\n", k + 1, d + 1);
            } else if (const double force = parts.load[unknowns[k][d]]; force != 0.0) {
                forces += fmt::format("{}, {}, {}\n", k + 1, d + 1, number(force));
            }
        }
        if (unknowns[k][Element::down] < 0) {
            floor += fmt::format("{}\n", k + 1);
        }
    }
    out << "*NSET, NSET=FLOOR\n" << floor;
    out << "*STEP\n*STATIC\n*CLOAD\n" << forces;
    out << "*NODE PRINT, NSET=ALL\nU\n*NODE PRINT, NSET=FLOOR, TOTALS=ONLY\nRF\n*END STEP\n";
    out.close();
    if (!out) {
        throw std::runtime_error(file + " cannot be written");
    }
}

struct Answer {
    std::vector<std::array<double, 3>> displacement; // of every node [m]
    double floor_force = 0.0;                        // vertical, of the floor on the section [N]
};

// The printed results: displacements with seven digits.
Answer read_answer(const std::string& file, std::size_t nodes) {
    std::ifstream in(file);
    Answer answer;
    std::size_t displacements = 0;
    bool floor = false;
    enum class Table { none, displacement, force } table = Table::none;
    for (std::string line; std::getline(in, line);) {
        if (line.find("displacements (") != std::string::npos) {
            table = Table::displacement;
            answer.displacement.resize(nodes);
            continue;
        }
        if (line.find("total force (") != std::string::npos) {
            table = Table::force;
            continue;
        }
        std::istringstream row(line);
        std::size_t node = 0;
        std::array<double, 3> v{};
        if (table == Table::displacement && row >> node >> v[0] >> v[1] >> v[2]) {
            answer.displacement.at(node - 1) = v;
            ++displacements;
        } else if (table == Table::force && row >> v[0] >> v[1] >> v[2]) {
            answer.floor_force = v[Element::down];
            floor = true;
        }
    }
    if (displacements != nodes || !floor) {
        throw std::runtime_error(fmt::format("{} holds the displacements of {} nodes instead of {}{}", file,
                                             displacements, nodes, floor ? "" : ", and no reaction of the floor"));
    }
    return answer;
}

int load_number(const explore::study::Study& study, const std::string& name) {
    std::vector<std::string> names;
    for (const auto& load : study.model.loads) {
        if (load.name == name) {
            return static_cast<int>(names.size());
        }
        names.push_back(load.name);
    }
    throw Error({.file = study.file}, "this load is not in the study", "\"" + name + "\"", join(names));
}

bool compare(const std::string& file, const char* load_name) {
    auto study = explore::study::load_study(file);
    pavement::Case& c = study.model;
    if (c.loads.empty()) {
        throw Error({.file = file}, "the study has no load");
    }
    const int load = load_name != nullptr ? load_number(study, load_name) : 0;
    // The path of the stress-dependent layers, for its time.
    c.settings.integration = pavement::Integration::incremental;
    pavement::make_load_model(c, load); // refuses a load that does not fit

    pavement::Parts<Solid> parts;
    std::unique_ptr<fe::Solver<Element>> solver;
    const double model_seconds = seconds_of([&] {
        parts = pavement::parts_of<Solid>(c, load);
        solver = std::make_unique<fe::Solver<Element>>(parts.model);
    });
    const auto as_studied = parts.layers;
    std::vector<Frozen> laws;
    laws.reserve(parts.layers.size());
    for (auto& layer : parts.layers) {
        if (layer.law->stress_dependent()) {
            laws.push_back(frozen(layer));
            layer.law = &laws.back();
        }
    }
    const auto solve = [&](const std::vector<fe::LayerMaterial>& layers) {
        auto solution = solver->incremental(layers, parts.load, {}, c.settings.solver);
        if (!solution) {
            throw std::runtime_error(solution.failure().reason);
        }
        return std::move(solution).value();
    };
    fe::Solution<Element> own;
    const double linear_seconds = seconds_of([&] { own = solve(parts.layers); });

    const auto unknowns = unknowns_of(parts);
    const auto folder = std::filesystem::absolute("output/compare-calculix") / study.stem();
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    write_input(folder / "model.inp", parts, unknowns);
    std::filesystem::current_path(folder); // CalculiX leaves its files where it runs
    int status = 0;
    const double calculix_seconds =
        seconds_of([&] { status = std::system("OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 ccx model >ccx.log 2>&1"); });
    if (status != 0) {
        throw std::runtime_error("ccx failed: its words are in " + (folder / "ccx.log").string());
    }
    const Answer calculix = read_answer(folder / "model.dat", parts.mesh.nodes.size());

    double largest = 0.0;
    double difference = 0.0;
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
        for (int d = 0; d < 3; ++d) {
            const double u = unknowns[k][d] < 0 ? 0.0 : own.displacement[unknowns[k][d]];
            largest = std::max(largest, std::abs(u));
            difference = std::max(difference, std::abs(u - calculix.displacement[k][d]));
        }
    }
    difference /= largest;

    fmt::print("{}, load \"{}\": {} elements, {} unknowns\n", study.title, c.loads[load].name,
               parts.mesh.elements.size(), parts.model.free_unknowns());
    for (std::size_t l = 0; l < c.layers.size(); ++l) {
        fmt::print("  {:<40} {:>10.1f} MPa{}\n", "layer \"" + c.layers[l].name + "\"",
                   parts.layers[l].law->modulus(parts.layers[l].parameters, {}).value / unit::MPa,
                   as_studied[l].law->stress_dependent() ? ", frozen: its law under the weight of the section" : "");
    }
    const auto row = [](const std::string& what, double value, std::string_view unit) {
        fmt::print("  {:<40} {:>10.3f} {}\n", what, value, unit);
    };
    row("load on the quarter: wanted", c.loads[load].total_force() / 4.0 / unit::kN, "kN");
    row("  sum of the nodal forces", parts.load.sum() / unit::kN, "kN");
    row("  reaction of the floor, CalculiX", -calculix.floor_force / unit::kN, "kN");
    row("largest displacement", largest / unit::mm, "mm");
    row("CalculiX, the whole process", calculix_seconds, "s");
    row("here, mesh and analysis of the matrix", model_seconds, "s");
    row("here, one linear solution on it", linear_seconds, "s");
    if (!laws.empty()) {
        row("here, the stress-dependent load path", seconds_of([&] { solve(as_studied); }), "s");
    }
    const bool agree = difference <= allowed_difference;
    fmt::print("  {:<40} {:>10.1e} of the largest, allowed {:.0e}: {}\n", "largest difference in displacement",
               difference, allowed_difference, agree ? "agree" : "DISAGREE");
    return agree;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2 || argc > 3) {
        fmt::print(stderr, "usage: compare_calculix STUDY [LOAD]\n");
        return 2;
    }
    explore::run::prepare_blas();
    try {
        return compare(argv[1], argc > 2 ? argv[2] : nullptr) ? 0 : 1;
    } catch (const Error& error) {
        fmt::print(stderr, "compare-calculix: {}\n", error.what());
        return 2;
    } catch (const std::exception& error) {
        fmt::print(stderr, "compare-calculix: {}\n", error.what());
        return 1;
    }
}
