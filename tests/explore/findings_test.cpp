// What results say in sentences: constructed results, the sentences that they must give.
#include "analysis/compare/compare.h"
#include "analysis/diagnose/diagnose.h"
#include "analysis/fit/fit.h"
#include "analysis/sample/sample.h"
#include "analysis/unique/unique.h"
#include "material/catalog.h"
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
                               .without_floor = {},
                               .mesh = {},
                               .drifts = {},
                               .priors = {},
                               .curves = {},
                               .tally = {}};
    for (int s = 0; s < starts; ++s) {
        minimum.members.push_back(s);
        result.searches.ends.push_back({.start = s, .from = unit, .search = {}, .evaluation = minimum.evaluation});
    }
    result.local = landscape::analyse(minimum, problem);
    result.searches.minima.push_back(std::move(minimum));
    return result;
}

// Of the same fit, whose searches found nothing else.
analysis::UniqueResult unique_result(const analysis::FitResult& fit, landscape::Verdict verdict) {
    landscape::Uniqueness answer;
    answer.verdict = verdict;
    answer.minima = fit.searches.minima;
    answer.acceptance =
        landscape::Acceptance{.noise_is_stated = true, .degrees_of_freedom = 2, .threshold = 3.84, .chi2 = 1.25};
    answer.unseen = {.starts = 24, .since_new = 24, .volume_bound = 0.117};
    return {.study = fit.study,
            .options = {},
            .problem = fit.problem,
            .answer = std::move(answer),
            .next = {},
            .landscape = {},
            .mesh = {},
            .outputs = {},
            .posterior = {},
            .reduced = {},
            .curves = {}};
}

