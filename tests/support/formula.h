// Models given by formulas, whose landscapes are known.
#pragma once

#include "problem/problem.h"

#include "base/random.h"

#include <bit>
#include <fmt/format.h>
#include <functional>

namespace test {

// A model given by a formula; a share of its points has no answer, drawn from the point itself.
class Formula final : public explore::problem::ForwardFunction {
public:
    using Model = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& responses, Eigen::MatrixXd& jacobian)>;
    explicit Formula(Model model, double failing = 0.0) : model_(std::move(model)), failing_(failing) {}

    std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
    pave::Outcome<explore::problem::Prediction> evaluate(std::span<const double> values, bool with_jacobian,
                                                         Workspace&) const override {
        const Eigen::VectorXd x = Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
        std::uint64_t bits = 17;
        for (const double v : values) {
            bits = bits * 0x9e3779b97f4a7c15ULL + std::bit_cast<std::uint64_t>(v);
        }
        if (failing_ > 0.0 && pave::RandomStream(bits, 0).uniform(0) < failing_) {
            return pave::Failure{pave::Status::failed, "injected"};
        }
        explore::problem::Prediction p;
        Eigen::VectorXd responses;
        Eigen::MatrixXd jacobian;
        model_(x, responses, jacobian);
        p.responses.assign(responses.begin(), responses.end());
        if (with_jacobian) {
            p.jacobian = jacobian;
        }
        return p;
    }

private:
    Model model_;
    double failing_;
};

// Axes from 0 to 1; readings `measured` with standard deviation sigma, which they state.
inline explore::problem::Problem problem_of(int dimension, Formula formula, const std::vector<double>& measured,
                                            double sigma) {
    explore::problem::ParameterSpace space;
    for (int k = 0; k < dimension; ++k) {
        space.axes.push_back({fmt::format("p{}", k), 0.0, 1.0, explore::problem::Scale::linear, 0, 0.5});
    }
    std::vector<explore::problem::Misfit::Term> terms;
    for (std::size_t i = 0; i < measured.size(); ++i) {
        terms.push_back({i, measured[i], sigma, 1.0, {.absolute = sigma}});
    }
    return {space, std::make_shared<Formula>(std::move(formula)), {explore::problem::MisfitKind::weighted, terms}};
}

} // namespace test
