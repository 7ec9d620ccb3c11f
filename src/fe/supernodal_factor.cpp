#include "fe/supernodal_factor.h"

#include "fe/lanes/kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

namespace pave::fe {
namespace {

// Calls some(first, width) for groups of columns, as many at a time as the registers hold rows of.
template <class Scalar>
void in_groups(int columns, const auto& some) {
    constexpr int width = std::is_same_v<Scalar, float> ? 8 : 4;
    int j = 0;
    for (; j + width <= columns; j += width) {
        some(j, std::integral_constant<int, width>());
    }
    for (; j < columns; ++j) {
        some(j, std::integral_constant<int, 1>());
    }
}

// t := A x for the C columns of x, A (rows x columns) by columns.
template <int C, class Scalar>
void product(const Scalar* a, int rows, int columns, const Scalar* x, Scalar* t) {
    if constexpr (C == 1) {
        using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
        using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
        Eigen::Map<Vector>(t, rows).noalias() =
            Eigen::Map<const Matrix>(a, rows, columns) * Eigen::Map<const Vector>(x, columns);
        return;
    }
    using Row = Eigen::Array<Scalar, 1, C>;
    std::fill(t, t + static_cast<std::ptrdiff_t>(rows) * C, Scalar(0));
    const auto some = [&]<int width>(int j, std::integral_constant<int, width>) {
        const Scalar* first = a + static_cast<std::ptrdiff_t>(j) * rows;
        std::array<Row, width> of;
        for (int k = 0; k < width; ++k) {
            of[k] = Eigen::Map<const Row>(x + static_cast<std::ptrdiff_t>(j + k) * C);
        }
        for (int i = 0; i < rows; ++i) {
            Eigen::Map<Row> to(t + static_cast<std::ptrdiff_t>(i) * C);
            Row sum = to;
            for (int k = 0; k < width; ++k) {
                sum += first[static_cast<std::ptrdiff_t>(k) * rows + i] * of[k];
            }
            to = sum;
        }
    };
    in_groups<Scalar>(columns, some);
}

// t := A^T x for the C columns of x.
template <int C, class Scalar>
void transposed_product(const Scalar* a, int rows, int columns, const Scalar* x, Scalar* t) {
    if constexpr (C == 1) {
        using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
        using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
        Eigen::Map<Vector>(t, columns).noalias() =
            Eigen::Map<const Matrix>(a, rows, columns).transpose() * Eigen::Map<const Vector>(x, rows);
        return;
    }
    using Row = Eigen::Array<Scalar, 1, C>;
    const auto some = [&]<int width>(int j, std::integral_constant<int, width>) {
        const Scalar* first = a + static_cast<std::ptrdiff_t>(j) * rows;
        std::array<Row, width> sum;
        sum.fill(Row::Zero());
        for (int i = 0; i < rows; ++i) {
            const Row of = Eigen::Map<const Row>(x + static_cast<std::ptrdiff_t>(i) * C);
            for (int k = 0; k < width; ++k) {
                sum[k] += first[static_cast<std::ptrdiff_t>(k) * rows + i] * of;
            }
        }
        for (int k = 0; k < width; ++k) {
            Eigen::Map<Row>(t + static_cast<std::ptrdiff_t>(j + k) * C) = sum[k];
        }
    };
    in_groups<Scalar>(columns, some);
}

template <class Scalar>
constexpr bool is_double = std::is_same_v<Scalar, double>;

template <class Scalar>
void add(Scalar* to, const Scalar* what, int count) {
    for (int i = 0; i < count; ++i) {
        to[i] += what[i];
    }
}

std::size_t square(int n) {
    return static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
}

constexpr int panel_width = lanes::most_columns;

} // namespace

FactorStructure::FactorStructure(const Pattern& lower, std::vector<int> order, const std::vector<int>& first_columns,
                                 const std::vector<std::vector<int>>& rows_of, const std::vector<bool>& constant)
    : permutation(std::move(order)) {
    const std::size_t count = rows_of.size();
    std::vector<int> supernode_of(permutation.size());
    supernodes.resize(count + 1);
    for (std::size_t s = 0; s < count; ++s) {
        Supernode& node = supernodes[s];
        node.first_column = first_columns[s];
        node.columns = first_columns[s + 1] - first_columns[s];
        node.rows_below = static_cast<int>(rows_of[s].size()) - node.columns;
        node.row_start = rows.size();
        rows.insert(rows.end(), rows_of[s].begin(), rows_of[s].end());
        std::fill_n(supernode_of.begin() + node.first_column, node.columns, static_cast<int>(s));
        largest_front = std::max(largest_front,
                                 static_cast<std::size_t>(node.stride()) * static_cast<std::size_t>(node.front_rows()));
        node.first_panel = panels.size();
        node.is_constant = true;
        for (int k = node.first_column; k < node.first_column + node.columns; ++k) {
            node.is_constant = node.is_constant && constant[permutation[k]];
        }
        for (int first = 0; first < node.columns; first += panel_width) {
            Panel panel;
            panel.first_column = node.first_column + first;
            panel.columns = std::min(panel_width, node.columns - first);
            panel.rows_below = node.front_rows() - first - panel.columns;
            panel.row_start = node.row_start + static_cast<std::size_t>(first + panel.columns);
            panel.start = values;
            values +=
                static_cast<std::size_t>(panel.columns) * static_cast<std::size_t>(panel.columns + panel.rows_below);
            panels.push_back(panel);
        }
    }
    // Row of the whole matrix -> row of the front of supernode s.
    const auto local = [&](const Supernode& node, int row) {
        if (row < node.first_column + node.columns) {
            return row - node.first_column;
        }
        const auto first = rows.begin() + static_cast<std::ptrdiff_t>(node.row_start);
        return static_cast<int>(std::lower_bound(first + node.columns, first + node.front_rows(), row) - first);
    };
    place_in_parent.assign(rows.size(), -1);
    for (std::size_t s = count; s-- > 0;) {
        Supernode& node = supernodes[s];
        if (node.rows_below == 0) {
            continue;
        }
        const std::size_t below = node.row_start + static_cast<std::size_t>(node.columns);
        node.parent = supernode_of[static_cast<std::size_t>(rows[below])];
        Supernode& parent = supernodes[static_cast<std::size_t>(node.parent)];
        node.next_sibling = parent.first_child;
        parent.first_child = static_cast<int>(s);
        for (std::size_t k = below; k < below + static_cast<std::size_t>(node.rows_below); ++k) {
            place_in_parent[k] = local(parent, rows[k]);
        }
    }
    for (std::size_t s = 0; s <= count; ++s) {
        Supernode& node = supernodes[s];
        node.first_run = runs.size();
        const std::size_t below = node.row_start + static_cast<std::size_t>(node.columns);
        for (int i = 0; i < (node.parent < 0 ? 0 : node.rows_below); ++i) {
            const int place = place_in_parent[below + static_cast<std::size_t>(i)];
            if (i > 0 && place == runs.back().place + runs.back().rows) {
                ++runs.back().rows;
            } else {
                runs.push_back({i, 1, place});
            }
        }
    }
    // The entries of K by supernode.
    std::vector<int> inverse(permutation.size());
    for (std::size_t i = 0; i < permutation.size(); ++i) {
        inverse[static_cast<std::size_t>(permutation[i])] = static_cast<int>(i);
    }
    std::vector<int> owner(lower.row.size());
    std::vector<int> place(lower.row.size());
    std::vector<std::size_t> next(count + 1, 0);
    for (int j = 0; j < lower.size; ++j) {
        for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
            const auto [column, row] = std::minmax(inverse[j], inverse[lower.row[k]]);
            owner[k] = supernode_of[column];
            const Supernode& node = supernodes[owner[k]];
            place[k] = static_cast<int>((column - node.first_column) * node.stride()) + local(node, row);
            ++next[owner[k] + 1];
        }
    }
    for (std::size_t s = 0; s < count; ++s) {
        next[s + 1] += next[s];
        supernodes[s + 1].entry_start = next[s + 1];
    }
    entry_value.resize(owner.size());
    entry_place.resize(owner.size());
    for (std::size_t k = 0; k < owner.size(); ++k) {
        const std::size_t at = next[owner[k]]++;
        entry_value[at] = static_cast<int>(k);
        entry_place[at] = place[k];
    }
    supernodes[count].first_panel = panels.size();
    // A constant supernode has constant ones below it only; what it leaves for a parent that changes is kept.
    for (std::size_t s = 0; s < count; ++s) {
        Supernode& node = supernodes[s];
        for (int c = node.first_child; c >= 0; c = supernodes[c].next_sibling) {
            node.is_constant = node.is_constant && supernodes[c].is_constant;
        }
    }
    std::size_t stack[2] = {0, 0}; // of the fronts that change and of the constant ones
    for (std::size_t s = 0; s < count; ++s) {
        Supernode& node = supernodes[s];
        std::size_t& top = stack[node.is_constant ? 1 : 0];
        for (int c = node.first_child; c >= 0; c = supernodes[c].next_sibling) {
            if (supernodes[c].is_constant == node.is_constant) {
                top -= square(supernodes[c].rows_below);
            }
        }
        if (node.is_constant && node.parent >= 0 && !supernodes[node.parent].is_constant) {
            node.kept_start = kept;
            kept += square(node.rows_below);
        } else {
            top += square(node.rows_below);
        }
        largest_stack = std::max(largest_stack, top);
    }
}

