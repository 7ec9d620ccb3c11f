// The cost of runs in the lanes of vectors beside runs one after the other, for every set of instructions that this
// processor has: the load path of a study, without derivatives and with five, on its mesh and on finer ones; and the
// rate of their elimination beside one dense factorisation of the same work; and fronts of one matrix, beside Eigen's
// functions. CPU time of one thread, each the median of rounds in which everything is measured once, in turn.
// usage: lanes [ROUNDS], from the top of the repository
#include "fe/batch_solver.h"
#include "fe/lanes/layout.h"
#include "pavement/load_model.h"
#include "pavement/observation.h"
#include "run/blas.h"
#include "run/parallel.h"
#include "study/problems.h"

#include <algorithm>
#include <fmt/format.h>

extern "C" void dpotrf_(const char* part, const int* n, double* a, const int* stride, int* info);

namespace {

using namespace pave;
using Element = fe::AxisymmetricQ8;
using fe::lanes::Buffer;
using fe::lanes::Kernels;

double milliseconds_of(const auto& work) {
    const std::int64_t begin = explore::run::thread_cpu_ns();
    work();
    return 1e-6 * static_cast<double>(explore::run::thread_cpu_ns() - begin);
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

// The sections of a study at points all over its box.
struct Sections {
    pavement::Parts<pavement::Axisymmetric> parts;
    fe::SolverSettings settings;
    std::vector<fe::Functional<Element>> readings;
    std::vector<std::vector<fe::LayerMaterial>> layers;
    std::vector<fe::BatchRun> runs;

    Sections(const explore::study::Study& study, int refine, std::size_t count)
        : parts(parts_at(study, refine)),
          settings(study.model.settings.solver) {
        pavement::Case c = study.model;
        const auto soft = pavement::incompressible_layers(c);
        for (const pavement::Sensor& sensor : c.sensors) {
            readings.push_back(pavement::observe(sensor, parts.mesh, parts.model, parts.mesh, soft));
        }
        for (std::size_t i = 0; i < count; ++i) {
            double share = 0.5;
            for (std::size_t k = 0; k < study.parameters.size(); ++k) {
                share = std::fmod(share + 0.618 * static_cast<double>(i + 1) + 0.31 * static_cast<double>(k), 1.0);
                study.parameters[k].in(c) = study.parameters[k].to_si * study.space.axes[k].physical(share);
            }
            layers.push_back(pavement::materials_of(c));
        }
        for (const auto& own : layers) {
            runs.push_back({&own, &parts.load, &readings});
        }
    }
    static pavement::Parts<pavement::Axisymmetric> parts_at(const explore::study::Study& study, int refine) {
        pavement::Case c = study.model;
        c.settings.refine = refine;
        return pavement::parts_of<pavement::Axisymmetric>(c, 0);
    }
};

// The elimination alone of one matrix in every lane.
struct Elimination {
    const Kernels& kernels;
    fe::lanes::Layout layout;
    fe::lanes::Structure structure;
    Buffer values, factor, inverse, stack, other_stack, kept, rows;
    alignas(fe::lanes::alignment) std::int64_t definite[8] = {};

    Elimination(const pavement::Parts<pavement::Axisymmetric>& parts, const Kernels& by)
        : kernels(by),
          layout(*parts.model.topology),
          structure(layout.structure()) {
        const auto shapes = fe::lanes::Layout::shapes(parts.model);
        const auto mesh = layout.elements(shapes);
        const auto width = static_cast<std::size_t>(by.lanes);
        Buffer unit;
        Buffer modulus;
        const std::size_t layers = parts.layers.size();
        unit.assign_zero(layers * fe::lanes::unit_numbers, by.lanes);
        modulus.assign_zero(layers, by.lanes);
        for (std::size_t i = 0; i < layers * width; ++i) {
            modulus[i] = 1e8;
        }
        for (std::size_t l = 0; l < layers; ++l) {
            const double numbers[] = {1.35, 0.58, 0.58, 1.35, 0.38}; // Poisson's ratio 0.3
            for (std::size_t i = 0; i < fe::lanes::unit_numbers * width; ++i) {
                unit[l * fe::lanes::unit_numbers * width + i] = numbers[i / width];
            }
        }
        std::vector<int> elements(parts.model.topology->layer.size());
        for (std::size_t e = 0; e < elements.size(); ++e) {
            elements[e] = static_cast<int>(e);
        }
        values.assign_zero(layout.entry_place.size(), by.lanes);
        by.assemble(mesh, elements.data(), static_cast<int>(elements.size()), unit.data(), nullptr, modulus.data(),
                    values.data());
        factor.resize(layout.factor, by.lanes);
        inverse.resize(layout.inverse.size(), by.lanes);
        stack.resize(layout.largest_stack[0], by.lanes);
        other_stack.resize(layout.largest_stack[1], by.lanes);
        kept.resize(layout.kept, by.lanes);
        rows.resize(fe::lanes::tile * layout.most_rows, by.lanes);
        eliminate(fe::lanes::Part::constant);
    }
    void eliminate(fe::lanes::Part part) {
        fe::lanes::Factor f{factor.data(), inverse.data(), {stack.data(), other_stack.data()},
                            kept.data(),   rows.data(),    definite};
        kernels.eliminate(structure, part, values.data(), f, nullptr);
    }
};

void paths(const explore::study::Study& study, const std::vector<const Kernels*>& all, int rounds) {
    const std::vector<fe::Variation> five{{fe::Variation::Kind::law_parameter, 1, 1},
                                          {fe::Variation::Kind::law_parameter, 1, 2},
                                          {fe::Variation::Kind::law_parameter, 1, 3},
                                          {fe::Variation::Kind::law_parameter, 1, 4},
                                          {fe::Variation::Kind::law_parameter, 2, 0}};
    fmt::print("| load path, one thread | one by one, CPU ms a run |");
    for (const Kernels* kernels : all) {
        fmt::print(" {} lanes, {} | times as fast |", kernels->lanes, kernels->instructions);
    }
    fmt::print(" MB |\n|---|---:|");
    for (std::size_t k = 0; k < all.size(); ++k) {
        fmt::print("---:|---:|");
    }
    fmt::print("---:|\n");
    for (const int refine : {1, 2, 3}) {
        const Sections sections(study, refine, 8);
        for (const auto& by : {std::vector<fe::Variation>{}, five}) {
            fe::Solver<Element> one(sections.parts.model);
            std::vector<std::unique_ptr<fe::BatchSolver>> solvers;
            for (const Kernels* kernels : all) {
                solvers.push_back(std::make_unique<fe::BatchSolver>(sections.parts.model, kernels));
            }
            const double runs = static_cast<double>(sections.runs.size());
            std::vector<double> alone;
            std::vector<std::vector<double>> together(all.size());
            for (int round = -1; round < rounds; ++round) { // the first one makes the workspaces
                const double ms = milliseconds_of([&] {
                    for (const auto& layers : sections.layers) {
                        one.incremental(layers, sections.parts.load, by, sections.settings);
                    }
                });
                if (round >= 0) {
                    alone.push_back(ms / runs);
                }
                for (std::size_t k = 0; k < all.size(); ++k) {
                    const double of_lanes =
                        milliseconds_of([&] { solvers[k]->incremental(sections.runs, by, sections.settings); });
                    if (round >= 0) {
                        together[k].push_back(of_lanes / runs);
                    }
                }
            }
            fmt::print("| {} unknowns{} | {:.1f} |", sections.parts.model.free_unknowns(),
                       by.empty() ? "" : ", five derivatives", median(alone));
            for (const auto& ms : together) {
                fmt::print(" {:.2f} | {:.1f} |", median(ms), median(alone) / median(ms));
            }
            fmt::print(" {:.0f} |\n", 1e-6 * static_cast<double>(solvers[0]->memory()));
        }
    }
}

void eliminations(const explore::study::Study& study, const std::vector<const Kernels*>& all, int rounds) {
    const Sections sections(study, 1, 1);
    std::vector<std::unique_ptr<Elimination>> of_all;
    for (const Kernels* kernels : all) {
        of_all.push_back(std::make_unique<Elimination>(sections.parts, *kernels));
    }
    const double once = sections.parts.model.topology->analysis->structure().changing_operations();
    const int n = static_cast<int>(std::cbrt(3.0 * once * all[0]->lanes));
    const Eigen::MatrixXd dense = Eigen::MatrixXd::Constant(n, n, 0.5) + n * Eigen::MatrixXd::Identity(n, n);
    std::vector<std::vector<double>> rates(all.size());
    std::vector<double> of_dense;
    constexpr int repeats = 20;
    for (int round = -1; round < rounds; ++round) {
        for (std::size_t k = 0; k < all.size(); ++k) {
            const double ms = milliseconds_of([&] {
                for (int i = 0; i < repeats; ++i) {
                    of_all[k]->eliminate(fe::lanes::Part::changing);
                }
            });
            rates[k].push_back(1e-6 * repeats * once * all[k]->lanes / ms);
        }
        Eigen::MatrixXd a = dense;
        int info = 0;
        const double ms = milliseconds_of([&] { dpotrf_("L", &n, a.data(), &n, &info); });
        of_dense.push_back(1e-6 * std::pow(n, 3) / 3.0 / ms);
    }
    fmt::print("\n| elimination of what changes, {:.1f} million operations a matrix | GFlop/s |\n|---|---:|\n",
               1e-6 * once);
    for (std::size_t k = 0; k < all.size(); ++k) {
        fmt::print("| {} matrices, {} | {:.1f} |\n", all[k]->lanes, all[k]->instructions, median(rates[k]));
    }
    fmt::print("| one dense matrix of the same work as {}, {} rows, `dpotrf` | {:.1f} |\n", all[0]->lanes, n,
               median(of_dense));
}

// A front as the factorisation of one matrix eliminates it: its columns, and what they leave.
void fronts(const std::vector<const Kernels*>& all, int rounds) {
    fmt::print("\n| one front, rows and columns | Eigen, us |");
    for (const Kernels* kernels : all) {
        fmt::print(" {} lanes, {} | of Eigen's time |", kernels->lanes, kernels->instructions);
    }
    fmt::print("\n|---|---:|");
    for (std::size_t k = 0; k < all.size(); ++k) {
        fmt::print("---:|---:|");
    }
    fmt::print("\n");
    for (const auto& [rows, columns] : {std::pair{30, 12}, {60, 20}, {100, 30}, {150, 50}}) {
        const Eigen::MatrixXd root = Eigen::MatrixXd::Random(rows, rows);
        const Eigen::MatrixXd matrix = root * root.transpose() + rows * Eigen::MatrixXd::Identity(rows, rows);
        const std::ptrdiff_t stride = (rows + 7) / 8 * 8 + 8;
        Buffer front;
        front.assign_zero(static_cast<std::size_t>(stride * rows), 1);
        std::vector<double> by_eigen;
        std::vector<std::vector<double>> by_all(all.size());
        constexpr int repeats = 200;
        for (int round = -1; round < rounds; ++round) {
            Eigen::MatrixXd a;
            const double us =
                1e3 / repeats * milliseconds_of([&] {
                    for (int i = 0; i < repeats; ++i) {
                        a = matrix;
                        auto diagonal = a.topLeftCorner(columns, columns);
                        const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(diagonal);
                        auto below = a.bottomLeftCorner(rows - columns, columns);
                        diagonal.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
                        a.bottomRightCorner(rows - columns, rows - columns)
                            .selfadjointView<Eigen::Lower>()
                            .rankUpdate(below, -1.0);
                    }
                });
            by_eigen.push_back(us);
            for (std::size_t k = 0; k < all.size(); ++k) {
                by_all[k].push_back(1e3 / repeats * milliseconds_of([&] {
                                        for (int i = 0; i < repeats; ++i) {
                                            Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>(
                                                front.data(), rows, rows, Eigen::OuterStride<>(stride)) = matrix;
                                            all[k]->eliminate_dense(front.data(), rows, columns, stride);
                                        }
                                    }));
            }
        }
        fmt::print("| {}, {} | {:.2f} |", rows, columns, median(by_eigen));
        for (const auto& us : by_all) {
            fmt::print(" {:.2f} | {:.0f} % |", median(us), 100.0 * median(us) / median(by_eigen));
        }
        fmt::print("\n");
    }
}

} // namespace

int main(int argc, char** argv) {
    explore::run::prepare_blas();
    const int rounds = argc > 1 ? std::stoi(argv[1]) : 9;
    const Kernels* list[8];
    const std::vector<const Kernels*> all(list, list + fe::lanes::usable_kernels(list, 8));
    const auto study = explore::study::load_study("grids/captif-p1-fwd.toml");
    paths(study, all, rounds);
    eliminations(study, all, rounds);
    fronts(all, rounds);
    return 0;
}
