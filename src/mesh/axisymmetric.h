// Structured mesh of eight-node quadrilaterals of a layered section around a vertical axis.
#pragma once

#include <array>
#include <vector>

namespace pave::mesh {

struct Point2 {
    double r; // m from the axis
    double z; // m below the surface
};

// Cells are numbered down first: cell (i, j), i-th in r and j-th in z, is element i * z_cells + j.
// Local nodes: 0..3 corners (r0 z0), (r1 z0), (r1 z1), (r0 z1); 4..7 midsides between 0-1, 1-2, 2-3, 3-0.
struct AxisymmetricMesh {
    std::vector<double> r_lines;
    std::vector<double> z_lines;
    std::vector<Point2> nodes;
    std::vector<std::array<int, 8>> elements;
    std::vector<int> layer; // of each element
    int layers = 0;
    // The last cells outwards and downwards have no end: one from x to 3 x stands for x to infinity, its middle is 2 x.
    bool endless = false;
    // The outer side and the bottom are free: what holds them there absorbs waves.
    bool wall_is_open = false;
    bool bottom_is_open = false;

    int r_cells() const { return static_cast<int>(r_lines.size()) - 1; }
    int z_cells() const { return static_cast<int>(z_lines.size()) - 1; }
};

// Lengths that the mesh must resolve by itself.
struct AxisymmetricDemand {
    std::vector<double> thickness; // of each layer, top to bottom [m]
    double load_radius = 0.15;     // m: edge of the loaded circle
    double extent = 4.0;           // m: radius of the smooth wall
    double edge_size = 0.16;       // of a cell at the edge of the load, in its radius; a stiff plate has a pole there
    double refine = 1.0;           // cells are this many times smaller
    std::vector<double> gauge_depths;  // m: depths where strains or stresses are read
    std::vector<double> gauge_radii;   // m: radii where strains or stresses are read
    std::vector<double> surface_radii; // m: radii where deflections are read
    // Whether cells are as small as readings near the surface ask for. Not where the stiffness of small cells near
    // tension has two equilibria to choose from.
    bool follows_gauges = true;
};

AxisymmetricMesh axisymmetric_mesh(const AxisymmetricDemand& demand);

// The same structure from given lines. layer_bottoms: depth of the bottom of each layer, each a z line.
AxisymmetricMesh axisymmetric_mesh(std::vector<double> r_lines, std::vector<double> z_lines,
                                   const std::vector<double>& layer_bottoms);

} // namespace pave::mesh
