// Engine, store and minima on analytic problems behind the same ForwardFunction.
#include "landscape/multistart.h"

#include "base/error.h"
#include "support/folder.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <mutex>
#include <numeric>

using namespace explore;

namespace {

// Two basins along the first axis: residuals (u0 - 0.2)(u0 - 0.8) scaled, tilted so that 0.2 is lower; exact answer
// missing in a corner.
class TwoBasins final : public problem::ForwardFunction {
public:
    mutable std::atomic<int> calls{0};

    std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
    pave::Outcome<problem::Prediction> evaluate(std::span<const double> p, bool with_jacobian,
                                                Workspace&) const override {
        ++calls;
        if (p[0] > 0.7 && p[1] > 0.7) {
            return pave::Failure{pave::Status::no_equilibrium, "a hole, \"on purpose\""};
        }
        problem::Prediction out;
        out.responses = {1.0 + 10.0 * (p[0] - 0.2) * (p[0] - 0.8), 1.0 + 0.3 * p[0], 1.0 + 2.0 * (p[1] - 0.4)};
        if (with_jacobian) {
            out.jacobian.resize(3, 2);
            out.jacobian << 10.0 * (2.0 * p[0] - 1.0), 0.0, 0.3, 0.0, 0.0, 2.0;
        }
        return out;
    }
};

problem::Problem two_basins(std::shared_ptr<TwoBasins> function = std::make_shared<TwoBasins>()) {
    return {{{{"a", 0, 1, problem::Scale::linear, 5, 0.5}, {"b", 0, 1, problem::Scale::linear, 5, 0.5}}},
            std::move(function),
            problem::Misfit(problem::MisfitKind::relative, {{0, 1.0}, {1, 1.0}, {2, 1.0}})};
}

std::string fresh_folder(const std::string& name) {
    const std::string folder = test::own_folder() + name;
    std::filesystem::remove_all(folder);
    return folder;
}

run::RunHeader header(const std::string& settings = "test") {
    run::RunHeader h;
    h.key = {"fit", "hash", settings};
    h.version = "0";
    h.parameters = {"a", "b"};
    h.responses = {"x", "y", "z"};
    h.response_to_si = {1, 1, 1};
    return h;
}

std::string table_of(const run::Store& store, int id) {
    std::string text;
    store.each(id, [&](run::RunNumber n, const problem::Evaluation& e) {
        text += std::to_string(n.start) + " " + std::to_string(n.number) + " " + std::string(to_string(e.status)) +
                " " + e.reason;
        for (const auto& list : {e.parameters, e.responses, {e.misfit}}) {
            for (const double v : list) {
                char digits[40];
                std::snprintf(digits, sizeof digits, " %a", v);
                text += digits;
            }
        }
        text += "\n";
    });
    return text;
}

} // namespace

TEST(Multistart, FindsBothMinimaAndCountsTheStartsOfEach) {
    const auto problem = two_basins();
    run::Engine engine(problem, nullptr, 0, {.threads = 2, .show_progress = false});
    const auto result = landscape::multistart(engine, problem, search::sobol(problem.space, 64, 1),
                                              {.starts = 10, .start_distance = 0.1});
    ASSERT_TRUE(result);
    ASSERT_EQ(result->minima.size(), 2U);
    EXPECT_NEAR(result->minima[0].evaluation.parameters[0], 0.2, 0.02);
    EXPECT_NEAR(result->minima[1].evaluation.parameters[0], 0.8, 0.02);
    EXPECT_LT(result->minima[0].evaluation.misfit, result->minima[1].evaluation.misfit);
    std::size_t members = 0;
    for (const auto& m : result->minima) {
        members += m.members.size();
        EXPECT_NEAR(m.evaluation.parameters[1], 0.4, 1e-3);
        EXPECT_TRUE(m.on_bound.empty());
    }
    EXPECT_EQ(members, result->ends.size());
    EXPECT_GT(result->explored.size(), 0U);
}