analysis::FitResult determined_fit(const std::vector<double>& unit) {
    Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(5, 3);
    seen.diagonal().setConstant(50.0);
    return fit_result(unit, 4, seen, Eigen::VectorXd::Constant(5, 0.5));
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

TEST(FindingsOfUnique, SayTheVerdictWithWhatTakesItBack) {
    using landscape::Verdict;
    auto result = unique_result(determined_fit({0.5, 0.4, 0.3}), Verdict::unique);
    auto text = findings(result);
    EXPECT_EQ(text[0],
              "UNIQUE within what was searched: one set of parameters, with the ranges below, fits these data.");
    EXPECT_TRUE(says(text, "24 independent starts in a row found no minimum"));
    EXPECT_TRUE(says(text, "less than 12 % of the box"));
    EXPECT_FALSE(says(text, "anywhere from"));

    result.answer.parameters.resize(3);
    for (std::size_t k = 0; k < 3; ++k) {
        result.answer.parameters[k].low = result.problem.space.axes[k].physical(k == 0 ? 0.0 : 0.25);
        result.answer.parameters[k].high = result.problem.space.axes[k].physical(k == 0 ? 1.0 : 0.5);
    }
    text = findings(result);
    EXPECT_TRUE(says(text, "The data accept base.k1 anywhere from 300.0 to 12000, if the others follow."));

    result.answer.acceptance->widened = true;
    result.answer.acceptance->p_value = 0.0012;
    text = findings(result);
    EXPECT_EQ(text[0].find("UNIQUE, but the data contradict the model (p = 0.0012)"), 0);
    EXPECT_TRUE(
        says(text, "does not fit these data within their stated noise (chi2 = 1.250 with 2 degrees of freedom"));

    EXPECT_TRUE(says(findings(unique_result(determined_fit({0.5, 1.0, 0.3}), Verdict::unique)),
                     "limited by the bound: base.k2 at its upper bound. Widen it"));
}

TEST(FindingsOfUnique, TellValleysFromAlternativesAndSayWhatIsMissing) {
    auto result = unique_result(determined_fit({0.5, 0.4, 0.3}), landscape::Verdict::non_unique);
    result.answer.valley = true;
    EXPECT_EQ(findings(result)[0], "NON-UNIQUE: a continuous valley of parameter sets fits these data equally well.");
    result.answer.alternatives = true;
    EXPECT_EQ(findings(result)[0],
              "NON-UNIQUE: separate minima fit these data, and a continuous valley of parameter sets too.");
    result.answer.valley = false;
    EXPECT_EQ(findings(result)[0],
              "NON-UNIQUE: separate minima fit these data, with no acceptable way found between them.");
    result.answer.acceptance->widened = true;
    result.answer.acceptance->p_value = 0.0001;
    EXPECT_TRUE(says(findings(result), "NON-UNIQUE, and the data contradict the model (p = 0.0001): separate minima"));
    result.answer.acceptance->widened = false;
    result.answer.verdict = landscape::Verdict::undecided;
    result.answer.missing = {"more searches"};
    EXPECT_EQ(findings(result)[0], "UNDECIDED. What is missing: more searches.");
}

TEST(FindingsOfADiagnosis, SayWhatIsKnownOfPlacesBesideEachOther) {
    using analysis::LocatedPlace;
    analysis::LocatedCorrection found;
    found.correction.channel = pave::pavement::Channel::depth;
    found.correction.layer = "base";
    found.places = {
        LocatedPlace{.at = 0.0, .value = 2.0, .low = 0.8, .high = 5.0, .modulus = 0.0, .variance_left = 0.3},
        LocatedPlace{.at = 300.0, .value = 0.6, .low = 0.3, .high = 1.2, .modulus = 0.0, .variance_left = 0.1}};
    EXPECT_TRUE(found.says_where() == diagnose::Says::nothing);
    EXPECT_EQ(words_of(found), std::vector<std::string>{"These readings hardly constrain it between 0 and 300 mm."});
    found.contrast = {.place = 1, .beside = 0, .value = 0.3, .low = 0.25, .high = 0.36};
    EXPECT_TRUE(found.says_where() == diagnose::Says::between_places);
    EXPECT_EQ(words_of(found)[0], "Beside the study's model the base has around 300 mm below its top 25 to 36 % of the "
                                  "modulus that it has around 0 mm; which of the two is off is not known.");
    found.places[1].high = 0.9; // one of them is known for itself
    EXPECT_TRUE(found.says_where() == diagnose::Says::at_places);
    EXPECT_TRUE(words_of(found)[0].starts_with("Around 300 mm below its top the base has 30 to 90 %"));
    EXPECT_FALSE(found.places[1].seen()); // a band of a factor of three
    found.places[1].low = 0.5;
    EXPECT_TRUE(found.places[1].seen());
}

TEST(FindingsOfADiagnosis, SayTheVerdictAndTheNoise) {
    const study::Study study = study_in_memory("uzan");
    analysis::DiagnoseResult result{.study = study,
                                    .options = {},
                                    .variants = {},
                                    .candidates = {},
                                    .corrections = {},
                                    .channels = {},
                                    .layout = {},
                                    .diagnosis = {},
                                    .before = {},
                                    .after = {},
                                    .mesh = {},
                                    .outputs = {},
                                    .located = {},
                                    .next = {},
                                    .telling = {},
                                    .held_out = {},
                                    .reduced = {},
                                    .tally = {}};
    result.before = analysis::DiagnosedModel{.study = study, .evaluation = {}, .parameters = {}, .held_out_rms = {}};
    result.diagnosis.baseline.chi2 = 1.25;
    result.diagnosis.baseline.dof = 2;
    result.diagnosis.baseline.p_value = 0.54;
    auto text = findings(result);
    EXPECT_EQ(text[0], "ADEQUATE: nothing in these data contradicts the model beyond their noise.");
    EXPECT_TRUE(says(text, "leaves chi2 = 1.250 with 2 degrees of freedom: the stated noise explains that (p = 0.54)"));

    result.diagnosis.decision.verdict = diagnose::Verdict::ambiguous;
    result.diagnosis.decision.reason = diagnose::Reason::several_names;
    result.diagnosis.baseline.chi2 = 40.0;
    result.diagnosis.baseline.p_value = 1e-9;
    result.diagnosis.extended.emplace();
    const diagnose::Row extended{.hypothesis = {.kind = hypotheses::Kind::effect, .name = "load-magnitude"}};
    result.diagnosis.ledger.add(extended);
    result.diagnosis.decision.model = 0;
    for (const std::string effect : {"load-magnitude", "plate-rigidity"}) {
        diagnose::Candidate candidate;
        candidate.effect = effect;
        result.diagnosis.explanations.emplace_back().fit.model.members = {result.candidates.size()};
        result.candidates.push_back(std::move(candidate));
    }
    text = findings(result);
    EXPECT_EQ(text[0], "AMBIGUOUS: the model lacks something, and 2 explanations fit these data about equally "
                       "well; the readings cannot tell them apart: load-magnitude; plate-rigidity.");
    EXPECT_TRUE(says(text, "noise as stated alone makes as much with probability less than 1 in 10,000"));

    result.before->parameters.assign(study.space.axes.size(), {});
    result.after = result.before;
    const std::string warning = "What is left out of the fit speaks against it";
    result.diagnosis.places = diagnose::HeldOut{.before = 2.0, .after = 1.1, .readings = 5, .folds = {}};
    EXPECT_FALSE(says(findings(result), warning));
    using Predicted = diagnose::Ledger::Predicted;
    const std::string key = extended.hypothesis.key();
    const diagnose::Ledger ledger = result.diagnosis.ledger;
    result.diagnosis.ledger.add(Predicted{key, 2.0, 1.1, false}); // place by place
    result.diagnosis.ledger.add(Predicted{key, 0.8, 0.8, true});  // what the study holds out
    EXPECT_FALSE(says(findings(result), warning));
    result.diagnosis.ledger.add(Predicted{key, 0.8, 0.9, true}); // better elsewhere does not make up for it
    EXPECT_TRUE(says(findings(result), warning));
    result.diagnosis.ledger = ledger;
    result.diagnosis.ledger.add(Predicted{key, 2.0, 2.2, false});
    EXPECT_TRUE(says(findings(result), warning));
    result.diagnosis.decision.verdict = diagnose::Verdict::unexplained; // which claims nothing
    EXPECT_FALSE(says(findings(result), warning));
}

TEST(FindingsOfAComparison, NameTheLawThatTheDataPreferOrSayThatTheyDoNot) {
    const study::Study study = study_in_memory("uzan");
    analysis::CompareResult result{.study = study, .layer = "base", .laws = {}};
    for (const std::string name : {"uzan", "k-theta"}) {
        const bool first = name == "uzan";
        result.laws.push_back({.law = pave::material::find_law(name),
                               .study = study,
                               .p_value = first ? 0.4 : 0.001,
                               .aicc = first ? 10.0 : 22.0,
                               .weight = first ? 0.9975 : 0.0025});
    }
    auto text = findings(result);
    EXPECT_EQ(text[0], "In \"base\" the data prefer uzan: the AICc of the next best, k-theta, is 12.00 higher.");
    EXPECT_TRUE(says(text, "Within the stated noise fit: uzan."));

    result.laws[0].weight = 0.6;
    result.laws[1].weight = 0.4;
    result.laws[0].p_value = 0.01;
    text = findings(result);
    EXPECT_EQ(text[0], "The data cannot tell these laws in \"base\" apart: uzan, k-theta.");
    EXPECT_TRUE(says(text, "None fits within the stated noise"));

    result.laws[0].failed = "no equilibrium";
    EXPECT_EQ(findings(result), std::vector<std::string>{"No law has an answer."});
}

TEST(FindingsOfASample, BeginWithTheRangesAndSayWhatABoundCutsOff) {
    const auto fit = determined_fit({0.5, 0.4, 0.3});
    analysis::SampleResult result{.study = fit.study, .options = {}, .problem = fit.problem, .posterior = {}};
    result.status = analysis::SampleStatus::converged;
    result.posterior.answered = 1.0;
    constexpr int draws = 200;
    for (int i = 0; i < draws; ++i) {
        // In the middle; crowded at the lower bound; all over the range, in another order.
        const double at = (i + 0.5) / draws;
        const double other = ((37 * i) % draws + 0.5) / draws;
        analysis::SampledDraw draw;
        draw.unit = {0.45 + 0.1 * at, std::pow(((61 * i) % draws + 0.5) / draws, 6), other};
        result.draws.push_back(std::move(draw));
        result.descent.weight.push_back(1.0);
        result.descent.population.push_back(i % 2);
        result.descent.ancestor.push_back(i);
    }
    result.parameters = {{.q025 = 1500.0, .q50 = 1900.0, .q975 = 2400.0},
                         {.q025 = 0.0, .q50 = 0.004, .q975 = 0.8},
                         {.q025 = -1.95, .q50 = -1.0, .q975 = -0.05}};
    const auto text = findings(result);
    EXPECT_EQ(
        text[0],
        "The readings determine base.k1; of base.k2, base.k3 half of what the study allows or more lies in the 95 % "
        "ranges.");
    EXPECT_TRUE(says(text, "base.k2 is cut off at its lower bound 0: 52 % of the draws lie within 2 % of the range"));
    EXPECT_TRUE(says(text, "The data hardly constrain base.k3 alone"));
    EXPECT_FALSE(says(text, "base.k1 is cut off"));

    result.status = analysis::SampleStatus::not_converged;
    result.missing = {"R-hat of base.k2 is 1.300"};
    EXPECT_EQ(findings(result)[0],
              "NOT CONVERGED: no quantile is given. What is missing: R-hat of base.k2 is 1.300. More "
              "draws (--samples) may do.");
}

TEST(CombinationsInWords, HaveTheStressesOfTheirLaw) {
    // ln k1 + ln(0.62) k2 + ln(1.5) k3: theta of 62 kPa; tau of 50 kPa in the octahedral law, a deviator of 150 kPa in
    // the one that is published.
    const landscape::Combination c{
        .leading = 0, .others = {{1, std::log(0.62)}, {2, std::log(1.5)}}, .standard_error = 0.02};
    EXPECT_EQ(analysis::combination_words(study_in_memory("uzan"), c, {0.5, 0.5, 0.5}),
              "base.k1 * (theta/pa)^base.k2 at theta = 62 kPa * (tau/pa + 1)^base.k3 at tau = 50 kPa is fixed to 2 %");
    EXPECT_EQ(analysis::combination_words(study_in_memory("uzan-deviator"), c, {0.5, 0.5, 0.5}),
              "base.k1 * (theta/pa)^base.k2 at theta = 62 kPa * (deviator/pa)^base.k3 at deviator = 150 kPa is fixed "
              "to 2 %");
}

TEST(DataInConflict, AreSaidToDifferInWhatMattersHoweverManyPartsAreAlike) {
    problem::ParameterSpace space;
    for (int k = 0; k < 12; ++k) {
        space.axes.push_back({.name = "p" + std::to_string(k), .low = 0.0, .high = 1.0});
    }
    Eigen::VectorXd alike = Eigen::VectorXd::Constant(12, 1.0);
    alike[1] = -1.0;
    const std::string words = analysis::conflict_words(space, alike.normalized());
    EXPECT_TRUE(words.starts_with("higher p0, lower p1, higher p2,")) << words;
    EXPECT_TRUE(words.ends_with("higher p11")) << words;
    EXPECT_EQ(analysis::conflict_words(space, Eigen::VectorXd::Unit(12, 3)), "higher p3");
    EXPECT_EQ(analysis::conflict_words(space, {}), "");
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
    data::Reading r{.load = "fwd", .quantity = "strain_zz", .x_mm = 170, .depth_mm = 112.5, .sigma = {}, .file = ""};
    EXPECT_EQ(r.place_words(), "strain_zz 112.5 mm deep at 170 mm");
    EXPECT_EQ(r.label(), "fwd.strain_zz@170,0,112.5");
    data::Reading beside = r;
    beside.y_mm = 200;
    EXPECT_NE(r.place_words(), beside.place_words());
    data::Reading centre{.load = "fwd", .quantity = "deflection", .sigma = {}, .file = ""};
    EXPECT_EQ(centre.words(), "deflection at 0 mm under fwd");
}