double FactorStructure::changing_operations() const {
    double sum = 0.0;
    for (const Supernode& node : supernodes) {
        for (int k = 0; !node.is_constant && k < node.columns; ++k) {
            const double left = node.front_rows() - k - 1;
            sum += left * (left + 2.0);
        }
    }
    return sum;
}

template <class Scalar>
SupernodalFactor<Scalar>::SupernodalFactor(const Pattern& lower, const FactorStructure& structure,
                                           const lanes::Kernels* kernels)
    : lower_(lower),
      structure_(structure),
      kernels_(kernels != nullptr ? *kernels : lanes::kernels(lanes::most_lanes)) {}

template <class Scalar>
bool SupernodalFactor<Scalar>::factorize(std::span<const double> values, bool first) {
    values_.resize(structure_.values + lanes::right_sides); // a vector at the end may read more
    front_.resize(structure_.largest_front);
    stack_.resize(structure_.largest_stack);
    kept_.resize(structure_.kept);
    for (int j = 0; j < lower_.size; ++j) {
        const double diagonal = values[lower_.column_start[j]];
        if (!(diagonal > 0.0) || !std::isfinite(diagonal)) {
            return false;
        }
    }
    return (!first || eliminate(values, true)) && eliminate(values, false);
}

// Eliminates the supernodes that are constant, or those that are not.
template <class Scalar>
bool SupernodalFactor<Scalar>::eliminate(std::span<const double> values, bool constant) {
    Scalar* top = stack_.data();
    for (std::size_t s = 0; s + 1 < structure_.supernodes.size(); ++s) {
        const auto& node = structure_.supernodes[s];
        if (node.is_constant != constant) {
            continue;
        }
        const std::ptrdiff_t size = node.front_rows();
        const std::ptrdiff_t stride = node.stride();
        Scalar* front = front_.data();
        for (std::ptrdiff_t j = 0; j < size; ++j) { // from where the vector with the diagonal begins
            std::fill(front + j * stride + j / lanes::most_lanes * lanes::most_lanes, front + (j + 1) * stride,
                      Scalar(0));
        }
        for (std::size_t k = node.entry_start; k < structure_.supernodes[s + 1].entry_start; ++k) {
            front[structure_.entry_place[k]] = static_cast<Scalar>(values[structure_.entry_value[k]]);
        }
        // Of the children those of the same kind lie on the stack, the last one on top.
        for (int c = node.first_child; c >= 0; c = structure_.supernodes[c].next_sibling) {
            top -= structure_.supernodes[c].is_constant == constant ? square(structure_.supernodes[c].rows_below) : 0;
        }
        const Scalar* waiting = top;
        for (int c = node.first_child; c >= 0; c = structure_.supernodes[c].next_sibling) {
            const auto& child = structure_.supernodes[c];
            const bool is_kept = child.is_constant != constant;
            const Scalar* from = is_kept ? kept_.data() + child.kept_start : waiting;
            waiting += is_kept ? 0 : square(child.rows_below);
            const FactorStructure::Run* end = structure_.runs.data() + structure_.supernodes[c + 1].first_run;
            for (const auto* own = structure_.runs.data() + child.first_run; own != end; ++own) {
                for (int j = own->first; j < own->first + own->rows; ++j, from += child.rows_below) {
                    const int column = own->place + j - own->first;
                    Scalar* to = front + column * stride;
                    add(to + column, from + j, own->first + own->rows - j);
                    for (const auto* below = own + 1; below != end; ++below) {
                        add(to + below->place, from + below->first, below->rows);
                    }
                }
            }
        }
        if (!eliminate_front(node)) {
            return false;
        }
        const bool keep = constant && node.parent >= 0 && !structure_.supernodes[node.parent].is_constant;
        Scalar* to = keep ? kept_.data() + node.kept_start : top;
        top += keep ? 0 : square(node.rows_below);
        for (std::ptrdiff_t j = node.columns; j < size; ++j, to += node.rows_below) {
            std::copy(front + j * stride + j, front + j * stride + size, to + (j - node.columns));
        }
        store_panels(node);
    }
    return true;
}

