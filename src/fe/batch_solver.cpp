#include "fe/batch_solver.h"

#include "fe/lanes/inputs.h"
#include "fe/load_path.h"

#include <algorithm>
#include <cmath>

namespace pave::fe {
namespace {

using lanes::Buffer;
using lanes::Kernels;
using lanes::Part;
using Kind = Variation::Kind;
using Element = AxisymmetricQ8;

constexpr std::size_t most_variations = 64;
constexpr std::size_t most_lanes = lanes::most_lanes;

// The path of all lanes and its rates; rows in the order of elimination.
struct LanePath {
    const Kernels* kernels = nullptr;
    std::size_t first_row = 0; // rows before it are not followed
    std::size_t rows = 0;
    std::size_t count = 0;
    Buffer u, stress, du, d_stress;

    void set_zero(const Kernels* by, std::size_t first, std::size_t unknowns, std::size_t points,
                  std::size_t variations) {
        kernels = by;
        first_row = first;
        rows = unknowns;
        count = variations;
        u.assign_zero(unknowns, by->lanes);
        stress.assign_zero(4 * points, by->lanes);
        du.assign_zero(unknowns * variations, by->lanes);
        d_stress.assign_zero(4 * points * variations, by->lanes);
    }
    // this := from + the sum of factors times rates.
    void set_sum(const LanePath& from, std::span<const double> factors, std::span<const LanePath* const> rates) {
        const auto combine = [&](Buffer LanePath::*part, std::size_t skipped) {
            std::array<const double*, LoadPath<LanePath>::stages> of_rates{};
            const std::size_t start = skipped * static_cast<std::size_t>(kernels->lanes);
            for (std::size_t j = 0; j < rates.size(); ++j) {
                of_rates[j] = (rates[j]->*part).data() + start;
            }
            const std::size_t size = ((this->*part).size() - start) / static_cast<std::size_t>(kernels->lanes);
            kernels->combine((this->*part).data() + start, (from.*part).data() + start, static_cast<int>(rates.size()),
                             factors.data(), of_rates.data(), size);
        };
        combine(&LanePath::u, first_row);
        combine(&LanePath::stress, 0);
        if (count > 0) {
            combine(&LanePath::du, first_row * count);
            combine(&LanePath::d_stress, 0);
        }
    }
};

} // namespace

struct BatchSolver::Work : lanes::Inputs {
    using Inputs::Inputs;

    Buffer reduced; // the load, its constant rows eliminated
    Buffer linear;  // values of linear layers
    Buffer values;
    Buffer factor_values, factor_inverse, factor_stack, factor_other_stack, factor_kept, factor_rows;
    alignas(lanes::alignment) std::array<std::int64_t, most_lanes> definite{}; // -1, or 0 where it was found not to be
    Buffer stiffness_rate;                                                     // of one linear layer by one variation
    LoadPath<LanePath> path;

    lanes::Factor factor() {
        return {.values = factor_values.data(),
                .inverse = factor_inverse.data(),
                .stack = {factor_stack.data(), factor_other_stack.data()},
                .kept = factor_kept.data(),
                .rows = factor_rows.data(),
                .definite = definite.data()};
    }
    // The constant part of the path: linear layers, eliminated where they are by themselves.
    void eliminate_constant() {
        linear.assign_zero(layout.entry_place.size(), kernels.lanes);
        for (const auto& elements : of_layer) {
            kernels.assemble(mesh, elements.data(), static_cast<int>(elements.size()), unit.data(), nullptr,
                             modulus.data(), linear.data());
        }
        values.resize(layout.entry_place.size(), kernels.lanes);
        factor_values.resize(layout.factor, kernels.lanes);
        factor_inverse.resize(rows(), kernels.lanes);
        factor_stack.resize(layout.largest_stack[0], kernels.lanes);
        factor_other_stack.resize(layout.largest_stack[1], kernels.lanes);
        factor_kept.resize(layout.kept, kernels.lanes);
        factor_rows.resize(lanes::tile * layout.most_rows, kernels.lanes);
        definite.fill(-1);
        reduced.resize(rows(), kernels.lanes);
        std::copy(load.data(), load.data() + load.size(), reduced.data());
        auto f = factor();
        kernels.eliminate(structure, Part::constant, linear.data(), f, reduced.data());
    }

    bool all_have_failed() const {
        return std::none_of(definite.begin(), definite.begin() + static_cast<std::ptrdiff_t>(width),
                            [](std::int64_t d) { return d != 0; });
    }

