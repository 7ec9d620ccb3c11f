// Dense blocks of one matrix, by columns; neighbouring rows, or neighbouring right-hand sides, are in the lanes.
// Private to fe/lanes/.
#pragma once

#include "fe/lanes/factor.h"

namespace pave::fe::lanes::PAVE_LANES {

PAVE_INLINE double minus(double a, double b, double c) {
    return is_fused ? __builtin_fma(-a, b, c) : c - a * b;
}

// Vectors of rows, and columns, at a time: as many as there are registers for.
constexpr int block_vectors = 2;
constexpr int block_columns = many_registers ? 8 : 4;
// Columns that are eliminated together.
constexpr int panel_columns = 8;

// c -= A B^T, V vectors of rows and C columns. Columns of a, b and c are `stride` apart.
template <int V, int C>
PAVE_INLINE void subtract_block(const double* a, const double* b, std::ptrdiff_t stride, int count, double* c) {
    Lanes t[C][V];
#pragma GCC unroll 8
    for (int j = 0; j < C; ++j) {
#pragma GCC unroll 2
        for (int v = 0; v < V; ++v) {
            t[j][v] = of(c + j * stride)[v];
        }
    }
    for (int k = 0; k < count; ++k, a += stride, b += stride) {
        Lanes x[V];
#pragma GCC unroll 2
        for (int v = 0; v < V; ++v) {
            x[v] = of(a)[v];
        }
#pragma GCC unroll 8
        for (int j = 0; j < C; ++j) {
            const Lanes bj = all(b[j]);
#pragma GCC unroll 2
            for (int v = 0; v < V; ++v) {
                t[j][v] = minus(x[v], bj, t[j][v]);
            }
        }
    }
#pragma GCC unroll 8
    for (int j = 0; j < C; ++j) {
#pragma GCC unroll 2
        for (int v = 0; v < V; ++v) {
            of(c + j * stride)[v] = t[j][v];
        }
    }
}

// C columns of a front from `column` on, on and below the diagonal, less what its first `count` columns take away.
template <int C>
PAVE_INLINE void subtract_from_columns(double* front, int rows, std::ptrdiff_t stride, int column, int count) {
    double* own = front + column * stride;
    int row = column / width * width;
    for (; row + (block_vectors - 1) * width < rows; row += block_vectors * width) {
        subtract_block<block_vectors, C>(front + row, front + column, stride, count, own + row);
    }
    if (row < rows) {
        subtract_block<1, C>(front + row, front + column, stride, count, own + row);
    }
}
inline void subtract_from(double* front, int rows, std::ptrdiff_t stride, int first, int end, int count) {
    int column = first;
    for (; column + block_columns <= end; column += block_columns) {
        subtract_from_columns<block_columns>(front, rows, stride, column, count);
    }
    for (; column < end; ++column) {
        subtract_from_columns<1>(front, rows, stride, column, count);
    }
}

// The Cholesky factor of a few columns' block on the diagonal, in place. False: it is not positive definite.
inline bool factorize_diagonal(double* t, std::ptrdiff_t stride, int columns, double* inverse) {
    for (int c = 0; c < columns; ++c) {
        double* own = t + c * stride;
        if (!(own[c] > 0.0 && own[c] <= __DBL_MAX__)) {
            return false;
        }
        own[c] = __builtin_sqrt(own[c]);
        inverse[c] = 1.0 / own[c];
        for (int r = c + 1; r < columns; ++r) {
            own[r] *= inverse[c];
        }
        for (int k = c + 1; k < columns; ++k) {
            for (int r = k; r < columns; ++r) {
                t[k * stride + r] = minus(own[r], own[k], t[k * stride + r]);
            }
        }
    }
    return true;
}

// x := x L^-T, a row or a vector of rows and C columns, with the factor on the diagonal.
template <int C, class Number>
PAVE_INLINE void solve_rows(Number* x, std::ptrdiff_t stride, const double* diagonal, std::ptrdiff_t columns_apart,
                            const double* inverse) {
    Number solved[C];
#pragma GCC unroll 8
    for (int c = 0; c < C; ++c) {
        Number sum = x[c * stride];
#pragma GCC unroll 8
        for (int k = 0; k < c; ++k) {
            const double factor = diagonal[k * columns_apart + c];
            if constexpr (sizeof(Number) == sizeof(double)) {
                sum = minus(solved[k], factor, sum);
            } else {
                sum = minus(solved[k], all(factor), sum);
            }
        }
        solved[c] = sum * inverse[c];
        x[c * stride] = solved[c];
    }
}
template <int C>
inline void solve_below(double* front, int rows, std::ptrdiff_t stride, int column, const double* inverse) {
    double* own = front + column * stride;
    const double* diagonal = own + column;
    int row = column + C;
    for (; row < rows && row % width != 0; ++row) {
        solve_rows<C>(own + row, stride, diagonal, stride, inverse);
    }
    for (; row < rows; row += width) {
        solve_rows<C>(of(own + row), stride / width, diagonal, stride, inverse);
    }
}

inline bool eliminate_dense(double* front, int rows, int columns, std::ptrdiff_t stride) {
    for (int column = 0; column < columns; column += panel_columns) {
        const int some = columns - column < panel_columns ? columns - column : panel_columns;
        subtract_from(front, rows, stride, column, column + some, column);
        double inverse[panel_columns];
        if (!factorize_diagonal(front + column * stride + column, stride, some, inverse)) {
            return false;
        }
        switch (some) {
        case 1: solve_below<1>(front, rows, stride, column, inverse); break;
        case 2: solve_below<2>(front, rows, stride, column, inverse); break;
        case 3: solve_below<3>(front, rows, stride, column, inverse); break;
        case 4: solve_below<4>(front, rows, stride, column, inverse); break;
        case 5: solve_below<5>(front, rows, stride, column, inverse); break;
        case 6: solve_below<6>(front, rows, stride, column, inverse); break;
        case 7: solve_below<7>(front, rows, stride, column, inverse); break;
        default: solve_below<panel_columns>(front, rows, stride, column, inverse); break;
        }
    }
    subtract_from(front, rows, stride, columns, rows, columns);
    return true;
}

// Row by row: those of a block of rows take away the finished ones, then they finish each other.
inline void invert_dense(const double* lower, int columns, std::ptrdiff_t stride, double* inverse) {
    constexpr int block = 8;
    constexpr int vectors = most_columns / width;
    alignas(alignment) double rows[most_columns][most_columns]; // of the inverse
    for (int first = 0; first < columns; first += block) {
        const int some = columns - first < block ? columns - first : block;
        const int filled = (first + block) / width;
        for (int v = 0; v < filled; ++v) {
            Lanes sum[block] = {};
            for (int k = v * width; k < first; ++k) {
                const Lanes finished = of(rows[k])[v];
#pragma GCC unroll 8
                for (int r = 0; r < block; ++r) {
                    const double factor = r < some ? lower[k * stride + first + r] : 0.0;
                    sum[r] = minus(finished, all(factor), sum[r]);
                }
            }
            for (int r = 0; r < some; ++r) {
                of(rows[first + r])[v] = sum[r];
            }
        }
        for (int r = 0; r < some; ++r) {
            rows[first + r][first + r] += 1.0;
        }
        for (int k = 0; k < some; ++k) {
            const double* column = lower + (first + k) * stride + first;
            const double factor = 1.0 / column[k];
            for (int v = 0; v < filled; ++v) {
                Lanes& own = of(rows[first + k])[v];
                own = own * factor;
                for (int r = k + 1; r < some; ++r) {
                    of(rows[first + r])[v] = minus(own, all(column[r]), of(rows[first + r])[v]);
                }
            }
        }
        for (int r = first; r < first + some; ++r) {
            for (int k = 0; k <= r; ++k) {
                inverse[k * columns + r] = rows[r][k];
            }
        }
    }
    static_assert(vectors * width == most_columns);
}

// The vectors of one row of right-hand sides.
constexpr int side_vectors = right_sides / width;
constexpr int block_rows = side_vectors == 1 ? 8 : side_vectors == 2 ? 4 : 2;

// f(row, vector, sum) of R rows of the product with the rows of x; columns of a are `stride` apart.
template <int R, class Store>
PAVE_INLINE void rows_of_product(const double* a, std::ptrdiff_t stride, int count, const double* x,
                                 const Store& store) {
    Lanes sum[R][side_vectors] = {};
    for (int k = 0; k < count; ++k, a += stride, x += right_sides) {
#pragma GCC unroll 8
        for (int r = 0; r < R; ++r) {
            const Lanes factor = all(a[r]);
#pragma GCC unroll 4
            for (int v = 0; v < side_vectors; ++v) {
                sum[r][v] = fma(factor, of(x)[v], sum[r][v]);
            }
        }
    }
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r) {
#pragma GCC unroll 4
        for (int v = 0; v < side_vectors; ++v) {
            store(r, v, sum[r][v]);
        }
    }
}
// The same with the transpose; from(i): row i of what is multiplied.
template <int R, class From, class Store>
PAVE_INLINE void rows_of_transposed(const double* a, std::ptrdiff_t stride, int count, const From& from,
                                    const Store& store) {
    Lanes sum[R][side_vectors] = {};
    for (int i = 0; i < count; ++i) {
        const Lanes* x = from(i);
#pragma GCC unroll 8
        for (int r = 0; r < R; ++r) {
            const Lanes factor = all(a[r * stride + i]);
#pragma GCC unroll 4
            for (int v = 0; v < side_vectors; ++v) {
                sum[r][v] = fma(factor, x[v], sum[r][v]);
            }
        }
    }
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r) {
#pragma GCC unroll 4
        for (int v = 0; v < side_vectors; ++v) {
            store(r, v, sum[r][v]);
        }
    }
}