// The columns of the supernode become those of the factor, the rest of the front what is left for the parent.
template <class Scalar>
bool SupernodalFactor<Scalar>::eliminate_front(const FactorStructure::Supernode& node) {
    const int size = node.front_rows();
    if constexpr (is_double<Scalar>) {
        return kernels_.eliminate_dense(front_.data(), size, node.columns, node.stride());
    } else {
        Eigen::Map<Matrix, 0, Eigen::OuterStride<>> front(front_.data(), size, size,
                                                          Eigen::OuterStride<>(node.stride()));
        auto diagonal = front.topLeftCorner(node.columns, node.columns);
        const Eigen::LLT<Eigen::Ref<Matrix>> llt(diagonal);
        if (llt.info() != Eigen::Success) {
            return false;
        }
        auto below = front.bottomLeftCorner(node.rows_below, node.columns);
        diagonal.template triangularView<Eigen::Lower>().transpose().template solveInPlace<Eigen::OnTheRight>(below);
        front.bottomRightCorner(node.rows_below, node.rows_below)
            .template selfadjointView<Eigen::Lower>()
            .rankUpdate(below, Scalar(-1));
        return true;
    }
}

template <class Scalar>
void SupernodalFactor<Scalar>::store_panels(const FactorStructure::Supernode& node) {
    const int size = node.front_rows();
    const Eigen::Map<const Matrix, 0, Eigen::OuterStride<>> front(front_.data(), size, size,
                                                                  Eigen::OuterStride<>(node.stride()));
    std::size_t number = node.first_panel;
    for (int first = 0; first < node.columns; first += panel_width, ++number) {
        const auto& panel = structure_.panels[number];
        Scalar* to = values_.data() + panel.start;
        Eigen::Map<Matrix> inverse(to, panel.columns, panel.columns);
        if constexpr (is_double<Scalar>) {
            kernels_.invert_dense(front_.data() + first * (node.stride() + 1), panel.columns, node.stride(), to);
        } else {
            inverse.setIdentity();
            front.block(first, first, panel.columns, panel.columns)
                .template triangularView<Eigen::Lower>()
                .solveInPlace(inverse);
        }
        Eigen::Map<Matrix>(to + inverse.size(), panel.rows_below, panel.columns) =
            front.block(first + panel.columns, first, panel.rows_below, panel.columns);
    }
}

