// The iterative solvers against dense factorisations, and the solid element against a uniform state.
#include "base/random.h"
#include "fe/gmres.h"
#include "fe/lanes/kernels.h"
#include "fe/symmetric_system.h"
#include "support/sections.h"

#include <gtest/gtest.h>
#include <optional>

using namespace test;

namespace {

// A stiff chain with random springs to neighbours near and far: symmetric positive definite, sparse. spread: of the
// logarithm of their stiffness.
struct Springs {
    fe::Pattern lower;
    std::vector<double> values;
    Eigen::MatrixXd dense;
};

Springs springs(int n, std::uint64_t stream, double spread = 2.0) {
    const RandomStream random(7, stream);
    Springs s;
    s.dense = Eigen::MatrixXd::Zero(n, n);
    std::uint64_t draw = 0;
    for (int i = 0; i < n; ++i) {
        s.dense(i, i) += 0.01;
        for (const int gap : {1, 2, 17}) {
            const int j = i + gap;
            if (j < n) {
                const double k = std::exp(spread * random.normal(draw++));
                s.dense(i, i) += k;
                s.dense(j, j) += k;
                s.dense(i, j) -= k;
                s.dense(j, i) -= k;
            }
        }
    }
    s.lower.size = n;
    s.lower.column_start = {0};
    for (int j = 0; j < n; ++j) {
        for (int i = j; i < n; ++i) {
            if (s.dense(i, j) != 0.0) {
                s.lower.row.push_back(i);
                s.values.push_back(s.dense(i, j));
            }
        }
        s.lower.column_start.push_back(static_cast<int>(s.lower.row.size()));
    }
    return s;
}

Eigen::MatrixXd random_matrix(int rows, int columns, std::uint64_t stream) {
    const RandomStream random(11, stream);
    Eigen::MatrixXd m(rows, columns);
    for (Eigen::Index k = 0; k < m.size(); ++k) {
        m.data()[k] = random.normal(static_cast<std::uint64_t>(k));
    }
    return m;
}

} // namespace

TEST(SymmetricSystem, SolvesAnyNumberOfColumnsWithAFactorOfAnotherMatrix) {
    const int n = 300;
    const Springs first = springs(n, 0);
    const Springs second = springs(n, 1);
    ASSERT_EQ(first.lower.row, second.lower.row);
    const std::vector<bool> constant(n, true);
    const fe::CholeskyAnalysis analysis(first.lower, constant);
    const auto check = [&](auto system, bool constants_hold) {
        for (const int columns : {1, 2, 3, 4, 5, 8, 9, 13}) {
            system.begin(1e-12, constants_hold);
            ASSERT_TRUE(system.set_matrix(first.values));
            Eigen::MatrixXd near = random_matrix(n, columns, 2);
            ASSERT_TRUE(system.solve(near, {}));
            ASSERT_TRUE(system.set_matrix(second.values));
            const Eigen::MatrixXd b = random_matrix(n, columns, 3);
            Eigen::MatrixXd x = b;
            const Eigen::Map<const Eigen::MatrixXd> guess(near.data(), n, columns);
            ASSERT_TRUE(system.solve(x, std::span(&guess, 1)));
            const Eigen::MatrixXd exact = second.dense.llt().solve(b);
            for (int c = 0; c < columns; ++c) {
                EXPECT_LT((x - exact).col(c).norm(), 1e-8 * exact.col(c).norm()) << columns << " columns, column " << c;
            }
        }
    };
    check(fe::SymmetricSystem<float>(first.lower, analysis), false);
    check(fe::SymmetricSystem<double>(first.lower, analysis), false); // no column is constant after all
}

TEST(SymmetricSystem, KeepsWhatTheConstantColumnsLeave) {
    // The second matrix differs in the springs between the unknowns from 180 on only.
    const int n = 300;
    const int first_changing = 180;
    const Springs first = springs(n, 0);
    Springs second = springs(n, 0);
    for (int j = first_changing; j < n; ++j) {
        for (int k = first.lower.column_start[j]; k < first.lower.column_start[j + 1]; ++k) {
            second.values[k] *= 3.0 + j % 5;
            const int i = first.lower.row[k];
            second.dense(i, j) = second.dense(j, i) = second.values[k];
        }
    }
    for (int i = first_changing; i < n; ++i) { // stay definite
        second.values[first.lower.column_start[i]] *= 4.0;
        second.dense(i, i) *= 4.0;
    }
    std::vector<bool> constant(n, false);
    std::fill_n(constant.begin(), first_changing, true);
    const Eigen::VectorXd b = random_matrix(n, 1, 3);
    const Eigen::VectorXd exact = second.dense.llt().solve(b);
    std::vector<bool> some(n, false); // others are constant, too, and lie among what changes
    std::fill_n(some.begin(), first_changing / 2, true);
    for (const std::vector<bool>& eliminated_first : {std::vector<bool>(), constant, some}) {
        const fe::CholeskyAnalysis analysis(first.lower, constant, eliminated_first);
        std::size_t kept = 0;
        for (const auto& node : analysis.structure().supernodes) {
            kept += node.is_constant ? 1 : 0;
        }
        EXPECT_GT(kept, 0U);
        fe::SymmetricSystem<double> system(first.lower, analysis);
        system.begin(1e-12, true);
        ASSERT_TRUE(system.set_matrix(first.values));
        ASSERT_TRUE(system.set_matrix(second.values));
        Eigen::MatrixXd x = b;
        ASSERT_TRUE(system.solve(x, {}));
        EXPECT_LT((x - exact).norm(), 1e-10 * exact.norm());
        EXPECT_EQ(system.factorizations(), 2);
    }
}

