#include "optimise/arrow_gauss_newton.h"

#include "optimise/gauss_newton.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <random>

using namespace explore::optimise;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

const SearchSettings exact{
    .max_evaluations = 200, .step_tolerance = 1e-13, .misfit_tolerance = 1e-28, .enough = 0.0, .damping = 1e-3};

void one_by_one(std::size_t count, const std::function<void(std::size_t)>& body) {
    for (std::size_t i = 0; i < count; ++i) {
        body(i);
    }
}
void backwards(std::size_t count, const std::function<void(std::size_t)>& body) {
    for (std::size_t i = count; i-- > 0;) {
        body(i);
    }
}

// Blocks of linear residuals A u - b, some of whose unknowns are common; where curved, (A u - b) + 0.3 (A u - b)^3.
struct Blocks {
    std::vector<ArrowBlock> blocks;
    std::vector<MatrixXd> a;
    std::vector<VectorXd> b;
    bool curved = false;
    int common = 0;

    Answer at(std::size_t block, std::span<const double> unit, Sample& sample) const {
        const Eigen::Map<const VectorXd> u(unit.data(), static_cast<Index>(unit.size()));
        const VectorXd r = a[block] * u - b[block];
        if (!curved) {
            sample.residuals = r;
            sample.jacobian = a[block];
            return Answer::computed;
        }
        sample.residuals = r.array() + 0.3 * r.array().cube();
        sample.jacobian = (1.0 + 0.9 * r.array().square()).matrix().asDiagonal() * a[block];
        return Answer::computed;
    }
    ArrowObjective objective() const {
        return
            [this](std::size_t block, std::span<const double> unit, Sample& sample) { return at(block, unit, sample); };
    }
    std::vector<std::vector<double>> middle() const {
        std::vector<std::vector<double>> start;
        for (const ArrowBlock& block : blocks) {
            start.emplace_back(block.common.size(), 0.5);
        }
        return start;
    }

    // The same as one dense problem: the common unknowns, then every block's own. Where each unknown of a block is.
    std::vector<std::vector<Index>> columns() const {
        std::vector<std::vector<Index>> all;
        Index next = common;
        for (const ArrowBlock& block : blocks) {
            auto& mine = all.emplace_back();
            for (const int c : block.common) {
                mine.push_back(c == own_unknown ? next++ : c);
            }
        }
        return all;
    }
    Index unknowns() const {
        Index count = common;
        for (const ArrowBlock& block : blocks) {
            count += std::count(block.common.begin(), block.common.end(), own_unknown);
        }
        return count;
    }
    Sample dense(std::span<const double> unit) const {
        Sample whole;
        Index rows = 0;
        for (const VectorXd& part : b) {
            rows += part.size();
        }
        whole.residuals.resize(rows);
        whole.jacobian = MatrixXd::Zero(rows, unknowns());
        Index next = 0;
        const auto columns_of = columns();
        for (std::size_t i = 0; i < blocks.size(); ++i) {
            std::vector<double> mine;
            for (const Index c : columns_of[i]) {
                mine.push_back(unit[static_cast<std::size_t>(c)]);
            }
            Sample sample;
            at(i, mine, sample);
            whole.residuals.segment(next, sample.residuals.size()) = sample.residuals;
            for (std::size_t k = 0; k < mine.size(); ++k) {
                whole.jacobian.block(next, columns_of[i][k], sample.residuals.size(), 1) =
                    sample.jacobian.col(static_cast<Index>(k));
            }
            next += sample.residuals.size();
        }
        return whole;
    }
};

// noise: how far the solution lies from 0.5; large ones run into bounds.
Blocks some_blocks(double noise) {
    Blocks made;
    // Two unknowns of all, one of the odd blocks; two own ones but in the last block, which has none.
    made.blocks = {{{0, own_unknown, 1, own_unknown}}, {{own_unknown, 1, 2, 0, own_unknown}},
                   {{own_unknown, 0, own_unknown, 1}}, {{1, own_unknown, own_unknown, 2, 0}},
                   {{own_unknown, own_unknown, 0, 1}}, {{0, 2}}};
    made.common = 3;
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    for (const ArrowBlock& block : made.blocks) {
        const auto n = static_cast<Index>(block.common.size());
        made.a.push_back(MatrixXd::NullaryExpr(n + 4, n, [&] { return normal(random); }));
        made.b.push_back(made.a.back() * VectorXd::Constant(n, 0.5) +
                         noise * VectorXd::NullaryExpr(n + 4, [&] { return normal(random); }));
    }
    return made;
}

