// Structured mesh of twenty-node hexahedra of a quarter of a layered section: x >= 0 transverse, y >= 0 along the
// traffic, z down.
#pragma once

#include <array>
#include <vector>

namespace pave::mesh {

struct Point3 {
    double x, y, z; // m
};

// Cells are numbered down first, then along y: cell (i, j, k) is element (i * y_cells + j) * z_cells + k. Local nodes
// as in fe/hex20.h.
struct SolidMesh {
    std::vector<double> x_lines, y_lines, z_lines;
    std::vector<Point3> nodes;
    std::vector<std::array<int, 20>> elements;
    std::vector<int> layer; // of each element
    int layers = 0;
    bool endless = false;      // as of an AxisymmetricMesh, along all three axes
    bool wall_is_open = false; // as of one, both walls
    bool bottom_is_open = false;

    int x_cells() const { return static_cast<int>(x_lines.size()) - 1; }
    int y_cells() const { return static_cast<int>(y_lines.size()) - 1; }
    int z_cells() const { return static_cast<int>(z_lines.size()) - 1; }
    int element(int i, int j, int k) const { return (i * y_cells() + j) * z_cells() + k; }
};

// Lengths that the mesh must resolve by itself. The patch reaches from x_inner to x_outer and from y = 0 to y_outer.
struct SolidDemand {
    std::vector<double> thickness;        // of each layer, top to bottom [m]
    bool is_dual = false;                 // one of two patches, which mirror each other: x_inner is an edge
    double x_inner = 0.0;                 // m
    double x_outer = 0.15;                // m
    double y_outer = 0.15;                // m
    bool is_round = false;                // a circle: its edge crosses the cells, which must be smaller for it
    double extent = 4.0;                  // m: the smooth walls x = extent and y = extent
    double refine = 1.0;                  // cells are this many times smaller
    std::vector<double> gauge_depths;     // m: depths where strains are read over a length
    std::vector<double> gauge_x, gauge_y; // m: where they are read
    std::vector<double> point_depths;     // m: depths where strains or stresses are read at a point
    std::vector<double> point_x, point_y; // m: where they are read
    std::vector<double> surface_x, surface_y;
};

// The breaks in x and in y: where the patch and the mesh begin and end. Each is a line of the mesh unless another is so
// near that the cells between them would be slivers.
std::array<std::vector<double>, 2> patch_breaks(const SolidDemand& demand);

SolidMesh solid_mesh(const SolidDemand& demand);

// The same structure from given lines. layer_bottoms: depth of the bottom of each layer, each a z line.
SolidMesh solid_mesh(std::vector<double> x_lines, std::vector<double> y_lines, std::vector<double> z_lines,
                     const std::vector<double>& layer_bottoms);

} // namespace pave::mesh