// f(number of the first, how many) for rows in blocks.
template <int N>
struct Count {
    static constexpr int value = N;
};
template <class F>
PAVE_INLINE void in_blocks(int count, const F& f) {
    int first = 0;
    for (; first + block_rows <= count; first += block_rows) {
        f(first, Count<block_rows>());
    }
    for (; first < count; ++first) {
        f(first, Count<1>());
    }
}

inline void forward_dense(const double* panel, int columns, int rows_below, const int* rows, int first, double* x) {
    alignas(alignment) double solved[most_columns * right_sides];
    double* own = x + static_cast<std::ptrdiff_t>(first) * right_sides;
    in_blocks(columns, [&](int row, auto some) {
        rows_of_product<decltype(some)::value>(
            panel + row, columns, row + decltype(some)::value, own,
            [&](int r, int v, Lanes sum) { of(solved + (row + r) * right_sides)[v] = sum; });
    });
    __builtin_memcpy(own, solved, sizeof(double) * (static_cast<std::size_t>(columns) * right_sides));
    const double* below = panel + static_cast<std::ptrdiff_t>(columns) * columns;
    in_blocks(rows_below, [&](int row, auto some) {
        rows_of_product<decltype(some)::value>(below + row, rows_below, columns, own, [&](int r, int v, Lanes sum) {
            Lanes& to = of(x + static_cast<std::ptrdiff_t>(rows[row + r]) * right_sides)[v];
            to = to - sum;
        });
    });
}