void expect_dense_solution(const Blocks& blocks, double tolerance, int* bounds = nullptr) {
    const auto arrow = arrow_gauss_newton(blocks.blocks, blocks.middle(), blocks.objective(), one_by_one, exact);
    EXPECT_TRUE(arrow.converged) << arrow.ended;
    const auto dense = gauss_newton(
        std::vector<double>(static_cast<std::size_t>(blocks.unknowns()), 0.5),
        [&](std::span<const double> unit, Sample& sample) {
            sample = blocks.dense(unit);
            return Answer::computed;
        },
        exact);
    const auto columns = blocks.columns();
    double squares = 0.0;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        squares += arrow.squares[i];
        for (std::size_t k = 0; k < columns[i].size(); ++k) {
            const double there = dense.unit[static_cast<std::size_t>(columns[i][k])];
            EXPECT_NEAR(arrow.unit[i][k], there, tolerance) << "block " << i << ", unknown " << k;
            if (bounds != nullptr && (there == 0.0 || there == 1.0)) {
                ++*bounds;
            }
        }
    }
    EXPECT_NEAR(std::sqrt(squares), dense.misfit, 1e-10);
}

} // namespace

TEST(ArrowGaussNewton, SolvesTheLinearProblemThatANormalEquationSolves) {
    const Blocks blocks = some_blocks(0.05);
    const auto arrow = arrow_gauss_newton(blocks.blocks, blocks.middle(), blocks.objective(), one_by_one, exact);
    const std::vector<double> zero(static_cast<std::size_t>(blocks.unknowns()), 0.0);
    const Sample dense = blocks.dense(zero);
    const VectorXd solution =
        (dense.jacobian.transpose() * dense.jacobian).ldlt().solve(-dense.jacobian.transpose() * dense.residuals);
    const auto columns = blocks.columns();
    for (std::size_t i = 0; i < columns.size(); ++i) {
        for (std::size_t k = 0; k < columns[i].size(); ++k) {
            EXPECT_NEAR(arrow.unit[i][k], solution[columns[i][k]], 1e-10) << "block " << i << ", unknown " << k;
        }
    }
}

TEST(ArrowGaussNewton, EndsWhereADenseSearchWithBoundsEnds) {
    int bounds = 0;
    expect_dense_solution(some_blocks(0.6), 1e-9, &bounds);
    expect_dense_solution(some_blocks(1.5), 1e-9, &bounds);
    expect_dense_solution(some_blocks(5.0), 1e-9, &bounds);
    EXPECT_GT(bounds, 10) << "these are to be cases with bounds";
}

TEST(ArrowGaussNewton, EndsWhereADenseSearchEndsOnACurvedProblem) {
    Blocks blocks = some_blocks(0.3);
    blocks.curved = true;
    expect_dense_solution(blocks, 1e-7);
}

TEST(ArrowGaussNewton, GivesTheSameBitsInAnyOrderOfCalls) {
    Blocks blocks = some_blocks(0.4);
    blocks.curved = true;
    const auto forward = arrow_gauss_newton(blocks.blocks, blocks.middle(), blocks.objective(), one_by_one, exact);
    const auto backward = arrow_gauss_newton(blocks.blocks, blocks.middle(), blocks.objective(), backwards, exact);
    EXPECT_EQ(forward.unit, backward.unit);
    EXPECT_EQ(forward.squares, backward.squares);
}

TEST(ArrowGaussNewton, GoesAroundPointsWithoutAnAnswerAndStops) {
    const Blocks blocks = some_blocks(0.05);
    const auto hole = [&](std::size_t block, std::span<const double> unit, Sample& sample) {
        return block == 2 && unit[0] < 0.52 ? Answer::no_answer : blocks.at(block, unit, sample);
    };
    auto start = blocks.middle();
    EXPECT_TRUE(arrow_gauss_newton(blocks.blocks, start, hole, one_by_one, exact).unit.empty());
    start[2][0] = 0.7;
    const auto found = arrow_gauss_newton(blocks.blocks, start, hole, one_by_one, exact);
    EXPECT_GE(found.unit[2][0], 0.52);
    const auto stop = [](std::size_t, std::span<const double>, Sample&) { return Answer::stop; };
    EXPECT_TRUE(arrow_gauss_newton(blocks.blocks, start, stop, one_by_one, exact).stopped);
}

TEST(ArrowCovariance, IsTheInverseOfTheDenseNormalMatrix) {
    const Blocks blocks = some_blocks(0.05);
    const auto arrow = arrow_gauss_newton(blocks.blocks, blocks.middle(), blocks.objective(), one_by_one, exact);
    const auto covariance = arrow_covariance(blocks.blocks, arrow.normal);
    const std::vector<double> zero(static_cast<std::size_t>(blocks.unknowns()), 0.0);
    const MatrixXd jacobian = blocks.dense(zero).jacobian;
    MatrixXd normal = jacobian.transpose() * jacobian;
    normal.diagonal().array() += 1e-6;
    const MatrixXd inverse = normal.inverse();
    EXPECT_LT((covariance.common - inverse.topLeftCorner(3, 3)).cwiseAbs().maxCoeff(), 1e-10);
    const auto columns = blocks.columns();
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const MatrixXd part = inverse(columns[i], columns[i]);
        EXPECT_LT((covariance.blocks[i] - part).cwiseAbs().maxCoeff(), 1e-10) << "block " << i;
    }
}