TEST(Multistart, NamesTheDirectionTheDataDoNotSee) {
    // Only a product of the two parameters is measured.
    class Product final : public problem::ForwardFunction {
        std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
        pave::Outcome<problem::Prediction> evaluate(std::span<const double> p, bool with_jacobian,
                                                    Workspace&) const override {
            problem::Prediction out;
            for (const double c : {1.0, 2.0, 3.0, 5.0}) {
                out.responses.push_back(c * p[0] * p[1] + 0.05 * c * c);
            }
            if (with_jacobian) {
                out.jacobian.resize(4, 2);
                out.jacobian << p[1], p[0], 2 * p[1], 2 * p[0], 3 * p[1], 3 * p[0], 5 * p[1], 5 * p[0];
            }
            return out;
        }
    };
    const problem::Problem problem{
        {{{"a", 0.1, 10, problem::Scale::log, 0, 1}, {"b", 0.1, 10, problem::Scale::log, 0, 1}}},
        std::make_shared<Product>(),
        problem::Misfit(problem::MisfitKind::relative, {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 5, 5}})};
    run::Engine engine(problem, nullptr, 0, {.threads = 2, .show_progress = false});
    const auto result = landscape::multistart(engine, problem, search::sobol(problem.space, 64, 1),
                                              {.starts = 8, .start_distance = 0.1});
    ASSERT_TRUE(result);
    ASSERT_EQ(result->minima.size(), 1U) << "a flat valley is one minimum whose members spread";
    EXPECT_GT(result->minima[0].highest[0] / result->minima[0].lowest[0], 3.0);
    const auto local = landscape::analyse(result->minima[0], problem);
    EXPECT_NEAR(std::abs(local.weakest[0]), std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(local.weakest[0], -local.weakest[1], 1e-6);
    EXPECT_LT(local.weakest_growth, 1e-9 * local.strongest_growth);
    EXPECT_TRUE(std::isinf(local.standard_error[0]));
}

// What is read fixes a function g of both parameters: a valley bends along p0 = 0.1 + 3 (p1 - 1/2)^2, and two solutions
// p0 = 0.2 and p0 = 0.8 with the same readings have a ridge between them.
TEST(Multistart, FollowsAValleyThatBendsAndLeavesApartWhatARidgeSeparates) {
    class Read final : public problem::ForwardFunction {
    public:
        explicit Read(bool bends) : bends_(bends) {}
        std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
        pave::Outcome<problem::Prediction> evaluate(std::span<const double> p, bool with_jacobian,
                                                    Workspace&) const override {
            const double g = bends_ ? p[0] - 3.0 * std::pow(p[1] - 0.5, 2) : (p[0] - 0.2) * (p[0] - 0.8) + 0.1;
            const double by_0 = bends_ ? 1.0 : 2.0 * p[0] - 1.0;
            const double by_1 = bends_ ? -6.0 * (p[1] - 0.5) : 0.0;
            problem::Prediction out;
            for (const double c : {1.0, 2.0, 3.0}) {
                out.responses.push_back(c * g);
                if (with_jacobian) {
                    out.jacobian.conservativeResize(static_cast<Eigen::Index>(out.responses.size()), 2);
                    out.jacobian.bottomRows(1) << c * by_0, c * by_1;
                }
            }
            return out;
        }

    private:
        bool bends_;
    };
    std::vector<problem::Misfit::Term> terms;
    for (const std::size_t i : {0U, 1U, 2U}) {
        const double measured = 0.1 * static_cast<double>(i + 1);
        terms.push_back({.response = i, .measured = measured, .scale = 0.01, .noise = {.absolute = 0.01}});
    }
    for (const bool bends : {true, false}) {
        const problem::Problem problem{
            {{{"a", 0, 1, problem::Scale::linear, 0, 0.5}, {"b", 0, 1, problem::Scale::linear, 0, 0.5}}},
            std::make_shared<Read>(bends),
            problem::Misfit(problem::MisfitKind::weighted, terms)};
        run::Engine engine(problem, nullptr, 0, {.threads = 2, .show_progress = false});
        const auto result = landscape::multistart(engine, problem, search::sobol(problem.space, 64, 1),
                                                  {.starts = 4, .start_distance = 0.3});
        ASSERT_TRUE(result);
        ASSERT_EQ(result->ends.size(), 4U);
        EXPECT_GT(landscape::distinct_minima(result->ends, problem).size(), 1U) << "the ends lie far apart";
        EXPECT_EQ(result->minima.size(), bends ? 1U : 2U);
        std::size_t members = 0;
        for (const auto& m : result->minima) {
            members += m.members.size();
        }
        EXPECT_EQ(members, 4U) << "searches between them are no starts";
    }
}