    // d(state)/d(load factor) at a state. False: no matrix is definite.
    bool rate(const LanePath& at, LanePath& out) {
        const lanes::Points p = points_of_path();
        const auto n = static_cast<int>(count());
        kernels.moduli(mesh, p, at.stress.data(), at.d_stress.data(), modulus_at.data(), modulus_rate_at.data());
        for (const auto& [first, end] : layout.changing_entries) {
            std::copy(linear.data() + first * width, linear.data() + end * width, values.data() + first * width);
        }
        kernels.assemble(mesh, active.data(), p.count, unit.data(), modulus_at.data(), nullptr, values.data());
        std::copy(reduced.data(), reduced.data() + reduced.size(), out.u.data());
        auto f = factor();
        kernels.eliminate(structure, Part::changing, values.data(), f, out.u.data());
        if (all_have_failed()) {
            return false;
        }
        kernels.backward(structure, Part::changing, f, out.u.data(), 1);
        if (whole) {
            kernels.backward(structure, Part::constant, f, out.u.data(), 1);
        }
        if (n > 0) {
            set_load_rates(out.u, out.du);
        }
        kernels.stress(mesh, p, modulus_at.data(), modulus_rate_at.data(), out.u.data(), out.stress.data(),
                       out.d_stress.data(), out.du.data());
        if (n > 0) {
            if (whole) {
                kernels.forward(structure, Part::constant, f, out.du.data(), n);
            }
            kernels.forward(structure, Part::changing, f, out.du.data(), n);
            kernels.backward(structure, Part::changing, f, out.du.data(), n);
            if (whole) {
                kernels.backward(structure, Part::constant, f, out.du.data(), n);
            }
            kernels.add_stress_rates(mesh, p, modulus_at.data(), out.du.data(), out.d_stress.data());
        }
        return true;
    }

    // right := d(load)/dp - (dK/dp) u of what is linear.
    void set_load_rates(const Buffer& u, Buffer& right) {
        const std::size_t n = count();
        std::fill(right.data(), right.data() + right.size(), 0.0);
        for (std::size_t k = 0; k < n; ++k) {
            const Variation& v = (*variations)[k];
            const auto l = static_cast<std::size_t>(v.layer);
            if (v.kind == Kind::load_factor) { // where constant rows are not followed, they are eliminated already
                const Buffer& from = whole ? load : reduced;
                for (std::size_t i = whole ? 0 : layout.first_row; i < rows(); ++i) {
                    std::copy_n(from.data() + i * width, width, right.data() + (i * n + k) * width);
                }
            } else if (v.kind == Kind::law_parameter && is_linear(l)) {
                stiffness_rate.resize(lanes::unit_numbers, kernels.lanes);
                for (std::size_t i = 0; i < lanes::unit_numbers * width; ++i) {
                    const std::size_t lane = i % width;
                    stiffness_rate[i] =
                        modulus_rate[(l * n + k) * width + lane] * unit[l * lanes::unit_numbers * width + i] +
                        modulus[l * width + lane] * unit_rate[(l * n + k) * lanes::unit_numbers * width + i];
                }
                kernels.subtract_force(mesh, of_layer[l].data(), static_cast<int>(of_layer[l].size()),
                                       stiffness_rate.data(), u.data(), right.data(), static_cast<int>(k),
                                       static_cast<int>(n));
            }
        }
    }

    // The rows that were not followed, at the end of the path.
    void complete(LanePath& end) {
        if (whole) {
            return;
        }
        const std::size_t n = count();
        auto f = factor();
        std::copy(reduced.data(), reduced.data() + layout.first_row * width, end.u.data());
        kernels.backward(structure, Part::constant, f, end.u.data(), 1);
        if (n == 0) {
            return;
        }
        for (std::size_t k = 0; k < n; ++k) {
            const bool is_load = (*variations)[k].kind == Kind::load_factor;
            for (std::size_t i = 0; i < layout.first_row; ++i) {
                for (std::size_t lane = 0; lane < width; ++lane) {
                    end.du[(i * n + k) * width + lane] = is_load ? reduced[i * width + lane] : 0.0;
                }
            }
        }
        kernels.backward(structure, Part::constant, f, end.du.data(), static_cast<int>(n));
    }