template <class Scalar>
template <int C>
void SupernodalFactor<Scalar>::solve(Block<C>& z) {
    const auto& permutation = structure_.permutation;
    const auto n = static_cast<std::ptrdiff_t>(permutation.size());
    x_.resize(static_cast<std::size_t>(n) * C);
    t_.resize(static_cast<std::size_t>(n) * C + lanes::right_sides);
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        for (int c = 0; c < C; ++c) {
            x_[i * C + c] = static_cast<Scalar>(z(permutation[i], c));
        }
    }
    if constexpr (is_double<Scalar> && C == lanes::right_sides) {
        in_panels(kernels_.forward_dense, kernels_.backward_dense);
    } else if constexpr (is_double<Scalar> && C == 1) {
        in_panels(kernels_.forward_one, kernels_.backward_one, t_.data());
    } else {
        substitute<C>();
    }
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        for (int c = 0; c < C; ++c) {
            z(permutation[i], c) = x_[i * C + c];
        }
    }
}

// x_ := (L L^T)^-1 x_ by functions that take a panel forth and back.
template <class Scalar>
void SupernodalFactor<Scalar>::in_panels(const auto& forth, const auto& back, auto... scratch) {
    for (const auto& s : structure_.panels) {
        forth(values_.data() + s.start, s.columns, s.rows_below, structure_.rows.data() + s.row_start, s.first_column,
              x_.data(), scratch...);
    }
    for (auto s = structure_.panels.rbegin(); s != structure_.panels.rend(); ++s) {
        back(values_.data() + s->start, s->columns, s->rows_below, structure_.rows.data() + s->row_start,
             s->first_column, x_.data(), scratch...);
    }
}

