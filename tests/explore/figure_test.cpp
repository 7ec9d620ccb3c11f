// Figures of constructed results: the numbers that they must show, worked out by hand.
#include "report/density.h"
#include "report/figures.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

using namespace explore::report;

namespace {

// Draws from a normal distribution of the plane around (0.5, 0.5); folded: around (0, 0.5), those left of it mirrored.
struct Cloud {
    std::vector<double> x, y, weight;
};
Cloud normal_cloud(std::size_t count, unsigned seed, double sx, double sy, double slope, bool folded = false) {
    std::mt19937_64 random(seed);
    const auto draw = [&] { return gsl_cdf_ugaussian_Pinv((static_cast<double>(random() >> 11U) + 0.5) * 0x1p-53); };
    Cloud cloud;
    for (std::size_t i = 0; i < count; ++i) {
        const double a = draw();
        const double b = draw();
        cloud.x.push_back(folded ? std::abs(sx * a) : 0.5 + sx * a);
        cloud.y.push_back(0.5 + sy * (slope * a + std::sqrt(1.0 - slope * slope) * b));
        cloud.weight.push_back(1.0);
    }
    return cloud;
}

double area_of(const std::vector<Contour>& borders) {
    double area = 0.0;
    for (const Contour& border : borders) {
        area += border.below ? border.area : -border.area;
    }
    return area;
}

bool is_inside(const Contour& border, double x, double y) {
    bool inside = false;
    for (std::size_t i = 0, j = border.x.size() - 1; i < border.x.size(); j = i++) {
        const double along = (y - border.y[i]) / (border.y[j] - border.y[i]);
        if ((border.y[i] > y) != (border.y[j] > y) && x < border.x[i] + along * (border.x[j] - border.x[i])) {
            inside = !inside;
        }
    }
    return inside;
}

constexpr double chi2_95 = 5.991464547107979; // of two degrees of freedom: -2 ln 0.05

// The densest region of a normal distribution is an ellipse of the area pi chi2 sx sy sqrt(1 - slope^2).
TEST(DensestRegion, IsTheEllipseOfANormalCloud) {
    constexpr unsigned clouds = 8;
    for (const double slope : {0.0, 0.9}) {
        double area = 0.0;
        double share = 0.0;
        for (unsigned seed = 1; seed <= clouds; ++seed) {
            const Cloud cloud = normal_cloud(1000, seed, 0.08, 0.05, slope);
            const auto borders = densest_region(cloud.x, cloud.y, cloud.weight, 0.95);
            ASSERT_FALSE(borders.empty());
            area += area_of(borders) / clouds;
            const Cloud others = normal_cloud(1000, 100 + seed, 0.08, 0.05, slope);
            for (std::size_t i = 0; i < others.x.size(); ++i) {
                share += is_inside(borders[0], others.x[i], others.y[i]) ? 1e-3 / clouds : 0.0;
            }
        }
        const double ellipse = std::numbers::pi * chi2_95 * 0.08 * 0.05 * std::sqrt(1.0 - slope * slope);
        EXPECT_NEAR(area / ellipse, 1.0, 0.05) << slope;
        EXPECT_NEAR(share, 0.95, 0.01) << slope;
    }
}

// Of few points too: each is ranked by the density of the others.
TEST(DensestRegion, HoldsItsShareOfOtherPoints) {
    constexpr unsigned clouds = 32;
    double share = 0.0;
    for (unsigned seed = 1; seed <= clouds; ++seed) {
        const Cloud cloud = normal_cloud(100, seed, 0.08, 0.05, 0.5);
        const auto borders = densest_region(cloud.x, cloud.y, cloud.weight, 0.95);
        const Cloud others = normal_cloud(1000, 100 + seed, 0.08, 0.05, 0.5);
        for (std::size_t i = 0; i < others.x.size(); ++i) {
            share += std::any_of(borders.begin(), borders.end(),
                                 [&](const Contour& b) { return is_inside(b, others.x[i], others.y[i]); })
                         ? 1e-3 / clouds
                         : 0.0;
        }
    }
    EXPECT_NEAR(share, 0.95, 0.015);
}

TEST(DensestRegion, EndsAtAnEdgeWhereThePointsDo) {
    constexpr unsigned clouds = 8;
    double area = 0.0;
    double width = 0.0; // at the edge
    for (unsigned seed = 1; seed <= clouds; ++seed) {
        const Cloud cloud = normal_cloud(1000, seed, 0.08, 0.05, 0.0, true);
        const auto borders = densest_region(cloud.x, cloud.y, cloud.weight, 0.95);
        ASSERT_FALSE(borders.empty());
        area += area_of(borders) / clouds;
        EXPECT_EQ(*std::min_element(borders[0].x.begin(), borders[0].x.end()), 0.0);
        double low = 1.0;
        double high = 0.0;
        for (std::size_t i = 0; i < borders[0].x.size(); ++i) {
            if (borders[0].x[i] < 1e-9) {
                low = std::min(low, borders[0].y[i]);
                high = std::max(high, borders[0].y[i]);
            }
        }
        width += (high - low) / clouds;
    }
    EXPECT_NEAR(width / (2.0 * std::sqrt(chi2_95) * 0.05), 1.0, 0.06); // there the ellipse is widest
    EXPECT_NEAR(area / (0.5 * std::numbers::pi * chi2_95 * 0.08 * 0.05), 1.0, 0.05);
}

TEST(DensestRegion, TakesWeightsAndPartsAsTheyAre) {
    Cloud cloud = normal_cloud(400, 1, 0.02, 0.02, 0.0);
    const std::size_t half = cloud.x.size();
    for (std::size_t i = 0; i < half; ++i) { // a second place, far off
        cloud.x.push_back(cloud.x[i] + 0.4);
        cloud.y.push_back(cloud.y[i]);
        cloud.weight.push_back(1.0);
    }
    for (std::size_t i = 0; i < half; ++i) {
        cloud.x[i] -= 0.3;
    }
    EXPECT_EQ(densest_region(cloud.x, cloud.y, cloud.weight, 0.95).size(), 2U);
    std::fill(cloud.weight.begin() + static_cast<std::ptrdiff_t>(half), cloud.weight.end(), 0.01);
    EXPECT_EQ(densest_region(cloud.x, cloud.y, cloud.weight, 0.95).size(), 1U);
    EXPECT_TRUE(densest_region(std::vector(9, 0.5), std::vector(9, 0.5), std::vector(9, 1.0), 0.95).empty());
}

const DataTable& table_of(const Figure& figure, const std::string& name) {
    const auto found =
        std::find_if(figure.tables.begin(), figure.tables.end(), [&](const DataTable& t) { return t.name == name; });
    if (found == figure.tables.end()) {
        throw std::out_of_range("no table " + name);
    }
    return *found;
}

using Rows = std::vector<std::vector<std::string>>;

Json sample_json() {
    return {{"status", "converged"},
            {"parameters",
             {{{"name", "base.k2"},
               {"min", 0.0},
               {"max", 1.0},
               {"scale", "linear"},
               {"mean", 0.25},
               {"sd", 0.4},
               {"q025", 0.0},
               {"q50", 0.1},
               {"q975", 1.0},
               {"prior", {{"mean", 0.5}, {"sd", 0.1}}}},
              {{"name", "subgrade.modulus_MPa"},
               {"min", 1.0},
               {"max", 100.0},
               {"scale", "log"},
               {"mean", 20.0},
               {"sd", 30.0},
               {"q025", 1.0},
               {"q50", 10.0},
               {"q975", 90.0}}}},
            {"outputs",
             {{{"name", "strain"},
               {"unit", "um/m"},
               {"mean", 1.0},
               {"sd", 2.0},
               {"q025", 3.0},
               {"q50", 4.0},
               {"q975", 5.0}}}},
            {"draws", {{1.5, 0.0, 1.0}, {1.5, 0.0, 10.0}, {1.0, 1.0, 100.0}}},
            {"regions",
             {{{"x", "base.k2"},
               {"y", "subgrade.modulus_MPa"},
               {"share", 0.95},
               {"borders", {{{0.25, 2.0}, {0.5, 2.0}, {0.25, 50.0}, {0.25, 2.0}}}}}}}};
}

TEST(PosteriorFigure, HasDrawsRangesDensitiesAndBorders) {
    const FolderContents contents{{{"sample", sample_json()}}, nullptr};
    ASSERT_EQ(figures_of(contents), std::vector<std::string>{"posterior"});
    const Figure figure = make_figure(contents, "posterior");
    EXPECT_EQ(table_of(figure, "posterior").rows,
              (Rows{{"base.k2", "0.25", "0.4", "0", "0.1", "1", "", "0", "1", "linear", "0.5", "0.1"},
                    {"subgrade.modulus_MPa", "20", "30", "1", "10", "90", "MPa", "1", "100", "log", "", ""},
                    {"strain", "1", "2", "3", "4", "5", "um/m", "", "", "", "", ""}}));
    EXPECT_EQ(table_of(figure, "posterior-draws").rows,
              (Rows{{"1.5", "0", "1"}, {"1.5", "0", "10"}, {"1", "1", "100"}}));
    EXPECT_EQ(table_of(figure, "posterior-regions").rows[2],
              (std::vector<std::string>{"base.k2", "subgrade.modulus_MPa", "1", "0.25", "50"}));
    // 24 cells over the whole box: three quarters of the weight in the first, a quarter in the last.
    const Rows& marginals = table_of(figure, "posterior-marginals").rows;
    ASSERT_EQ(marginals.size(), 48U);
    EXPECT_NEAR(std::stod(marginals[0][3]), 0.75 * 24, 1e-9);
    EXPECT_NEAR(std::stod(marginals[23][3]), 0.25 * 24, 1e-9);
    EXPECT_EQ(std::stod(marginals[12][3]), 0.0);
    // On a logarithmic scale the draw at 10 lies in the middle: 1, 10, 100 weigh 3/8, 3/8 and 1/4.
    EXPECT_NEAR(std::stod(marginals[24][3]), 0.375 * 24, 1e-9);
    EXPECT_NEAR(std::stod(marginals[24 + 12][1]), 10.0, 1e-9);
    EXPECT_NEAR(std::stod(marginals[24 + 12][3]) + std::stod(marginals[24 + 11][3]), 0.375 * 24, 1e-9);
}

// The prior over the uniform one: 1/(sd sqrt(2 pi)) at its mean; 1 where there is none.
TEST(PosteriorFigure, DrawsThePriorBesideTheMarginal) {
    const Figure figure = posterior_figure(sample_json());
    const auto prior_of = [](const Panel& panel) {
        for (const Layer& layer : panel.layers) {
            if (const auto* line = std::get_if<Line>(&layer); line != nullptr && line->dashed) {
                return *line;
            }
        }
        throw std::out_of_range("no prior");
    };
    const Line known = prior_of(figure.panels[0]);
    ASSERT_EQ(known.x.size(), 101U);
    EXPECT_NEAR(known.x[50], 0.5, 1e-12);
    EXPECT_NEAR(known.y[50], 3.98942280401, 1e-4);
    EXPECT_NEAR(known.y[60], 3.98942280401 * std::exp(-0.5), 1e-4); // one standard deviation above
    for (const double density : prior_of(figure.panels[2]).y) {
        EXPECT_EQ(density, 1.0);
    }
}

Json station(const std::string& name, double chainage, const std::string& lane, double d0) {
    return {{"station", name},
            {"profile", ""},
            {"lane", lane},
            {"chainage_m", chainage},
            {"status", "ok"},
            {"reason", ""},
            {"remarks", {"all"}},
            {"D0_um", d0},
            {"D0_um_at_common_pressure", d0},
            {"deflection_ratio", nullptr},
            {"normalised", {{"SCI_um", 0.5 * d0}, {"BDI_um", nullptr}, {"BCI_um", nullptr}}}};
}

Json survey_json() {
    Json stations = {station("a", 0, "L", 300), station("b", 100, "L", 500), station("c", 200, "L", 420),
                     station("d", 300, "L", 100), station("e", 50, "R", 700)};
    const auto fit = [](Json& s, double value, bool determined) {
        s["fit"] = {{"parameters", {{"base.modulus_MPa", value}}}, {"rms_percent", 2.0}};
        s["parameters"] = {
            {"base.modulus_MPa",
             {{"value", value}, {"low", 0.5 * value}, {"high", 2.0 * value}, {"determined", determined}}}};
    };
    fit(stations[0], 200.0, true);
    fit(stations[1], 240.0, false);
    stations[2]["status"] = "no-fit";
    stations[2]["reason"] = "far off";
    stations[4]["remarks"].push_back("late");
    stations.push_back({{"station", "f"},
                        {"profile", ""},
                        {"lane", "R"},
                        {"chainage_m", 150.0},
                        {"status", "rejected"},
                        {"reason", "rises"},
                        {"remarks", Json::array()}});
    return {{"stations", stations},
            {"common_pressure_kPa", 566.0},
            {"deflection_ratio", {{"limit", 0.6}}},
            {"sections",
             {{{"profile", ""}, {"lane", "L"}, {"from_m", 0.0}, {"to_m", 200.0}},
              {{"profile", ""}, {"lane", "L"}, {"from_m", 300.0}, {"to_m", 300.0}}}}};
}

TEST(RoadFigures, HaveStationsRangesMediansAndWarnings) {
    const FolderContents contents{{{"survey", survey_json()}}, nullptr};
    ASSERT_EQ(figures_of(contents), (std::vector<std::string>{"deflections", "back-calculation"}));
    const Figure deflections = make_figure(contents, "deflections");
    const Rows& d0 = table_of(deflections, "deflections").rows;
    ASSERT_EQ(d0.size(), 10U); // D0 and SCI of five stations; no index is made up
    EXPECT_EQ(d0[4],
              (std::vector<std::string>{"e", "", "R", "50", "D0_um_at_common_pressure", "700", "", "", "yes", "um"}));
    EXPECT_EQ(d0[5], (std::vector<std::string>{"a", "", "L", "0", "SCI_um", "150", "", "", "yes", "um"}));
    EXPECT_EQ(table_of(deflections, "deflections-sections").rows,
              (Rows{{"", "L", "0", "200", "D0_um_at_common_pressure", "420"},
                    {"", "L", "300", "300", "D0_um_at_common_pressure", "100"},
                    {"", "L", "0", "200", "SCI_um", "210"},
                    {"", "L", "300", "300", "SCI_um", "50"}}));
    // What all stations have is no warning.
    EXPECT_EQ(table_of(deflections, "warnings").rows, (Rows{{"c", "", "L", "200", "not described", "far off"},
                                                            {"e", "", "R", "50", "remark", "late"},
                                                            {"f", "", "R", "150", "rejected", "rises"}}));

    const Figure fits = make_figure(contents, "back-calculation");
    EXPECT_EQ(table_of(fits, "back-calculation").rows,
              (Rows{{"a", "", "L", "0", "base.modulus_MPa", "200", "100", "400", "yes", "MPa"},
                    {"b", "", "L", "100", "base.modulus_MPa", "240", "120", "480", "no", "MPa"},
                    {"a", "", "L", "0", "rms_percent", "2", "", "", "yes", "%"},
                    {"b", "", "L", "100", "rms_percent", "2", "", "", "yes", "%"}}));
    EXPECT_EQ(table_of(fits, "back-calculation-sections").rows,
              (Rows{{"", "L", "0", "200", "base.modulus_MPa", "220"}}));
    EXPECT_EQ(fits.panels[1].y.label, "base\nmodulus (MPa)");
}

TEST(RoadFigures, StandInTheirOrderWithoutChainage) {
    Json survey = survey_json();
    for (Json& s : survey["stations"]) {
        s["chainage_m"] = nullptr;
    }
    survey["sections"] = Json::array();
    const Figure figure = deflections_figure(survey);
    const Panel& lowest =
        *std::find_if(figure.panels.begin(), figure.panels.end(), [](const Panel& p) { return !p.x.label.empty(); });
    EXPECT_EQ(lowest.x.label, "station, in their order");
    EXPECT_NEAR(lowest.x.low, 1.0 - 0.03 * 5, 1e-12);
}

// A bowl, or the wall that `rise` makes, over two parameters from 0 to 1 on 21 x 21 lines.
template <typename Rise>
Json unique_json(const Rise& rise) {
    Json pair = {{"x", "base.k1"},
                 {"y", "base.n"},
                 {"x_values", Json::array()},
                 {"y_values", Json::array()},
                 {"rise", Json::array()}};
    for (int i = 0; i <= 20; ++i) {
        pair["x_values"].push_back(i / 20.0);
        pair["y_values"].push_back(i / 20.0);
    }
    for (int j = 0; j <= 20; ++j) {
        Json row = Json::array();
        for (int i = 0; i <= 20; ++i) {
            const double z = rise(i / 20.0, j / 20.0);
            row.push_back(std::isnan(z) ? Json() : Json(z));
        }
        pair["rise"].push_back(std::move(row));
    }
    const auto parameter = [](const char* name) {
        return Json{{"name", name}, {"min", 0.0}, {"max", 1.0}, {"scale", "linear"}};
    };
    return {{"parameters", {parameter("base.k1"), parameter("base.n")}},
            {"minima", {{{"misfit", 1.0}, {"parameters", {{"base.k1", 0.5}, {"base.n", 0.5}}}}}},
            {"traces", Json::array()},
            {"landscape",
             {{"limit", 4.0},
              {"pairs", {pair}},
              {"profiles", {{{"name", "base.k1"}, {"values", {0.0, 0.5, 1.0}}, {"rise", {25.0, 0.0, 25.0}}}}}}}};
}

// 100 r^2 around the middle: the data accept a circle of radius 0.2; ten times the limit is the top.
TEST(SurfaceFigure, HasTheBowlTheBorderAndTheMinimum) {
    const Json unique =
        unique_json([](double x, double y) { return 100.0 * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5)); });
    const auto figures = pair_figures({{{"unique", unique}}, nullptr}, {"base.n", "base.k1"});
    ASSERT_EQ(figures.size(), 2U);
    EXPECT_EQ(figures[0].name, "landscape-base.k1-base.n");
    EXPECT_EQ(figures[1].name, "landscape-base.k1-base.n-surface");
    ASSERT_EQ(figures[1].spaces.size(), 1U);
    const Space& space = figures[1].spaces[0];
    EXPECT_EQ(space.z.high, 40.0);
    EXPECT_EQ(space.x.label, "base k1");
    const std::size_t nx = space.grid_x.size();
    ASSERT_EQ(space.high.size(), nx * space.grid_y.size());
    for (std::size_t n = 0; n < space.high.size(); ++n) {
        const double x = space.grid_x[n % nx] - 0.5;
        const double y = space.grid_y[n / nx] - 0.5;
        EXPECT_NEAR(space.high[n], 100.0 * (x * x + y * y), 0.2);
    }
    const double lift = 0.004 * 40.0; // lines lie so much above the surface
    const Course& mesh = space.lines[0];
    for (const double z : mesh.z) {
        EXPECT_FALSE(z > 40.0 + lift);
    }
    const Course& border = space.lines[1];
    ASSERT_GT(border.x.size(), 20U);
    for (std::size_t i = 0; i + 1 < border.x.size(); ++i) {
        EXPECT_NEAR(std::hypot(border.x[i] - 0.5, border.y[i] - 0.5), 0.2, 0.002);
        EXPECT_NEAR(border.z[i], 4.0 + lift, 0.1);
    }
    EXPECT_EQ(space.lines[2].x, std::vector{0.5});
    EXPECT_NEAR(space.lines[2].z[0], lift, 0.05);
    const Rows& nodes = table_of(figures[1], figures[1].name).rows;
    ASSERT_EQ(nodes.size(), 441U);
    EXPECT_EQ(nodes[0], (std::vector<std::string>{"0", "0", "50"}));
    const std::string script = gnuplot_script(figures[1], FigureFormat::pdf, "x.pdf");
    EXPECT_NE(script.find("splot"), std::string::npos);
    EXPECT_NE(script.find("set hidden3d"), std::string::npos);
}

