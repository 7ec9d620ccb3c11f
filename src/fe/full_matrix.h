// The unsymmetric matrix of a tangent, in full, and its LU factors. Private to fe/.
#pragma once

#include "fe/model.h"
#include "fe/sparse_solver.h"

#include <algorithm>
#include <array>
#include <vector>

namespace pave::fe {

template <class Element>
class FullMatrix {
public:
    using OfElement = Eigen::Matrix<double, Element::dofs, Element::dofs>;

    explicit FullMatrix(const Topology<Element>& topology)
        : lower_(topology.lower),
          pattern_(whole(topology.lower)),
          lu_(pattern_),
          values_(pattern_.row.size()) {
        scatter_.resize(topology.unknowns.size());
        for (std::size_t e = 0; e < scatter_.size(); ++e) {
            for (int b = 0; b < Element::dofs; ++b) {
                for (int a = 0; a < Element::dofs; ++a) {
                    scatter_[e][static_cast<std::size_t>(b * Element::dofs + a)] =
                        place_of(topology.unknowns[e][a], topology.unknowns[e][b]);
                }
            }
        }
    }

    // Values := those of a symmetric matrix on the pattern of its lower triangle.
    void set(const std::vector<double>& lower_values) {
        std::vector<int> next(pattern_.column_start.begin(), pattern_.column_start.end() - 1);
        // Rows of a column of the full matrix: first those above the diagonal, in the order in which the columns of
        // the lower triangle that hold them are met, then the column of the lower triangle itself.
        for (int j = 0; j < lower_.size; ++j) {
            for (int k = lower_.column_start[j]; k < lower_.column_start[j + 1]; ++k) {
                values_[next[j]++] = lower_values[k];
                if (lower_.row[k] != j) {
                    values_[next[lower_.row[k]]++] = lower_values[k];
                }
            }
        }
    }
    void add(int element, const OfElement& k) {
        for (int entry = 0; entry < Element::dofs * Element::dofs; ++entry) {
            if (const int place = scatter_[static_cast<std::size_t>(element)][static_cast<std::size_t>(entry)];
                place >= 0) {
                values_[static_cast<std::size_t>(place)] += k.data()[entry];
            }
        }
    }
    // False: it is singular.
    bool factorize() { return lu_.factorize(values_); }
    // x := K^-1 x
    void solve(double* x, int columns) { lu_.solve(x, columns); }

private:
    static Pattern whole(const Pattern& lower) {
        std::vector<std::vector<int>> columns(lower.size);
        for (int j = 0; j < lower.size; ++j) {
            for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
                columns[j].push_back(lower.row[k]);
                if (lower.row[k] != j) {
                    columns[lower.row[k]].push_back(j);
                }
            }
        }
        Pattern full;
        full.size = lower.size;
        full.column_start.assign(1, 0);
        for (auto& rows : columns) {
            std::sort(rows.begin(), rows.end());
            full.row.insert(full.row.end(), rows.begin(), rows.end());
            full.column_start.push_back(static_cast<int>(full.row.size()));
        }
        return full;
    }
    // -1: an unknown that is held.
    int place_of(int i, int j) const {
        if (i < 0 || j < 0) {
            return -1;
        }
        const auto first = pattern_.row.begin() + pattern_.column_start[j];
        const auto last = pattern_.row.begin() + pattern_.column_start[j + 1];
        return static_cast<int>(std::lower_bound(first, last, i) - pattern_.row.begin());
    }

    const Pattern& lower_; // of the topology, which must outlive this
    Pattern pattern_;
    SparseLu lu_;
    std::vector<std::array<int, Element::dofs * Element::dofs>> scatter_; // local (i, j) column by column
    std::vector<double> values_;
};

} // namespace pave::fe
