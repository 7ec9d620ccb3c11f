#include "mesh/axisymmetric.h"
#include "mesh/grading.h"

#include <algorithm>
#include <gtest/gtest.h>

using namespace pave::mesh;

TEST(GradedLines, HoldEveryBreakAndGrowAwayFromFeatures) {
    const auto lines = graded_lines({0.0, 0.15, 4.0}, {{0.15, 0.02}}, {.growth = 0.3, .max_size = 0.5});
    EXPECT_EQ(lines.front(), 0.0);
    EXPECT_EQ(lines.back(), 4.0);
    EXPECT_TRUE(std::find(lines.begin(), lines.end(), 0.15) != lines.end());
    EXPECT_TRUE(std::is_sorted(lines.begin(), lines.end()));
    for (std::size_t i = 1; i < lines.size(); ++i) {
        const double size = lines[i] - lines[i - 1];
        const double distance = std::max(std::abs(lines[i] - 0.15), std::abs(lines[i - 1] - 0.15));
        EXPECT_LE(size, std::min(0.5, 0.02 + 0.3 * distance) * 1.06);
    }
}

TEST(AxisymmetricMesh, ResolvesLoadEdgeInterfacesAndGauges) {
    AxisymmetricDemand demand;
    demand.thickness = {0.030, 0.277, 1.193};
    demand.gauge_depths = {0.9};
    demand.gauge_radii = {0.3};
    const auto mesh = axisymmetric_mesh(demand);
    const auto has = [](const std::vector<double>& lines, double x) {
        return std::any_of(lines.begin(), lines.end(), [&](double y) { return std::abs(x - y) < 1e-12; });
    };
    EXPECT_TRUE(has(mesh.r_lines, demand.load_radius));
    EXPECT_TRUE(has(mesh.z_lines, 0.030));
    EXPECT_TRUE(has(mesh.z_lines, 0.307));
    demand.gauge_depths = {};
    EXPECT_GT(mesh.z_cells(), axisymmetric_mesh(demand).z_cells());
}

TEST(AxisymmetricMesh, PutsEveryElementIntoItsLayerAndCoversTheSection) {
    const auto mesh = axisymmetric_mesh({0.0, 0.2, 1.0}, {0.0, 0.1, 0.3, 0.5, 1.0}, {0.1, 0.5, 1.0});
    EXPECT_EQ(mesh.layer, (std::vector<int>{0, 1, 1, 2, 0, 1, 1, 2}));
    double area = 0.0;
    for (const auto& nodes : mesh.elements) {
        const auto& a = mesh.nodes[nodes[0]];
        const auto& b = mesh.nodes[nodes[2]];
        area += (b.r - a.r) * (b.z - a.z);
        EXPECT_NEAR(mesh.nodes[nodes[5]].z, (a.z + b.z) / 2.0, 1e-15);
    }
    EXPECT_NEAR(area, 1.0, 1e-12);
}
