// Multifrontal elimination (Duff and Reid 1983) of many matrices of one pattern, one a lane. Private to fe/lanes/.
#pragma once

#include "fe/lanes/kernels.h"
#include "fe/lanes/vector.h"

namespace pave::fe::lanes::PAVE_LANES {

PAVE_INLINE Lanes* of(double* x) {
    return reinterpret_cast<Lanes*>(x);
}
PAVE_INLINE const Lanes* of(const double* x) {
    return reinterpret_cast<const Lanes*>(x);
}

constexpr std::ptrdiff_t tile_area = tile * tile;

PAVE_INLINE std::ptrdiff_t tiles_before(std::ptrdiff_t strip) {
    return strip * (strip + 1) / 2 * tile_area;
}

// C columns of a tile: t(r, c) -= sum over k of a(r, k) b(c, k).
template <int C>
PAVE_INLINE void subtract_products(Lanes (&t)[C][tile], const Lanes* a, const Lanes* b, int columns) {
    for (int k = 0; k < columns; ++k, a += tile, b += tile) {
        const Lanes a0 = a[0];
        const Lanes a1 = a[1];
        const Lanes a2 = a[2];
        const Lanes a3 = a[3];
#pragma GCC unroll 4
        for (int c = 0; c < C; ++c) {
            const Lanes bc = b[c];
            t[c][0] = minus(a0, bc, t[c][0]);
            t[c][1] = minus(a1, bc, t[c][1]);
            t[c][2] = minus(a2, bc, t[c][2]);
            t[c][3] = minus(a3, bc, t[c][3]);
        }
    }
}

// to := from - A B^T, a tile of each by columns. from: none is zero, as of what a front leaves.
template <int C>
PAVE_INLINE void subtract_some(const Lanes* from, const Lanes* a, const Lanes* b, int columns, Lanes* to) {
    Lanes t[C][tile];
#pragma GCC unroll 4
    for (int c = 0; c < C; ++c) {
#pragma GCC unroll 4
        for (int r = 0; r < tile; ++r) {
            t[c][r] = from != nullptr ? from[c * tile + r] : Lanes{};
        }
    }
    subtract_products<C>(t, a, b, columns);
#pragma GCC unroll 4
    for (int c = 0; c < C; ++c) {
#pragma GCC unroll 4
        for (int r = 0; r < tile; ++r) {
            to[c * tile + r] = t[c][r];
        }
    }
}
PAVE_INLINE void subtract_tile(const Lanes* from, const Lanes* a, const Lanes* b, int columns, Lanes* to) {
    if constexpr (many_registers) {
        subtract_some<tile>(from, a, b, columns, to);
    } else { // in two halves
        constexpr int half = tile / 2;
        subtract_some<half>(from, a, b, columns, to);
        subtract_some<half>(from != nullptr ? from + half * tile : nullptr, a, b + half, columns, to + half * tile);
    }
}

// The Cholesky factor of the tile on the diagonal, in place; its first `columns` columns are there.
inline void factorize_tile(Lanes* t, int columns, Lanes* inverse, Mask& definite) {
    for (int c = 0; c < columns; ++c) {
        const Lanes d = t[c * tile + c];
        definite &= (d > 0.0) & (d <= __DBL_MAX__);
        const Lanes s = root(d);
        const Lanes i = 1.0 / s;
        inverse[c] = i;
        t[c * tile + c] = s;
        for (int r = c + 1; r < tile; ++r) {
            t[c * tile + r] *= i;
        }
        for (int k = c + 1; k < columns; ++k) {
            for (int r = k; r < tile; ++r) {
                t[k * tile + r] = minus(t[c * tile + r], t[c * tile + k], t[k * tile + r]);
            }
        }
    }
}

// t := t L^-T with the factor of the tile on the diagonal.
template <int C>
PAVE_INLINE void solve_tile(Lanes* t, const Lanes* diagonal, const Lanes* inverse) {
#pragma GCC unroll 4
    for (int r = 0; r < tile; ++r) {
        Lanes x[C];
#pragma GCC unroll 4
        for (int c = 0; c < C; ++c) {
            Lanes sum = t[c * tile + r];
#pragma GCC unroll 4
            for (int k = 0; k < c; ++k) {
                sum = minus(x[k], diagonal[k * tile + c], sum);
            }
            x[c] = sum * inverse[c];
            t[c * tile + r] = x[c];
        }
    }
}

// The columns of a front become those of the factor; to := what they leave for the rest of the front.
inline void eliminate_front(const Node& node, Lanes* columns, Lanes* to, Lanes* inverse, Mask& definite) {
    const std::ptrdiff_t strip = static_cast<std::ptrdiff_t>(node.columns) * tile;
    const int strips = node.column_strips + node.strips_below;
    for (int j = 0; j < node.column_strips; ++j) {
        const int before = j * tile;
        const int width_of_tile = node.columns - before < tile ? node.columns - before : tile;
        const Lanes* own = columns + j * strip;
        Lanes* diagonal = columns + j * strip + static_cast<std::ptrdiff_t>(before) * tile;
        for (int i = j; i < strips; ++i) {
            Lanes* t = columns + i * strip + static_cast<std::ptrdiff_t>(before) * tile;
            if (width_of_tile == tile) {
                subtract_tile(t, columns + i * strip, own, before, t);
                if (i == j) {
                    factorize_tile(t, tile, inverse + before, definite);
                } else {
                    solve_tile<tile>(t, diagonal, inverse + before);
                }
                continue;
            }
            for (int c = 0; c < width_of_tile; ++c) {
                subtract_some<1>(t + c * tile, columns + i * strip, own + c, before, t + c * tile);
            }
            if (i == j) {
                factorize_tile(t, width_of_tile, inverse + before, definite);
            } else if (width_of_tile == 3) {
                solve_tile<3>(t, diagonal, inverse + before);
            } else if (width_of_tile == 2) {
                solve_tile<2>(t, diagonal, inverse + before);
            } else {
                solve_tile<1>(t, diagonal, inverse + before);
            }
        }
    }
    // As many strips at a time as the nearest cache holds beside the one that they are multiplied with.
    constexpr std::ptrdiff_t near = 24 * 1024 / (width * sizeof(double));
    const Lanes* below = columns + node.column_strips * strip;
    const auto group = static_cast<int>(strip < near ? near / strip : 1);
    for (int first = 0; first < node.strips_below; first += group) {
        for (int i = first; i < node.strips_below; ++i) {
            const int end = i + 1 < first + group ? i + 1 : first + group;
            for (int j = first; j < end; ++j) {
                const std::ptrdiff_t at = tiles_before(i) + j * tile_area;
                subtract_tile(nullptr, below + i * strip, below + j * strip, node.columns, to + at);
            }
        }
    }
}

// L^-1 on the rows of one supernode, Q of the right-hand sides.
template <int Q>
PAVE_INLINE void forward_columns(const Node& node, const int* rows, const Lanes* columns, const Lanes* inverse,
                                 Lanes* right, std::ptrdiff_t stride) {
    const std::ptrdiff_t strip = static_cast<std::ptrdiff_t>(node.columns) * tile;
    Lanes* own = right + node.first_column * stride;
    for (int j = 0; j < node.column_strips; ++j) {
        const int before = j * tile;
        const int in_tile = node.columns - before < tile ? node.columns - before : tile;
        Lanes t[tile][Q];
        for (int r = 0; r < tile; ++r) {
            for (int q = 0; q < Q; ++q) {
                t[r][q] = r < in_tile ? own[(before + r) * stride + q] : Lanes{};
            }
        }
        const Lanes* l = columns + j * strip;
        for (int k = 0; k < before; ++k, l += tile) {
#pragma GCC unroll 4
            for (int r = 0; r < tile; ++r) {
#pragma GCC unroll 4
                for (int q = 0; q < Q; ++q) {
                    t[r][q] = minus(l[r], own[k * stride + q], t[r][q]);
                }
            }
        }
        for (int c = 0; c < in_tile; ++c, l += tile) {
            for (int q = 0; q < Q; ++q) {
                t[c][q] *= inverse[before + c];
                own[(before + c) * stride + q] = t[c][q];
                for (int r = c + 1; r < in_tile; ++r) {
                    t[r][q] = minus(l[r], t[c][q], t[r][q]);
                }
            }
        }
    }
    const Lanes* l = columns + node.column_strips * strip;
    for (int first = 0; first < node.rows_below; first += tile) {
        Lanes t[tile][Q];
#pragma GCC unroll 4
        for (int r = 0; r < tile; ++r) {
#pragma GCC unroll 4
            for (int q = 0; q < Q; ++q) {
                t[r][q] = Lanes{};
            }
        }
        for (int k = 0; k < node.columns; ++k, l += tile) {
#pragma GCC unroll 4
            for (int r = 0; r < tile; ++r) {
#pragma GCC unroll 4
                for (int q = 0; q < Q; ++q) {
                    t[r][q] = fma(l[r], own[k * stride + q], t[r][q]);
                }
            }
        }
        const int count = node.rows_below - first < tile ? node.rows_below - first : tile;
        for (int r = 0; r < count; ++r) {
            Lanes* to = right + rows[first + r] * stride;
            for (int q = 0; q < Q; ++q) {
                to[q] -= t[r][q];
            }
        }
    }
}

// L^-T likewise. x: of the rows of the front.
template <int Q>
PAVE_INLINE void backward_columns(const Node& node, const int* rows, const Lanes* columns, const Lanes* inverse,
                                  Lanes* right, std::ptrdiff_t stride, Lanes* x) {
    const std::ptrdiff_t strip = static_cast<std::ptrdiff_t>(node.columns) * tile;
    const int strips = node.column_strips + node.strips_below;
    Lanes* own = right + node.first_column * stride;
    Lanes* below = x + static_cast<std::ptrdiff_t>(node.column_strips) * tile * Q;
    for (int i = 0; i < node.strips_below * tile; ++i) {
        for (int q = 0; q < Q; ++q) {
            below[i * Q + q] = i < node.rows_below ? right[rows[i] * stride + q] : Lanes{};
        }
    }
    for (int j = node.column_strips - 1; j >= 0; --j) {
        const int before = j * tile;
        const int in_tile = node.columns - before < tile ? node.columns - before : tile;
        Lanes t[tile][Q];
        for (int c = 0; c < tile; ++c) {
            for (int q = 0; q < Q; ++q) {
                t[c][q] = c < in_tile ? own[(before + c) * stride + q] : Lanes{};
            }
        }
        for (int i = j + 1; i < strips; ++i) {
            const Lanes* l = columns + i * strip + static_cast<std::ptrdiff_t>(before) * tile;
            const Lanes* xi = x + static_cast<std::ptrdiff_t>(i) * tile * Q;
            if (in_tile == tile) {
#pragma GCC unroll 4
                for (int r = 0; r < tile; ++r) {
#pragma GCC unroll 4
                    for (int c = 0; c < tile; ++c) {
#pragma GCC unroll 4
                        for (int q = 0; q < Q; ++q) {
                            t[c][q] = minus(l[c * tile + r], xi[r * Q + q], t[c][q]);
                        }
                    }
                }
            } else {
                for (int r = 0; r < tile; ++r) {
                    for (int c = 0; c < in_tile; ++c) {
                        for (int q = 0; q < Q; ++q) {
                            t[c][q] = minus(l[c * tile + r], xi[r * Q + q], t[c][q]);
                        }
                    }
                }
            }
        }
        const Lanes* l = columns + j * strip + static_cast<std::ptrdiff_t>(before) * tile;
        for (int c = in_tile - 1; c >= 0; --c) {
            for (int q = 0; q < Q; ++q) {
                for (int r = c + 1; r < in_tile; ++r) {
                    t[c][q] = minus(l[c * tile + r], t[r][q], t[c][q]);
                }
                t[c][q] *= inverse[before + c];
                own[(before + c) * stride + q] = t[c][q];
            }
        }
        for (int c = 0; c < tile; ++c) {
            for (int q = 0; q < Q; ++q) {
                x[(before + c) * Q + q] = c < in_tile ? t[c][q] : Lanes{};
            }
        }
    }
}

// some(first, width) for groups of right-hand sides, as many at a time as there are registers for.
template <class Some>
PAVE_INLINE void in_groups(int columns, const Some& some) {
    constexpr int most = many_registers ? 4 : 2;
    for (int first = 0; first < columns;) {
        const int left = columns - first;
        const int now = left > most && left < 2 * most ? (left + 1) / 2 : left < most ? left : most;
        some(first, now);
        first += now;
    }
}

inline void forward_node(const Structure& s, const Node& node, const Factor& f, Lanes* right, int columns) {
    in_groups(columns, [&](int first, int now) {
        const int* rows = s.rows + node.row_start;
        const Lanes* l = of(f.values) + node.factor_start;
        const Lanes* inverse = of(f.inverse) + node.first_column;
        switch (now) {
        case 1: forward_columns<1>(node, rows, l, inverse, right + first, columns); break;
        case 2: forward_columns<2>(node, rows, l, inverse, right + first, columns); break;
        case 3: forward_columns<3>(node, rows, l, inverse, right + first, columns); break;
        default: forward_columns<4>(node, rows, l, inverse, right + first, columns);
        }
    });
}

inline void backward_node(const Structure& s, const Node& node, const Factor& f, Lanes* right, int columns) {
    in_groups(columns, [&](int first, int now) {
        const int* rows = s.rows + node.row_start;
        const Lanes* l = of(f.values) + node.factor_start;
        const Lanes* inverse = of(f.inverse) + node.first_column;
        switch (now) {
        case 1: backward_columns<1>(node, rows, l, inverse, right + first, columns, of(f.rows)); break;
        case 2: backward_columns<2>(node, rows, l, inverse, right + first, columns, of(f.rows)); break;
        case 3: backward_columns<3>(node, rows, l, inverse, right + first, columns, of(f.rows)); break;
        default: backward_columns<4>(node, rows, l, inverse, right + first, columns, of(f.rows));
        }
    });
}

// Adds columns of what a child left to a part of the front of its parent, in which its rows begin at these places.
inline void add_child(const Structure& s, const Node& child, const Lanes* left, int first, int end, const int* place,
                      Lanes* part) {
    const int* column = s.column_in_parent + child.row_start;
    place += child.row_start;
    for (int j = first; j < end; ++j) {
        Lanes* to = part + column[j];
        int i = j;
        for (int strip = j / tile; strip < child.strips_below; ++strip) {
            const Lanes* from = left + tiles_before(strip) + j * tile - strip * tile;
            const int past = (strip + 1) * tile < child.rows_below ? (strip + 1) * tile : child.rows_below;
            for (; i < past; ++i) {
                to[place[i]] += from[i];
            }
        }
    }
}

inline void eliminate(const Structure& s, Part part, const double* values, Factor& f, double* right) {
    const bool constant = part == Part::constant;
    const auto of_part = [&](const Node& node) { return node.is_constant == constant; };
    const auto left_by = [](const Node& node) { return tiles_before(node.strips_below); };
    Mask definite = *reinterpret_cast<const Mask*>(f.definite);
    // The rest of a front waits on two stacks by turns, so that a front leaves its own beside that of its children.
    Lanes* top[2] = {of(f.stack[0]), of(f.stack[1])};
    for (int n = 0; n < s.count; ++n) {
        const Node& node = s.nodes[n];
        if (!of_part(node)) {
            continue;
        }
        Lanes* columns = of(f.values) + node.factor_start;
        const std::ptrdiff_t strip = static_cast<std::ptrdiff_t>(node.columns) * tile;
        for (int i = 0; i < node.column_strips + node.strips_below; ++i) { // what lies above the diagonal is not read
            const std::ptrdiff_t used = static_cast<std::ptrdiff_t>(i + 1) * tile_area;
            for (std::ptrdiff_t k = 0; k < (used < strip ? used : strip); ++k) {
                columns[i * strip + k] = Lanes{};
            }
        }
        for (std::size_t k = node.entry_start; k < s.nodes[n + 1].entry_start; ++k) {
            columns[s.entry_place[k]] = of(values)[k];
        }
        // Of the children those of the same part lie on their stack, the last one on top.
        Lanes*& own_top = top[node.is_odd ? 1 : 0];
        Lanes*& top_of_children = top[node.is_odd ? 0 : 1];
        for (int c = node.first_child; c >= 0; c = s.nodes[c].next_sibling) {
            top_of_children -= of_part(s.nodes[c]) ? left_by(s.nodes[c]) : 0;
        }
        const auto for_children = [&](const auto& some) {
            const Lanes* waiting = top_of_children;
            for (int c = node.first_child; c >= 0; c = s.nodes[c].next_sibling) {
                const Node& child = s.nodes[c];
                some(child, of_part(child) ? waiting : of(f.kept) + child.kept_start);
                waiting += of_part(child) ? left_by(child) : 0;
            }
        };
        for_children([&](const Node& child, const Lanes* left) {
            add_child(s, child, left, 0, child.rows_into_columns, s.strip_in_parent, columns);
        });
        Lanes* to = node.is_kept ? of(f.kept) + node.kept_start : own_top;
        eliminate_front(node, columns, to, of(f.inverse) + node.first_column, definite);
        for_children([&](const Node& child, const Lanes* left) {
            add_child(s, child, left, child.rows_into_columns, child.rows_below, s.tile_in_parent, to);
        });
        own_top += node.is_kept ? 0 : left_by(node);
        if (right != nullptr) {
            forward_node(s, node, f, of(right), 1);
        }
    }
    *reinterpret_cast<Mask*>(f.definite) = definite;
}

inline void forward(const Structure& s, Part part, const Factor& f, double* right, int columns) {
    for (int n = 0; n < s.count; ++n) {
        if (s.nodes[n].is_constant == (part == Part::constant)) {
            forward_node(s, s.nodes[n], f, of(right), columns);
        }
    }
}

inline void backward(const Structure& s, Part part, const Factor& f, double* right, int columns) {
    for (int n = s.count - 1; n >= 0; --n) {
        if (s.nodes[n].is_constant == (part == Part::constant)) {
            backward_node(s, s.nodes[n], f, of(right), columns);
        }
    }
}

} // namespace pave::fe::lanes::PAVE_LANES