    // Shares of every lane, and the unbalanced force.
    void judge(const LanePath& end, std::vector<Statistics>& statistics) {
        Buffer sums;
        sums.assign_zero(4, kernels.lanes);
        lanes::Shares shares{sums.data(), sums.data() + width, sums.data() + 2 * width, sums.data() + 3 * width};
        const lanes::Points p = points_of_path();
        kernels.shares(mesh, p, compliance.data(), end.stress.data(), shares);
        Buffer unbalanced;
        unbalanced.resize(rows(), kernels.lanes);
        std::copy(load.data(), load.data() + load.size(), unbalanced.data());
        kernels.subtract_stress(mesh, p, end.stress.data(), unbalanced.data());
        Buffer d;
        d.resize(lanes::unit_numbers, kernels.lanes);
        for (std::size_t l = 0; l < layers(); ++l) {
            for (std::size_t i = 0; i < lanes::unit_numbers * width; ++i) {
                d[i] = modulus[l * width + i % width] * unit[l * lanes::unit_numbers * width + i];
            }
            kernels.subtract_force(mesh, of_layer[l].data(), static_cast<int>(of_layer[l].size()), d.data(),
                                   end.u.data(), unbalanced.data(), 0, 1);
        }
        for (std::size_t lane = 0; lane < statistics.size(); ++lane) {
            Statistics& s = statistics[lane];
            if (const double energy = sums[lane]; energy > 0.0) {
                s.tension_share = sums[width + lane] / energy;
                s.unstable_share = sums[2 * width + lane] / energy;
                s.limited_share = sums[3 * width + lane] / energy;
            }
            double square = 0.0;
            for (std::size_t i = 0; i < rows(); ++i) {
                square += unbalanced[i * width + lane] * unbalanced[i * width + lane];
            }
            s.residual_relative = std::sqrt(square) / runs[lane].load->norm();
        }
    }

    // A reading of one lane and its rates.
    void read(const Functional<Element>& f, const LanePath& end, std::size_t lane, double& value,
              Eigen::Ref<Eigen::RowVectorXd> rates) const {
        const std::size_t n = count();
        value = 0.0;
        rates.setZero();
        for (const auto& [unknown, weight] : f.on_displacement) {
            const std::size_t row = layout.inverse[static_cast<std::size_t>(unknown)];
            value += weight * end.u[row * width + lane];
            for (std::size_t k = 0; k < n; ++k) {
                rates[static_cast<Eigen::Index>(k)] += weight * end.du[(row * n + k) * width + lane];
            }
        }
        for (const auto& [point, weight, direction] : f.on_stress) {
            const auto e = static_cast<std::size_t>(point / Element::gauss);
            const auto g = static_cast<std::size_t>(point % Element::gauss);
            const auto l = static_cast<std::size_t>(layout.layer[e]);
            if (is_linear(l)) {
                read_linear(point, l, lane, weight * direction, end, value, rates);
                continue;
            }
            const std::size_t q = active_number[e] * Element::gauss + g;
            for (std::size_t i = 0; i < 4; ++i) {
                const double part = weight * direction[static_cast<Eigen::Index>(i)];
                value += part * end.stress[(4 * q + i) * width + lane];
                for (std::size_t k = 0; k < n; ++k) {
                    rates[static_cast<Eigen::Index>(k)] += part * end.d_stress[(4 * (q * n + k) + i) * width + lane];
                }
            }
        }
    }
    void read_linear(int point, std::size_t l, std::size_t lane, const mechanics::Voigt<4>& direction,
                     const LanePath& end, double& value, Eigen::Ref<Eigen::RowVectorXd> rates) const {
        const auto& own = layer(lane, l);
        const auto& at = model->points[static_cast<std::size_t>(point)];
        const std::size_t n = count();
        const auto displacement = [&](const Buffer& u, std::size_t column, std::size_t columns) {
            Element::Vector of_element;
            for (int i = 0; i < Element::dofs; ++i) {
                const int row = layout.unknowns[static_cast<std::size_t>(point / Element::gauss * Element::dofs + i)];
                of_element[i] = row >= 0 ? u[(static_cast<std::size_t>(row) * columns + column) * width + lane] : 0.0;
            }
            return of_element;
        };
        const double modulus_here = modulus[l * width + lane];
        const mechanics::Stiffness<4> c = own.unit_stiffness<4>();
        const Element::Stress strain = Element::strain(at, displacement(end.u, 0, 1));
        value += modulus_here * direction.dot(c * strain);
        for (std::size_t k = 0; k < n; ++k) {
            const Variation& v = (*variations)[k];
            double& rate = rates[static_cast<Eigen::Index>(k)];
            rate += modulus_here * direction.dot(c * Element::strain(at, displacement(end.du, k, n)));
            if (v.kind == Kind::law_parameter && v.layer == static_cast<int>(l)) {
                rate += direction.dot((modulus_rate[(l * n + k) * width + lane] * c +
                                       modulus_here * own.unit_stiffness_rate<4>(v.index)) *
                                      strain);
            }
        }
    }