inline void backward_dense(const double* panel, int columns, int rows_below, const int* rows, int first, double* x) {
    alignas(alignment) double solved[most_columns * right_sides];
    double* own = x + static_cast<std::ptrdiff_t>(first) * right_sides;
    const double* below = panel + static_cast<std::ptrdiff_t>(columns) * columns;
    in_blocks(rows_below > 0 ? columns : 0, [&](int column, auto some) {
        rows_of_transposed<decltype(some)::value>(
            below + static_cast<std::ptrdiff_t>(column) * rows_below, rows_below, rows_below,
            [&](int i) { return of(x + static_cast<std::ptrdiff_t>(rows[i]) * right_sides); },
            [&](int r, int v, Lanes sum) {
                Lanes& to = of(own + (column + r) * right_sides)[v];
                to = to - sum;
            });
    });
    in_blocks(columns, [&](int column, auto some) { // the inverse has nothing above the diagonal
        rows_of_transposed<decltype(some)::value>(
            panel + static_cast<std::ptrdiff_t>(column) * columns + column, columns, columns - column,
            [&](int i) { return of(own + (column + i) * right_sides); },
            [&](int r, int v, Lanes sum) { of(solved + (column + r) * right_sides)[v] = sum; });
    });
    __builtin_memcpy(own, solved, sizeof(double) * (static_cast<std::size_t>(columns) * right_sides));
}