// A straight line fitted without weights to readings of unequal noise: (X'X)^-1 X'SX (X'X)^-1 (White 1980,
// Econometrica 48), and the same times chi2 / degrees of freedom where the noise does not explain the residual.
TEST(Minima, HaveTheErrorsThatTheStatedNoiseGivesThem) {
    static const std::vector<double> at{0.0, 0.2, 0.5, 0.6, 0.9, 1.0};
    class Line final : public problem::ForwardFunction {
        std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
        pave::Outcome<problem::Prediction> evaluate(std::span<const double> p, bool, Workspace&) const override {
            problem::Prediction out;
            out.jacobian.resize(static_cast<Eigen::Index>(at.size()), 2);
            for (std::size_t i = 0; i < at.size(); ++i) {
                out.responses.push_back(p[0] + p[1] * at[i]);
                out.jacobian.row(static_cast<Eigen::Index>(i)) << 1.0, at[i];
            }
            return out;
        }
    };
    Eigen::MatrixXd x(6, 2);
    Eigen::VectorXd sigma(6);
    sigma << 0.01, 0.02, 0.05, 0.01, 0.04, 0.03;
    const std::vector<double> gaps{0.01, -0.02, 0.03, 0.005, -0.03, 0.02};
    for (const double size : {1.0, 10.0}) {
        std::vector<problem::Misfit::Term> terms;
        Eigen::VectorXd y(6);
        for (std::size_t i = 0; i < at.size(); ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            x.row(row) << 1.0, at[i];
            y[row] = 1.0 + 2.0 * at[i] + size * gaps[i];
            terms.push_back({.response = i, .measured = y[row], .noise = {.absolute = sigma[row]}});
        }
        const problem::Problem problem{
            {{{"a", -5, 5, problem::Scale::linear, 0, 0}, {"b", -5, 5, problem::Scale::linear, 0, 0}}},
            std::make_shared<Line>(),
            problem::Misfit(problem::MisfitKind::weighted, terms)};
        run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
        const auto result = landscape::multistart(engine, problem, search::sobol(problem.space, 8, 1), {.starts = 2});
        ASSERT_TRUE(result);
        const auto local = landscape::analyse(result->minima[0], problem);
        const Eigen::MatrixXd inverse = (x.transpose() * x).inverse();
        const Eigen::VectorXd best = inverse * (x.transpose() * y);
        const double chi2 = (y - x * best).cwiseQuotient(sigma).squaredNorm();
        Eigen::MatrixXd covariance =
            inverse * x.transpose() * sigma.cwiseAbs2().asDiagonal() * x * inverse * (size > 1.0 ? chi2 / 4.0 : 1.0);
        EXPECT_EQ(local.widened, size > 1.0);
        EXPECT_NEAR(local.chi2, chi2, 1e-3 * chi2); // the search ends somewhere near the minimum
        for (int k = 0; k < 2; ++k) {
            EXPECT_NEAR(10.0 * local.standard_error[static_cast<std::size_t>(k)], std::sqrt(covariance(k, k)),
                        1e-3 * std::sqrt(covariance(k, k)));
        }
    }
}

TEST(Engine, GivesTheSameTableForAnyNumberOfThreads) {
    std::string first;
    for (const int threads : {1, 2, 4}) {
        const std::string folder = fresh_folder("threads" + std::to_string(threads));
        const auto problem = two_basins();
        run::Store store(folder, run::Session{});
        const int id = store.begin(header());
        run::Engine engine(problem, &store, id, {.threads = threads, .show_progress = false});
        ASSERT_TRUE(landscape::multistart(engine, problem, search::sobol(problem.space, 64, 1), {.starts = 6}));
        const std::string table = table_of(store, id);
        EXPECT_NE(table.find("no-equilibrium"), std::string::npos);
        first = first.empty() ? table : first;
        EXPECT_EQ(table, first) << threads;
        std::filesystem::remove_all(folder);
    }
}