// A wall at one side: it is seen from the other.
TEST(SurfaceFigure, IsSeenFromTheOpenSide) {
    const auto turned = [](const auto& rise) {
        Json unique = unique_json(rise);
        unique["minima"][0]["parameters"] = {{"base.k1", 0.5}, {"base.n", 0.5}};
        return surface_figure(unique, {"base.k1", "base.n"}).spaces[0].turned;
    };
    const double low_x = turned([](double x, double) { return x < 0.55 ? 0.0 : 39.0; });
    EXPECT_GT(low_x, 180.0);
    const double high_x = turned([](double x, double) { return x > 0.45 ? 0.0 : 39.0; });
    EXPECT_LT(high_x, 180.0);
    const double low_y = turned([](double, double y) { return y < 0.55 ? 0.0 : 39.0; });
    EXPECT_TRUE(low_y < 90.0 || low_y > 270.0) << low_y;
}

TEST(SurfaceFigure, LeavesHolesOpen) {
    const Json unique = unique_json([](double x, double y) { return x > 0.97 && y > 0.97 ? NAN : 1.0; });
    const Figure figure = surface_figure(unique, {"base.k1", "base.n"});
    const Space& space = figure.spaces[0];
    EXPECT_TRUE(std::isnan(space.high.back()));
    EXPECT_NEAR(space.high.front(), 1.0, 1e-9);
    const auto holes = std::count_if(space.high.begin(), space.high.end(), [](double z) { return std::isnan(z); });
    EXPECT_EQ(holes, 9); // lines nearer to that node than to the next: its own and two before, each way
}

} // namespace
