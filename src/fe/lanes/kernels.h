// The inner loops of many runs side by side, one lane of a vector a run. All arrays of doubles that are not said to be
// shared hold a number of every lane, lanes next to each other; they are aligned to `alignment` bytes. Numbers of rows
// and columns, places and strides count vectors.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pave::fe::lanes {

inline constexpr std::size_t alignment = 64;
inline constexpr int most_lanes = alignment / sizeof(double); // of any processor

// Rows and columns of fronts go in tiles of so many.
inline constexpr int tile = 4;

// A supernode of FactorStructure in tiles. Its front has two parts, each filled up with zeros to whole tiles. The
// columns of the factor: strips of `tile` rows, first those of the columns, then those below; within a strip column by
// column. What is left for the parent: the tiles on and below the diagonal, row of tiles by row of tiles; within a tile
// column by column.
struct Node {
    int first_column = 0;
    int columns = 0;
    int rows_below = 0;
    int column_strips = 0;
    int strips_below = 0;
    int first_child = -1;
    int next_sibling = -1;
    bool is_constant = false;
    bool is_kept = false;         // what it leaves is, for a parent that is not constant
    bool is_odd = false;          // as far as it is from the root: on which stack it leaves something
    std::size_t row_start = 0;    // into rows and places: of the rows below
    std::size_t entry_start = 0;  // into the values; those of the next node end them
    std::size_t factor_start = 0; // into the factor
    std::size_t kept_start = 0;   // into what is kept
    int rows_into_columns = 0;    // so many of its rows below are columns of the parent
};

// Where everything lies; shared by all lanes.
struct Structure {
    const Node* nodes = nullptr; // and one more, which only ends the last one's entries
    int count = 0;
    const int* rows = nullptr;             // below: numbers of unknowns in the order of elimination
    const int* entry_place = nullptr;      // of every value, in the columns of its front
    const int* strip_in_parent = nullptr;  // of every row below: where it begins in the columns of the parent's front,
    const int* tile_in_parent = nullptr;   // and in what that front leaves (-1: it is one of the columns)
    const int* column_in_parent = nullptr; // what it adds to that as a column
};

// The memory of a factor.
struct Factor {
    double* values = nullptr;
    double* inverse = nullptr;             // of the diagonal
    double* stack[2] = {nullptr, nullptr}; // what waits for its parent
    double* kept = nullptr;
    double* rows = nullptr;           // of the rows of one front, `tile` columns each
    std::int64_t* definite = nullptr; // of every lane: -1, or 0 where the matrix was found not to be so
};

// Of the dense blocks of one matrix: columns of the widest panel, and right-hand sides that go together.
inline constexpr int most_columns = 64;
inline constexpr int right_sides = 8;

// Elements of a mesh; shared by all lanes.
struct Elements {
    const int* layer = nullptr;     // of each
    const int* unknowns = nullptr;  // 16 of each, in the order of elimination; -1: held
    const int* places = nullptr;    // 136 of each: of its lower triangle row by row, in the values
    const double* shapes = nullptr; // of every Gauss point: its weight, then dN/dr, dN/dz and N/r of 8 nodes each
};
inline constexpr int nodes_of_element = 8;
inline constexpr int unknowns_of_element = 2 * nodes_of_element;
inline constexpr int lower_of_element = unknowns_of_element * (unknowns_of_element + 1) / 2;
inline constexpr int points_of_element = 4;
inline constexpr int numbers_of_shape = 1 + 3 * nodes_of_element;

// The unit stiffness of a layer: its entries rr,rr (tt,tt too); rr,tt; rr,zz (tt,zz too); zz,zz; rz,rz.
inline constexpr int unit_numbers = 5;

// Which of the supernodes.
enum class Part { constant, changing };

// The modulus of a layer, E = k1 pa (thp/pa)^k2 (tau/pa + 1)^k3 (material/power_law.h), or what a function says.
struct Modulus {
    bool is_power = false;
    const double* numbers = nullptr; // k1 pa, k2, k3, delta, eta
};
inline constexpr int power_numbers = 5;
// The parameter of an explicit derivative of a modulus: one of those numbers, or what only the function knows.
enum class Explicit : int { none = -1, k1 = 0, k2, k3, delta, eta, other };

// E, dE/dtheta and dE/dtau of one lane; explicit derivatives by the variations that are `other`.
struct ModulusOfLane {
    double value, d_theta, d_tau;
    std::int64_t limited;
};
struct ModulusFunction {
    void (*call)(const void* context, int layer, int lane, double theta, double tau, ModulusOfLane* result,
                 double* by_variation) = nullptr;
    const void* context = nullptr;
};