TEST(Engine, ContinuesACutOffRunWithoutRepeatingAnything) {
    const std::string folder = fresh_folder("continue");
    const auto design = search::sobol(two_basins().space, 64, 1);
    const landscape::MultistartSettings settings{.starts = 6};
    std::string whole;
    int whole_calls = 0;
    {
        const auto function = std::make_shared<TwoBasins>();
        const auto problem = two_basins(function);
        run::Store store(folder, run::Session{});
        const int id = store.begin(header());
        run::Engine engine(problem, &store, id, {.threads = 2, .show_progress = false});
        ASSERT_TRUE(landscape::multistart(engine, problem, design, settings));
        whole = table_of(store, id);
        whole_calls = function->calls;
    }
    // Cut the run off: take away every third evaluation of the design and the second half of each search.
    int removed = 0;
    {
        SQLite::Database database(folder + "/run.sqlite", SQLite::OPEN_READWRITE);
        removed =
            database.exec("DELETE FROM evaluation WHERE (start < 0 AND number % 3 = 0) OR (start >= 0 AND number >= "
                          "(SELECT max(number) / 2 FROM evaluation AS other WHERE other.start = evaluation.start))");
    }
    EXPECT_GT(removed, 20);
    const auto function = std::make_shared<TwoBasins>();
    const auto problem = two_basins(function);
    run::Store store(folder, run::Session{});
    const int id = store.begin(header());
    run::Engine engine(problem, &store, id, {.threads = 2, .show_progress = false});
    ASSERT_TRUE(landscape::multistart(engine, problem, design, settings));
    EXPECT_EQ(table_of(store, id), whole);
    EXPECT_EQ(function->calls, removed);
    EXPECT_EQ(engine.tally().computed, removed);
    EXPECT_EQ(engine.tally().computed + engine.tally().kept, whole_calls);
    std::filesystem::remove_all(folder);
}

TEST(Engine, WithoutMemoryForOneRunEndsAndGoesOnLaterAsIfNothingHadHappened) {
    // Two basins, but one of its calls finds no memory.
    class Starved final : public problem::ForwardFunction {
    public:
        explicit Starved(int at) : left_(at) {}
        std::unique_ptr<Workspace> make_workspace() const override { return whole_.make_workspace(); }
        pave::Outcome<problem::Prediction> evaluate(std::span<const double> p, bool with_jacobian,
                                                    Workspace& workspace) const override {
            if (left_-- == 0) {
                throw std::bad_alloc();
            }
            return whole_.evaluate(p, with_jacobian, workspace);
        }

    private:
        TwoBasins whole_;
        mutable std::atomic<int> left_;
    };
    const landscape::MultistartSettings settings{.starts = 4};
    const auto design = search::sobol(two_basins().space, 32, 1);
    const auto table_after = [&](int starved_at) {
        const std::string folder = fresh_folder("starved");
        std::string table;
        for (const bool starved : {starved_at >= 0, false}) {
            problem::Problem problem = two_basins();
            if (starved) {
                problem.function = std::make_shared<Starved>(starved_at);
            }
            run::Store store(folder, run::Session{});
            const int id = store.begin(header());
            run::Engine engine(problem, &store, id, {.threads = 2, .show_progress = false});
            const auto go = [&] { return landscape::multistart(engine, problem, design, settings); };
            if (starved) {
                EXPECT_THROW(go(), std::bad_alloc);
            } else {
                EXPECT_TRUE(go());
            }
            table = table_of(store, id);
        }
        std::filesystem::remove_all(folder);
        return table;
    };
    const std::string whole = table_after(-1);
    EXPECT_EQ(table_after(7), whole);  // in the design
    EXPECT_EQ(table_after(34), whole); // in a search
}