    // So many runs as there are lanes, or fewer.
    void follow(std::span<const BatchRun> some, const std::vector<Variation>& by, const SolverSettings& settings,
                std::vector<Outcome<BatchReading>>& outcomes) {
        prepare(some, by);
        eliminate_constant();
        const std::size_t first = whole ? 0 : layout.first_row;
        path.set_zero(&kernels, first, rows(), points(), count());
        int rates = 0;
        const Deadline deadline(settings.time_limit);
        const auto failure = path.follow(
            settings.load_steps, false, deadline,
            [&](const LanePath& at, int number) {
                ++rates;
                return rate(at, path.slope[number]);
            },
            [](double) {});
        std::vector<Statistics> statistics(some.size());
        if (!failure) {
            complete(path.now);
            judge(path.now, statistics);
        }
        for (std::size_t lane = 0; lane < some.size(); ++lane) {
            if (definite[lane] == 0) {
                outcomes.emplace_back(stiffness_not_definite());
                continue;
            }
            if (failure) {
                outcomes.emplace_back(*failure);
                continue;
            }
            const auto& readings = *some[lane].readings;
            BatchReading result{
                Course(static_cast<Eigen::Index>(readings.size()), 1, static_cast<Eigen::Index>(count()), false),
                statistics[lane]};
            result.statistics.load_steps = settings.load_steps;
            result.statistics.factorizations = rates;
            for (std::size_t r = 0; r < readings.size(); ++r) {
                const auto row = static_cast<Eigen::Index>(r);
                Eigen::RowVectorXd rates_of_reading(static_cast<Eigen::Index>(count()));
                read(readings[r], path.now, lane, result.at_rest.values(row, 0), rates_of_reading);
                result.at_rest.d_values[0].row(row) = rates_of_reading;
            }
            outcomes.emplace_back(std::move(result));
        }
    }

    std::size_t memory() const {
        std::size_t bytes = Inputs::bytes();
        for (const Buffer* b : {&reduced, &linear, &values, &factor_values, &factor_inverse, &factor_stack,
                                &factor_other_stack, &factor_kept, &factor_rows, &stiffness_rate}) {
            bytes += b->bytes();
        }
        const auto add = [&](const LanePath& state) {
            bytes += state.u.bytes() + state.stress.bytes() + state.du.bytes() + state.d_stress.bytes();
        };
        add(path.now);
        add(path.trial);
        for (const LanePath& slope : path.slope) {
            add(slope);
        }
        return bytes;
    }
};

bool BatchSolver::serves(const Model<Element>& model, const std::vector<LayerMaterial>& layers,
                         const std::vector<Variation>& variations) {
    bool depends = false;
    for (std::size_t l = 0; l < layers.size(); ++l) {
        const LayerMaterial& layer = layers[l];
        const bool own = layer.law->stress_dependent();
        depends = depends || own;
        if (!layer.fields.empty() || layer.law->turns() || layer.law->relaxes() || layer.law->energy() != nullptr ||
            (own && model.topology->linear[l])) {
            return false;
        }
    }
    return depends && model.springs.empty() && variations.size() <= most_variations &&
           std::all_of(variations.begin(), variations.end(), [](const Variation& v) {
               return v.kind == Kind::law_parameter || v.kind == Kind::unit_weight || v.kind == Kind::k0 ||
                      v.kind == Kind::residual_stress || v.kind == Kind::load_factor;
           });
}

int BatchSolver::lanes() {
    return lanes::kernels(lanes::most_lanes).lanes;
}

bool BatchSolver::rounds_once() {
    return lanes::kernels(1).rounds_once;
}

BatchSolver::BatchSolver(const Model<Element>& model, const lanes::Kernels* kernels)
    : model_(&model),
      kernels_(kernels) {}
BatchSolver::~BatchSolver() = default;

void BatchSolver::move(const Model<Element>& model) {
    model_ = &model;
    for (const auto& work : works_) {
        work->move(model);
    }
}

// The memory for so many runs.
BatchSolver::Work& BatchSolver::work_for(std::size_t runs) {
    const Kernels& own = kernels_ != nullptr ? *kernels_ : lanes::kernels(static_cast<int>(runs));
    const auto known =
        std::find_if(works_.begin(), works_.end(), [&](const auto& work) { return &work->kernels == &own; });
    return known != works_.end() ? **known : *works_.emplace_back(std::make_unique<Work>(*model_, own));
}

std::vector<Outcome<BatchReading>> BatchSolver::incremental(std::span<const BatchRun> runs,
                                                            const std::vector<Variation>& variations,
                                                            const SolverSettings& settings) {
    std::vector<Outcome<BatchReading>> outcomes;
    outcomes.reserve(runs.size());
    while (!runs.empty()) {
        Work& work = work_for(std::min(runs.size(), most_lanes));
        const std::size_t some = std::min(work.width, runs.size());
        work.follow(runs.first(some), variations, settings, outcomes);
        runs = runs.subspan(some);
    }
    return outcomes;
}

std::size_t BatchSolver::memory() const {
    std::size_t bytes = 0;
    for (const auto& work : works_) {
        bytes += work->memory();
    }
    return bytes;
}

} // namespace pave::fe