// The same by products.
template <class Scalar>
template <int C>
void SupernodalFactor<Scalar>::substitute() {
    Scalar* t = t_.data();
    for (const auto& s : structure_.panels) {
        Scalar* x = x_.data() + static_cast<std::ptrdiff_t>(s.first_column) * C;
        const Scalar* diagonal = values_.data() + s.start;
        const Scalar* below = diagonal + static_cast<std::ptrdiff_t>(s.columns) * s.columns;
        product<C>(diagonal, s.columns, s.columns, x, t);
        std::copy(t, t + static_cast<std::ptrdiff_t>(s.columns) * C, x);
        if (s.rows_below == 0) {
            continue;
        }
        product<C>(below, s.rows_below, s.columns, x, t);
        const int* row = structure_.rows.data() + s.row_start;
        for (int i = 0; i < s.rows_below; ++i) {
            Scalar* to = x_.data() + static_cast<std::ptrdiff_t>(row[i]) * C;
            for (int c = 0; c < C; ++c) {
                to[c] -= t[i * C + c];
            }
        }
    }
    Numbers& sum = sum_;
    for (auto it = structure_.panels.rbegin(); it != structure_.panels.rend(); ++it) {
        const auto& s = *it;
        Scalar* x = x_.data() + static_cast<std::ptrdiff_t>(s.first_column) * C;
        const Scalar* diagonal = values_.data() + s.start;
        const Scalar* below = diagonal + static_cast<std::ptrdiff_t>(s.columns) * s.columns;
        sum.resize(static_cast<std::size_t>(s.columns) * C);
        if (s.rows_below > 0) {
            const int* row = structure_.rows.data() + s.row_start;
            for (int i = 0; i < s.rows_below; ++i) {
                const Scalar* from = x_.data() + static_cast<std::ptrdiff_t>(row[i]) * C;
                for (int c = 0; c < C; ++c) {
                    t[i * C + c] = from[c];
                }
            }
            transposed_product<C>(below, s.rows_below, s.columns, t, sum.data());
            for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(s.columns) * C; ++k) {
                x[k] -= sum[k];
            }
        }
        transposed_product<C>(diagonal, s.columns, s.columns, x, sum.data());
        std::copy(sum.begin(), sum.end(), x);
    }
}

template class SupernodalFactor<float>;
template void SupernodalFactor<float>::solve<1>(Block<1>&);
template void SupernodalFactor<float>::solve<4>(Block<4>&);
template void SupernodalFactor<float>::solve<8>(Block<8>&);
template class SupernodalFactor<double>;
template void SupernodalFactor<double>::solve<1>(Block<1>&);
template void SupernodalFactor<double>::solve<4>(Block<4>&);
template void SupernodalFactor<double>::solve<8>(Block<8>&);

} // namespace pave::fe