// The same basins by a model that computes four points for the price of one.
class FourAtOnce final : public problem::ForwardFunction {
public:
    explicit FourAtOnce(int poisoned = -1) : poisoned_(poisoned) {}

    std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
    pave::Outcome<problem::Prediction> evaluate(std::span<const double> p, bool with_jacobian,
                                                Workspace& workspace) const override {
        return basins_.evaluate(p, with_jacobian, workspace);
    }
    std::vector<pave::Outcome<problem::Prediction>> evaluate_many(std::span<const std::vector<double>> points,
                                                                  bool with_jacobian,
                                                                  Workspace& workspace) const override {
        const std::scoped_lock lock(mutex_);
        sizes_.push_back(points.size());
        if (static_cast<int>(sizes_.size()) == poisoned_) {
            throw std::bad_alloc();
        }
        return ForwardFunction::evaluate_many(points, with_jacobian, workspace);
    }
    std::size_t lanes() const override { return 4; }
    std::vector<std::size_t> sizes() const { return sizes_; }

private:
    TwoBasins basins_;
    int poisoned_;
    mutable std::mutex mutex_;
    mutable std::vector<std::size_t> sizes_;
};

problem::Problem four_at_once(std::shared_ptr<FourAtOnce> function) {
    problem::Problem p = two_basins();
    p.function = std::move(function);
    return p;
}

// Chain i asks for i + 1 points, with derivatives at every third.
std::vector<std::vector<double>> misfits_of_chains(run::Engine& engine, std::size_t count) {
    std::vector<std::vector<double>> misfits(count);
    EXPECT_TRUE(engine.chains("", 0, count, [&](std::size_t i, run::Chain& chain) {
        double u = 0.05 * static_cast<double>(i);
        for (std::size_t k = 0; k <= i; ++k) {
            misfits[i].push_back(chain.at(std::vector{u, 0.3}, k % 3 == 2).misfit);
            u = 0.5 * (u + std::min(1.0, misfits[i].back()));
        }
    }));
    return misfits;
}

TEST(Engine, ComputesWhatChainsAskForTogether) {
    const auto function = std::make_shared<FourAtOnce>();
    run::Engine together(four_at_once(function), nullptr, 0, {.threads = 1, .show_progress = false});
    run::Engine one_by_one(two_basins(), nullptr, 0, {.threads = 1, .show_progress = false});
    const auto misfits = misfits_of_chains(together, 7);
    EXPECT_EQ(misfits, misfits_of_chains(one_by_one, 7));
    // Seven chains of 1 to 7 points on four threads: the first four go together until one of them ends.
    const auto sizes = function->sizes();
    EXPECT_EQ(sizes.front(), 4u);
    EXPECT_EQ(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}), 28u);
    EXPECT_LT(sizes.size(), 20u);
    run::Engine wider(four_at_once(function), nullptr, 0, {.threads = 3, .show_progress = false});
    EXPECT_EQ(misfits, misfits_of_chains(wider, 7));
}

TEST(Engine, ComputesAChainThatIsAlwaysByItselfPointByPoint) {
    const auto function = std::make_shared<FourAtOnce>();
    run::Engine engine(four_at_once(function), nullptr, 0, {.threads = 1, .show_progress = false});
    EXPECT_TRUE(engine.chain("", 0, [](run::Chain& chain) { chain.at(std::vector{0.1, 0.2}); }));
    EXPECT_TRUE(function->sizes().empty());
    misfits_of_chains(engine, 1); // that others might have gone with
    EXPECT_EQ(function->sizes(), std::vector<std::size_t>{1});
}

TEST(Engine, ChainsInStepEndWithWhatOneOfThemThrows) {
    const auto function = std::make_shared<FourAtOnce>(3);
    run::Engine engine(four_at_once(function), nullptr, 0, {.threads = 2, .show_progress = false});
    EXPECT_THROW(misfits_of_chains(engine, 9), std::bad_alloc);
    run::Engine other(four_at_once(std::make_shared<FourAtOnce>()), nullptr, 0, {.threads = 2, .show_progress = false});
    std::atomic<int> ended{0};
    EXPECT_THROW(other.chains("", 0, 6,
                              [&](std::size_t i, run::Chain& chain) {
                                  chain.at(std::vector{0.1 * static_cast<double>(i), 0.5});
                                  if (i == 2) {
                                      throw std::runtime_error("on purpose");
                                  }
                                  chain.at(std::vector{0.1 * static_cast<double>(i), 0.6});
                                  ++ended;
                              }),
                 std::runtime_error);
    EXPECT_EQ(ended, 5); // the others were under way
}