TEST(SymmetricSystem, StartsFromTheAnswerWhenAGuessHoldsIt) {
    const int n = 200;
    const Springs s = springs(n, 4);
    const fe::CholeskyAnalysis analysis(s.lower, std::vector<bool>(s.lower.size, false));
    fe::SymmetricSystem<float> system(s.lower, analysis);
    system.begin(1e-9, false);
    ASSERT_TRUE(system.set_matrix(springs(n, 7).values)); // the factor is of another matrix
    ASSERT_TRUE(system.set_matrix(s.values));
    const Eigen::MatrixXd b = random_matrix(n, 3, 5);
    const Eigen::MatrixXd exact = s.dense.llt().solve(b);
    const Eigen::MatrixXd other = random_matrix(n, 3, 6);
    const std::vector<Eigen::Map<const Eigen::MatrixXd>> guesses{{other.data(), n, 3}, {exact.data(), n, 3}};
    Eigen::MatrixXd x = b;
    ASSERT_TRUE(system.solve(x, guesses));
    EXPECT_EQ(system.iterations(), 0);
    EXPECT_LT((x - exact).norm(), 1e-8 * exact.norm());
}

// Springs that differ by fourteen decades: what holds many an unknown is beyond the seven digits of single precision.
TEST(SymmetricSystem, SolvesWhatSinglePrecisionCannotCarry) {
    const int n = 300;
    const Springs s = springs(n, 9, 8.0);
    const fe::CholeskyAnalysis analysis(s.lower, std::vector<bool>(n, false));
    fe::SymmetricSystem<float> system(s.lower, analysis);
    for (int turn = 0; turn < 2; ++turn) { // what came before has no influence
        system.begin(1e-8, false);
        for (int matrix = 0; matrix < 2; ++matrix) { // the second by the factor of the first
            ASSERT_TRUE(system.set_matrix(s.values));
            for (const int columns : {1, 3}) {
                const Eigen::MatrixXd exact = random_matrix(n, columns, 21);
                Eigen::MatrixXd x = s.dense * exact;
                ASSERT_TRUE(system.solve(x, {}));
                for (int c = 0; c < columns; ++c) {
                    const Eigen::VectorXd wrong = x.col(c) - exact.col(c);
                    EXPECT_LT(wrong.dot(s.dense * wrong), 1e-14 * exact.col(c).dot(s.dense * exact.col(c))) << columns;
                }
            }
        }
    }
}

TEST(SymmetricSystem, SaysWhenAMatrixIsNotPositiveDefinite) {
    Springs s = springs(50, 8);
    const fe::CholeskyAnalysis analysis(s.lower, std::vector<bool>(s.lower.size, false));
    fe::SymmetricSystem<float> system(s.lower, analysis);
    system.begin(1e-9, false);
    ASSERT_TRUE(system.set_matrix(s.values));
    std::vector<double> negative = s.values;
    for (double& v : negative) {
        v = -v;
    }
    ASSERT_TRUE(system.set_matrix(negative)); // not known yet: the factor of the one before serves
    Eigen::MatrixXd x = random_matrix(50, 1, 9);
    EXPECT_FALSE(system.solve(x, {}));
    system.begin(1e-9, false);
    EXPECT_FALSE(system.set_matrix(negative));
}