// Where a vector need not begin at a place of its own.
using Loose = double __attribute__((vector_size(8 * width), aligned(8), may_alias));
PAVE_INLINE Lanes loose(const double* x) {
    return *reinterpret_cast<const Loose*>(x);
}

// to := A x, eight rows at a time: those behind the last one are of no account. count(row): so many columns for the
// rows from there on.
template <class F>
PAVE_INLINE void rows_of_one(const double* a, int rows, std::ptrdiff_t stride, const F& count, const double* x,
                             double* to) {
    for (int row = 0; row < rows; row += right_sides) {
        Lanes sum[side_vectors] = {};
        const int columns = count(row);
        const double* at = a + row;
        for (int k = 0; k < columns; ++k, at += stride) {
            const Lanes factor = all(x[k]);
#pragma GCC unroll 4
            for (int v = 0; v < side_vectors; ++v) {
                sum[v] = fma(factor, loose(at + v * width), sum[v]);
            }
        }
#pragma GCC unroll 4
        for (int v = 0; v < side_vectors; ++v) {
            of(to + row)[v] = sum[v];
        }
    }
}
// a . x, in the same order in every width; x is zero behind its end.
PAVE_INLINE double dot(const double* a, const double* x, int count) {
    Lanes sum[side_vectors] = {};
    for (int i = 0; i < count; i += right_sides) {
#pragma GCC unroll 4
        for (int v = 0; v < side_vectors; ++v) {
            sum[v] = fma(loose(a + i + v * width), loose(x + i + v * width), sum[v]);
        }
    }
    alignas(alignment) double each[right_sides];
#pragma GCC unroll 4
    for (int v = 0; v < side_vectors; ++v) {
        of(each)[v] = sum[v];
    }
    return ((each[0] + each[4]) + (each[2] + each[6])) + ((each[1] + each[5]) + (each[3] + each[7]));
}

inline void forward_one(const double* panel, int columns, int rows_below, const int* rows, int first, double* x,
                        double* scratch) {
    alignas(alignment) double solved[most_columns];
    double* own = x + first;
    rows_of_one(
        panel, columns, columns, [&](int row) { return columns - row < right_sides ? columns : row + right_sides; },
        own, solved);
    __builtin_memcpy(own, solved, sizeof(double) * static_cast<std::size_t>(columns));
    rows_of_one(
        panel + static_cast<std::ptrdiff_t>(columns) * columns, rows_below, rows_below, [&](int) { return columns; },
        own, scratch);
    for (int i = 0; i < rows_below; ++i) {
        x[rows[i]] -= scratch[i];
    }
}

inline void backward_one(const double* panel, int columns, int rows_below, const int* rows, int first, double* x,
                         double* scratch) {
    alignas(alignment) double finished[most_columns + right_sides];
    double* own = x + first;
    const double* below = panel + static_cast<std::ptrdiff_t>(columns) * columns;
    for (int i = 0; i < rows_below; ++i) {
        scratch[i] = x[rows[i]];
    }
    for (int i = rows_below; i < rows_below + right_sides; ++i) {
        scratch[i] = 0.0;
    }
    for (int k = 0; k < columns; ++k) {
        finished[k] = own[k] - dot(below + static_cast<std::ptrdiff_t>(k) * rows_below, scratch, rows_below);
    }
    for (int k = columns; k < columns + right_sides; ++k) {
        finished[k] = 0.0;
    }
    for (int k = 0; k < columns; ++k) { // the inverse has nothing above the diagonal
        own[k] = dot(panel + static_cast<std::ptrdiff_t>(k) * columns + k, finished + k, columns - k);
    }
}

} // namespace pave::fe::lanes::PAVE_LANES