// The points of the stress-dependent elements.
struct Points {
    const int* elements = nullptr; // those elements
    int count = 0;                 // of elements
    int variations = 0;
    const double* initial = nullptr;       // horizontal and vertical initial stress of every point, tension positive
    const double* initial_rate = nullptr;  // the same by variation; none: it has none
    const double* unit = nullptr;          // of every layer
    const double* unit_rate = nullptr;     // of every layer by variation
    const bool* unit_varies = nullptr;     // whether one has any; shared
    const Modulus* moduli = nullptr;       // of every layer
    const Explicit* explicit_by = nullptr; // of every layer by variation; shared
    ModulusFunction function{};
};

// Shares of the volume of the stress-dependent layers as in Statistics, not yet divided by the energy.
struct Shares {
    double* energy = nullptr;
    double* tension = nullptr;
    double* unstable = nullptr;
    double* limited = nullptr;
};

struct Kernels {
    const char* instructions = nullptr;
    int lanes = 0;
    bool rounds_once = false; // multiplication and addition are fused

    // values += B^T (E C) B. E: modulus of every point of the `count` elements, or of every layer.
    void (*assemble)(const Elements& mesh, const int* elements, int count, const double* unit,
                     const double* modulus_of_points, const double* modulus_of_layers, double* values);
    // Eliminates the supernodes of a part. right: a right-hand side that is eliminated with them; none.
    void (*eliminate)(const Structure& structure, Part part, const double* values, Factor& factor, double* right);
    // L^-1 and L^-T on the rows of a part of `columns` right-hand sides, those of a row next to each other.
    void (*forward)(const Structure& structure, Part part, const Factor& factor, double* right, int columns);
    void (*backward)(const Structure& structure, Part part, const Factor& factor, double* right, int columns);
    // Moduli at the points and, with variations, their rates.
    void (*moduli)(const Elements& mesh, const Points& points, const double* stress, const double* d_stress,
                   double* modulus, double* modulus_rate);
    // Stress at the points of the displacement u at these moduli; with variations its rates at held u, their force
    // subtracted from right.
    void (*stress)(const Elements& mesh, const Points& points, const double* modulus, const double* modulus_rate,
                   const double* u, double* stress, double* d_stress, double* right);
    // d_stress += that of the rates du of the displacement.
    void (*add_stress_rates)(const Elements& mesh, const Points& points, const double* modulus, const double* du,
                             double* d_stress);
    // right(column of columns) -= B^T (D strain of u) over the elements; d: unit_numbers of D.
    void (*subtract_force)(const Elements& mesh, const int* elements, int count, const double* d, const double* u,
                           double* right, int column, int columns);
    // The same of stress at the points, one column.
    void (*subtract_stress)(const Elements& mesh, const Points& points, const double* stress, double* right);
    // Adds up shares; compliance: of every layer, unit_numbers of the inverse of C.
    void (*shares)(const Elements& mesh, const Points& points, const double* compliance, const double* stress,
                   Shares& sums);
    // to := from + sum of factor_i rate_i over `count` numbers of every lane.
    void (*combine)(double* to, const double* from, int rates, const double* factors, const double* const* rate,
                    std::size_t count);

    // One matrix instead of many, by columns, aligned. Cholesky's factor in the first columns of a front, and what they
    // leave of the rest; on and below the diagonal, what is above is overwritten. Its columns are `stride` numbers
    // apart, a multiple of 8, and zero behind its rows. False: the matrix is not positive definite.
    bool (*eliminate_dense)(double* front, int rows, int columns, std::ptrdiff_t stride);
    // The inverse of at most most_columns columns of a lower triangle, by columns next to each other; what is above the
    // diagonal is not touched.
    void (*invert_dense)(const double* lower, int columns, std::ptrdiff_t stride, double* inverse);
    // A panel's part of the solution for right_sides right-hand sides, those of a row next to each other: the inverse
    // of its diagonal block, then the block below, whose rows are `rows` of x; `first`: its first column.
    void (*forward_dense)(const double* panel, int columns, int rows_below, const int* rows, int first, double* x);
    void (*backward_dense)(const double* panel, int columns, int rows_below, const int* rows, int first, double* x);
    // The same for one. Eight numbers behind the panel's may be read; scratch: aligned, eight more than rows_below.
    void (*forward_one)(const double* panel, int columns, int rows_below, const int* rows, int first, double* x,
                        double* scratch);
    void (*backward_one)(const double* panel, int columns, int rows_below, const int* rows, int first, double* x,
                         double* scratch);

    // For tests: ln x, ln(1 + x), exp x of every lane.
    void (*functions)(const double* x, double* log, double* log_1_plus, double* exp);
};

// Of the narrowest vectors, of those that this processor has and the build knows, with room for so many runs; the
// widest where none has. All of them give the same bits.
const Kernels& kernels(int runs);
// Of all that this processor has, the widest first.
int usable_kernels(const Kernels** list, int most);

} // namespace pave::fe::lanes
