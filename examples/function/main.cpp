// A function of one's own, fitted: two exponential decays, whose exchange fits as well. Prints every minimum.
#include <cmath>
#include <cstdio>
#include <landscape/multistart.h>
#include <search/design.h>

using namespace explore;

struct Decay final : problem::ForwardFunction {
    static constexpr int readings = 12; // at 1, 2, ... s

    std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }

    pave::Outcome<problem::Prediction> evaluate(std::span<const double> k, bool with_jacobian,
                                                Workspace&) const override {
        problem::Prediction p;
        p.jacobian.resize(with_jacobian ? readings : 0, 2);
        for (int t = 1; t <= readings; ++t) {
            p.responses.push_back(std::exp(-k[0] * t) + std::exp(-k[1] * t));
            for (int j = 0; j < 2 && with_jacobian; ++j) {
                p.jacobian(t - 1, j) = -t * std::exp(-k[static_cast<std::size_t>(j)] * t);
            }
        }
        return p;
    }
};

int main() {
    std::vector<problem::Misfit::Term> terms;
    for (int t = 1; t <= Decay::readings; ++t) { // measured: rates of 0.2 and 0.8
        terms.push_back({.response = static_cast<std::size_t>(t - 1),
                         .measured = std::exp(-0.2 * t) + std::exp(-0.8 * t),
                         .scale = 0.01});
    }
    const problem::Axis rate{.name = "rate", .low = 0.02, .high = 4.0, .scale = problem::Scale::log};
    const problem::Problem decay({{rate, rate}}, std::make_shared<Decay>(), {problem::MisfitKind::weighted, terms});
    run::Engine engine(decay, nullptr, 0, {.show_progress = false});
    const auto found = landscape::multistart(engine, decay, search::sobol(decay.space, 64, 1), {});
    for (std::size_t m = 0; found && m < found->minima.size(); ++m) {
        const problem::Evaluation& e = found->minima[m].evaluation;
        std::printf("%.6f %.6f misfit %.2g\n", e.parameters[0], e.parameters[1], e.misfit);
    }
    return found ? 0 : 1;
}