// Fronts of all sizes: supernodes of a chain, and one dense matrix with more columns than a panel has.
TEST(SupernodalFactor, IsThatOfADenseMatrixWithTheSameBitsInEveryWidth) {
    const fe::lanes::Kernels* list[8];
    const std::span all(list, static_cast<std::size_t>(fe::lanes::usable_kernels(list, 8)));
    for (const int n : {1, 3, 8, 50, 143, 300}) {
        Springs s = springs(n, 21);
        if (n == 143) {
            const Eigen::MatrixXd root = random_matrix(n, n, 22);
            s.dense = root * root.transpose() + Eigen::MatrixXd::Identity(n, n);
            s.lower = {.size = n, .column_start = {0}, .row = {}};
            s.values.clear();
            for (int j = 0; j < n; ++j) {
                for (int i = j; i < n; ++i) {
                    s.lower.row.push_back(i);
                    s.values.push_back(s.dense(i, j));
                }
                s.lower.column_start.push_back(static_cast<int>(s.lower.row.size()));
            }
        }
        const fe::CholeskyAnalysis analysis(s.lower, std::vector<bool>(static_cast<std::size_t>(n), false));
        const fe::Block<fe::lanes::right_sides> b = random_matrix(n, fe::lanes::right_sides, 23);
        const Eigen::MatrixXd exact = s.dense.llt().solve(b);
        std::optional<fe::Block<fe::lanes::right_sides>> known[2]; // with fused multiplication, and without
        for (const fe::lanes::Kernels* kernels : all) {
            fe::SupernodalFactor<double> factor(s.lower, analysis.structure(), kernels);
            for (int repeat = 0; repeat < 2; ++repeat) { // what the first one left in the memory is of no account
                ASSERT_TRUE(factor.factorize(s.values, true));
            }
            fe::Block<fe::lanes::right_sides> x = b;
            factor.solve<fe::lanes::right_sides>(x);
            EXPECT_LT((x - exact).norm(), 1e-10 * exact.norm()) << n << " unknowns, " << kernels->instructions;
            auto& same = known[kernels->rounds_once ? 1 : 0];
            if (same) {
                EXPECT_TRUE(x == *same) << n << " unknowns, " << kernels->instructions;
            }
            same = x;
            fe::Block<1> one = b.col(3); // which has loops of its own
            factor.solve<1>(one);
            EXPECT_LT((one - exact.col(3)).norm(), 1e-10 * exact.col(3).norm()) << n << " unknowns";
            std::vector<double> indefinite = s.values;
            indefinite.back() -= 2.0 / s.dense.inverse()(n - 1, n - 1); // what is left of it at last changes its sign
            EXPECT_FALSE(factor.factorize(indefinite, true));
        }
    }
}

TEST(Gmres, SolvesAnUnsymmetricSystemWithARoughPreconditioner) {
    const int n = 80;
    const Eigen::MatrixXd a = Eigen::MatrixXd::Identity(n, n) * 10.0 + random_matrix(n, n, 12);
    const Eigen::MatrixXf rough = Eigen::MatrixXd(a.inverse() + 0.01 * random_matrix(n, n, 13)).cast<float>();
    const Eigen::VectorXd b = random_matrix(n, 1, 14);
    Eigen::VectorXd x = b;
    const int steps = fe::gmres(
        x, [&](const Eigen::VectorXd& v) { return Eigen::VectorXd(a * v); },
        [&](const Eigen::VectorXd& v) { return Eigen::VectorXd((rough * v.cast<float>()).cast<double>()); }, 1e-12, n);
    EXPECT_GT(steps, 0);
    EXPECT_LT((a * x - b).norm(), 2e-12 * b.norm());
    Eigen::VectorXd y = b;
    EXPECT_EQ(fe::gmres(
                  y, [&](const Eigen::VectorXd& v) { return Eigen::VectorXd(a * v); },
                  [](const Eigen::VectorXd& v) { return v; }, 1e-12, 2),
              -1);
}

// Pressure on the whole surface between smooth walls: every layer is strained alike everywhere, p (1 + nu)(1 - 2 nu) /
// (E (1 - nu)), and the elements must hold that state exactly.
TEST(Hex20, HoldsAUniformStateExactly) {
    Case c;
    c.layers = {linear_layer("top", 0.1, 1000e6, 0.3), linear_layer("bottom", 0.5, 50e6, 0.4)};
    c.loads = {dual_wheel(30e3, 500e3)};
    c.settings.extent = 1.0;
    c.settings.solver.linear_tolerance = 1e-13;
    c.sensors = {
        deflection(0.0), strain_zz(0.05, 0.0), strain_zz(0.3, 0.2, 0.4), {0, Quantity::stress_xx, 0.3, 0.2, 0.3, 0.0}};
    const auto parts = parts_of<Solid>(c, 0);
    Load everywhere = c.loads[0];
    everywhere.type = LoadType::wheel;
    everywhere.patch_width = 2.0;
    everywhere.force = 4.0 * everywhere.pressure;
    const Eigen::VectorXd load = everywhere.pressure * Solid::unit_load(parts.mesh, parts.model, everywhere);
    fe::Solver<fe::Hex20> solver(parts.model);
    const auto solved = solver.incremental(parts.layers, load, {}, c.settings.solver);
    ASSERT_TRUE(solved);
    const auto strain = [&](double e, double nu) { return 500e3 * (1 + nu) * (1 - 2 * nu) / (e * (1 - nu)); };
    const double exact[] = {0.1 * strain(1000e6, 0.3) + 0.5 * strain(50e6, 0.4), strain(1000e6, 0.3), strain(50e6, 0.4),
                            500e3 * 0.4 / 0.6};
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        const auto o = observe(c.sensors[i], parts.mesh, parts.model, parts.mesh);
        const double value =
            o.on_stress.empty() ? o.of_displacement(solved->displacement.data()) : o.of_stress(solved->stress, 1, 0);
        EXPECT_NEAR(value / exact[i], 1.0, 1e-9) << i;
    }
    EXPECT_LT(solved->statistics.residual_relative, 1e-9);
}
