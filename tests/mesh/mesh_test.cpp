#include "mesh/axisymmetric.h"
#include "mesh/grading.h"
#include "mesh/solid.h"

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

// Three cells and a bit: four, unless the bit is less than a twentieth of a cell.
TEST(GradedLines, RoundTheNumberOfCellsUp) {
    const auto cells = [](double length) {
        return graded_lines({0.0, length}, {}, {.growth = 0.0, .max_size = 1.0}).size() - 1;
    };
    EXPECT_EQ(cells(3.0), 3U);
    EXPECT_EQ(cells(3.049), 3U);
    EXPECT_EQ(cells(3.051), 4U);
    EXPECT_EQ(cells(0.01), 1U);
}

// Cells beside a break depend on what is near, not on how far the next break is.
TEST(GradedLines, ResolveAFeatureHoweverFarTheNextBreakIs) {
    const auto first = [](double extent, int i) {
        const auto lines = graded_lines({0.15, extent}, {{0.15, 0.024}}, {.growth = 0.3, .max_size = extent / 8.0});
        return lines[i] - 0.15;
    };
    for (int i = 1; i <= 5; ++i) {
        for (const double extent : {20.0, 300.0, 1000.0, 1e5}) {
            EXPECT_NEAR(first(extent, i) / first(4.0, i), 1.0, 0.1) << extent << " line " << i;
        }
    }
}

TEST(GradedLines, MayLeaveOutBreaksThatOthersStandBeside) {
    const std::vector<Feature> features{{0.0, 0.1}};
    const Grading grading{.growth = 0.5, .max_size = 1.0};
    const std::vector<double> apart{0.0, 0.02, 1.0, 3.0};
    EXPECT_EQ(without_slivers(apart, features, grading), apart);
    EXPECT_EQ(without_slivers({0.0, 1e-17, 1.0, 1.03, 2.99, 3.0}, features, grading),
              (std::vector<double>{0.0, 1.0, 3.0}));
}

TEST(SolidMesh, HasNoSliverBetweenPatchesThatAlmostTouch) {
    SolidDemand demand;
    demand.thickness = {0.05, 0.3, 1.0};
    demand.is_dual = true;
    demand.x_outer = 0.34;
    for (const double gap : {1e-17, 1e-4, 3e-3}) {
        demand.x_inner = gap;
        const auto lines = solid_mesh(demand).x_lines;
        EXPECT_GT(lines[1], 0.01);
    }
    demand.x_inner = 0.03; // not so near
    const auto lines = solid_mesh(demand).x_lines;
    EXPECT_TRUE(std::find(lines.begin(), lines.end(), demand.x_inner) != lines.end());
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

// Cells `times` smaller: every cell becomes about as many, whatever is to be resolved. The number of cells between
// breaks is rounded up, at most from one to two.
void expect_parts(const std::vector<double>& lines, const std::vector<double>& fine, int times) {
    for (std::size_t i = 1; i < lines.size(); ++i) {
        const auto inside = std::count_if(fine.begin(), fine.end(),
                                          [&](double x) { return x >= lines[i - 1] - 1e-12 && x < lines[i] - 1e-12; });
        EXPECT_GE(inside, times / 2) << lines[i - 1] << " to " << lines[i];
        EXPECT_LE(inside, times + 1) << lines[i - 1] << " to " << lines[i];
    }
}

std::vector<std::vector<double>> lines_of(const AxisymmetricMesh& mesh) {
    return {mesh.r_lines, mesh.z_lines};
}
std::vector<std::vector<double>> lines_of(const SolidMesh& mesh) {
    return {mesh.x_lines, mesh.y_lines, mesh.z_lines};
}

template <class Demand, class MakeMesh>
void expect_finer(Demand demand, const MakeMesh& make_mesh, int times) {
    const auto lines = lines_of(make_mesh(demand));
    demand.refine = times;
    const auto fine = lines_of(make_mesh(demand));
    for (std::size_t d = 0; d < lines.size(); ++d) {
        expect_parts(lines[d], fine[d], times);
    }
}

const std::vector<std::vector<double>> sections{{0.05, 0.3, 3.0}, {1.0, 3.0}, {4.0}}; // thickness of layers

TEST(AxisymmetricMesh, IsEverywhereAsMuchFinerAsAsked) {
    const auto check = [](const AxisymmetricDemand& demand) {
        expect_finer(
            demand, [](const AxisymmetricDemand& d) { return axisymmetric_mesh(d); }, 24);
    };
    AxisymmetricDemand demand;
    for (const auto& section : sections) {
        demand.thickness = section;
        check(demand);
    }
    demand.surface_radii = {1.5};
    check(demand);
    demand.gauge_depths = {1.7};
    demand.gauge_radii = {2.5};
    check(demand);
}

TEST(SolidMesh, IsEverywhereAsMuchFinerAsAsked) {
    const auto check = [](const SolidDemand& demand) {
        expect_finer(
            demand, [](const SolidDemand& d) { return solid_mesh(d); }, 8);
    };
    SolidDemand demand;
    for (const auto& section : sections) {
        demand.thickness = section;
        check(demand);
    }
    SolidDemand other = demand;
    other.is_round = true;
    check(other);
    other = demand;
    other.is_dual = true;
    other.x_inner = 0.1;
    other.x_outer = 0.3;
    check(other);
    other = demand;
    other.surface_x = {1.5};
    other.surface_y = {1.2};
    check(other);
    other = demand;
    other.gauge_depths = other.gauge_x = {1.7};
    other.gauge_y = {2.1};
    check(other);
    other = demand;
    other.point_depths = other.point_x = {1.7};
    other.point_y = {2.1};
    check(other);
}
