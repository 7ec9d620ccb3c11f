// What results say in sentences: constructed results, the sentences that they must give.
#include "analysis/fit.h"
#include "analysis/unique.h"
#include "support/formula.h"

#include <algorithm>
#include <gtest/gtest.h>

using namespace explore;

namespace {

study::Study study_in_memory(const std::string& law) {
    const std::string base = law == "uzan-deviator" ? "law = \"uzan-deviator\"\n" : "law = \"uzan\"\n";
    return study::study_of("schema = 1\n"
                           "[[layers]]\nname = \"base\"\nthickness_mm = 300\ndensity_kg_m3 = 2200\nk0 = 0.5\n" +
                               base +
                               "k1 = 1500\nk2 = 0.6\nk3 = -0.3\nn = 0.4\npoisson_12 = 0.35\npoisson_31 = 0.35\n"
                               "[[layers]]\nname = \"subgrade\"\nthickness_mm = 2000\ndensity_kg_m3 = 1900\nk0 = 0.5\n"
                               "law = \"linear\"\nmodulus_MPa = 50\npoisson = 0.4\n"
                               "[[loads]]\nname = \"fwd\"\ntype = \"plate\"\nradius_mm = 150\npressure_kPa = 566\n"
                               "[data]\nfiles = [\"bowl.csv\"]\nmisfit = \"weighted\"\n"
                               "[[parameters]]\nname = \"base.k1\"\nmin = 300\nmax = 12000\nscale = \"log\"\n"
                               "[[parameters]]\nname = \"base.k2\"\nmin = 0\nmax = 1\n"
                               "[[parameters]]\nname = \"base.k3\"\nmin = -2\nmax = 0\n",
                           "memory.toml",
                           {{"bowl.csv", "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n"
                                         "fwd,deflection,0,0,0,0,0.9,mm,0.02\nfwd,deflection,300,0,0,0,0.5,mm,0.02\n"
                                         "fwd,deflection,600,0,0,0,0.3,mm,0.02\nfwd,deflection,900,0,0,0,0.2,mm,0.02\n"
                                         "fwd,deflection,1200,0,0,0,0.1,mm,0.02\n"}});
}

// A fit of five linear residuals that ended `starts` times at one point.
analysis::FitResult fit_result(const std::vector<double>& unit, int starts, const Eigen::MatrixXd& sensitivity,
                               const Eigen::VectorXd& residuals) {
    const study::Study study = study_in_memory("uzan");
    problem::Problem problem =
        test::problem_of(3, test::Formula([=](const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& j) {
                             const Eigen::Map<const Eigen::VectorXd> at(unit.data(), 3);
                             r = residuals + sensitivity * (x - at);
                             j = sensitivity;
                         }),
                         std::vector<double>(5, 0.0), 1.0);
    landscape::Minimum minimum;
    minimum.unit = unit;
    const auto workspace = problem.function->make_workspace();
    minimum.evaluation = problem.evaluate(unit, true, *workspace);
    problem.space = study.space; // names of the study, coordinates of the formula
    minimum.evaluation.parameters = problem.space.physical(unit);
    minimum.converged = true;
    minimum.lowest = minimum.highest = minimum.evaluation.parameters;
    minimum.on_bound = landscape::bounds_met(unit);
    analysis::FitResult result{.study = study,
                               .options = {},
                               .problem = problem,
                               .design = {},
                               .searches = {},
                               .local = {},
                               .joint = {},
                               .alone = {},
                               .reduced = {},
                               .tally = {}};
    for (int s = 0; s < starts; ++s) {
        minimum.members.push_back(s);
        result.searches.ends.push_back({.start = s, .from = unit, .search = {}, .evaluation = minimum.evaluation});
    }
    result.local = landscape::analyse(minimum, problem);
    result.searches.minima.push_back(std::move(minimum));
    return result;
}

bool says(const std::vector<std::string>& text, std::string_view words) {
    return std::any_of(text.begin(), text.end(),
                       [&](const std::string& sentence) { return sentence.find(words) != std::string::npos; });
}

} // namespace