TEST(Store, KeepsRunsWithOtherSettingsApart) {
    const std::string folder = fresh_folder("apart");
    run::Store store(folder, run::Session{});
    const int one = store.begin(header("one"));
    const int two = store.begin(header("two"));
    EXPECT_NE(one, two);
    problem::Evaluation e;
    e.parameters = {1.0, 2.0};
    e.reason = "because";
    store.put(one, {-1, 0}, e);
    EXPECT_TRUE(table_of(store, two).empty());
    EXPECT_EQ(store.runs().front().id, two);
    EXPECT_EQ(store.begin(header("one")), one);
    EXPECT_EQ(store.runs().front().id, one);
    EXPECT_EQ(store.runs().size(), 2U);
    std::filesystem::remove_all(folder);
}

TEST(Store, SaysWhatEachProcessComputed) {
    const std::string folder = fresh_folder("sessions");
    problem::Evaluation e;
    e.parameters = {1.0, 2.0};
    for (const int computed : {3, 0, 5}) { // the second finds all in the store
        run::Store store(folder, run::Session{.version = "v", .arguments = {"fit", "a \"b\".toml"}, .threads = 2});
        const int id = store.begin(header());
        for (int i = 0; i < computed; ++i) {
            store.put(id, {-1, i}, e);
        }
    }
    const auto sessions = run::Store(folder).sessions();
    ASSERT_EQ(sessions.size(), 2U);
    EXPECT_EQ(sessions[0].evaluations, 3);
    EXPECT_EQ(sessions[1].evaluations, 5);
    EXPECT_EQ(sessions[0].arguments[1], "a \"b\".toml");
    EXPECT_EQ(sessions[0].threads, 2);
    EXPECT_EQ(sessions[0].version, "v");
    EXPECT_GT(sessions[0].seconds, 0.0);
    EXPECT_EQ(sessions[0].began.size(), std::string("2026-01-01T00:00:00Z").size());
    std::filesystem::remove_all(folder);
}

TEST(Store, RefusesAFileThatIsNotAStoreAndOneOfAnotherVersion) {
    const std::string folder = fresh_folder("foreign");
    std::filesystem::create_directories(folder);
    {
        std::ofstream stream(folder + "/run.sqlite");
        stream << std::string(5000, 'x');
    }
    EXPECT_THROW(run::Store(folder, run::Session{}), pave::Error);
    std::filesystem::remove(folder + "/run.sqlite");
    { const run::Store store(folder, run::Session{}); }
    {
        SQLite::Database database(folder + "/run.sqlite", SQLite::OPEN_READWRITE);
        database.exec("PRAGMA user_version = 999");
    }
    EXPECT_THROW(run::Store(folder, run::Session{}), pave::Error);
    EXPECT_THROW(run::Store(folder + "/nowhere"), pave::Error);
    std::filesystem::remove_all(folder);
}

TEST(DistinctStarts, AreTheLowestPointsThatAreNotNearEachOther) {
    const auto problem = two_basins();
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const auto design = search::full_grid(problem.space);
    const auto evaluations = engine.evaluate(design);
    const auto starts = run::distinct_starts(design, *evaluations, 4, 0.4);
    ASSERT_EQ(starts.size(), 4U);
    for (std::size_t i = 0; i < starts.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const double d0 = design.points[starts[i]][0] - design.points[starts[j]][0];
            const double d1 = design.points[starts[i]][1] - design.points[starts[j]][1];
            EXPECT_GE(std::hypot(d0, d1), 0.4);
            EXPECT_GE((*evaluations)[starts[i]].misfit, (*evaluations)[starts[j]].misfit);
        }
    }
}