TEST(FindingsOfAFit, SayWhereTheSearchesEndedAndWhatTheDataDoNotSee) {
    Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(5, 3);
    seen.diagonal().setConstant(50.0);
    const Eigen::VectorXd small = Eigen::VectorXd::Constant(5, 0.5);
    const auto determined = findings(fit_result({0.5, 0.4, 0.3}, 4, seen, small));
    EXPECT_TRUE(says(determined, "4 of 4 starts ended in the best minimum"));
    EXPECT_TRUE(
        says(determined, "The fit is consistent with the stated noise: chi2 = 1.250 with 2 degrees of freedom"));
    EXPECT_FALSE(says(determined, "Not determined"));
    EXPECT_FALSE(says(determined, "bound"));

    Eigen::MatrixXd blind = seen;
    blind(1, 1) = 0.5; // crossing the box moves the data by half a standard deviation
    const auto loose = findings(fit_result({0.5, 0.4, 0.3}, 4, blind, small));
    EXPECT_TRUE(says(loose, "Not determined individually"));
    EXPECT_TRUE(says(loose, "base.k2"));

    EXPECT_TRUE(says(findings(fit_result({0.5, 1.0, 0.3}, 4, seen, small)), "base.k2 at its upper bound"));
    EXPECT_TRUE(says(findings(fit_result({0.5, 0.4, 0.3}, 1, seen, small)), "One search from one start"));
    EXPECT_TRUE(says(findings(fit_result({0.5, 0.4, 0.3}, 4, seen, Eigen::VectorXd::Constant(5, 4.0))),
                     "does not fit these data within their stated noise"));
}

TEST(CombinationsInWords, HaveTheStressesOfTheirLaw) {
    // ln k1 + ln(0.62) k2 + ln(1.5) k3: theta of 62 kPa; tau of 50 kPa in the octahedral law, a deviator of 150 kPa in
    // the one that is published.
    const landscape::Combination c{
        .leading = 0, .others = {{1, std::log(0.62)}, {2, std::log(1.5)}}, .standard_error = 0.02};
    EXPECT_EQ(analysis::combination_words(study_in_memory("uzan"), c),
              "base.k1 * (theta/pa)^base.k2 at theta = 62 kPa * (tau/pa + 1)^base.k3 at tau = 50 kPa is fixed to 2 %");
    EXPECT_EQ(analysis::combination_words(study_in_memory("uzan-deviator"), c),
              "base.k1 * (theta/pa)^base.k2 at theta = 62 kPa * (deviator/pa)^base.k3 at deviator = 150 kPa is fixed "
              "to 2 %");
}

TEST(EndsOfWalks, AreNamedByWhatStoppedThem) {
    const problem::Problem problem(study_in_memory("uzan").space, nullptr, {problem::MisfitKind::log, {}});
    using landscape::WalkEnd;
    EXPECT_EQ(analysis::end_words(problem, WalkEnd::threshold, {}, {}), "the data");
    EXPECT_EQ(analysis::end_words(problem, WalkEnd::threshold, {{1, true}}, {}),
              "the data, with base.k2 at its upper bound");
    EXPECT_EQ(analysis::end_words(problem, WalkEnd::bound, {{0, false}}, {}), "base.k1 at its lower bound");
    EXPECT_EQ(analysis::end_words(problem, WalkEnd::hole, {}, {}), "points without an answer");
}

TEST(Readings, OfOnePlaceShareTheirWordsAndOthersDoNot) {
    data::Reading r{.load = "fwd", .quantity = "strain_zz", .x_mm = 170, .depth_mm = 112.5};
    EXPECT_EQ(r.place_words(), "strain_zz 112.5 mm deep at 170 mm");
    EXPECT_EQ(r.label(), "fwd.strain_zz@170,0,112.5");
    data::Reading beside = r;
    beside.y_mm = 200;
    EXPECT_NE(r.place_words(), beside.place_words());
    data::Reading centre{.load = "fwd", .quantity = "deflection"};
    EXPECT_EQ(centre.words(), "deflection at 0 mm under fwd");
}
