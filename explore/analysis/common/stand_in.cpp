#include "analysis/common/stand_in.h"

#include "base/text.h"
#include "external/model.h"
#include "search/design.h"
#include "study/stand_in.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace explore::analysis {
namespace {

using inference::Kriging;

constexpr int candidate_points = 1024;
constexpr std::uint64_t candidate_seed = 0x57a4d14;
// Of the matrix that all known values and slopes make.
constexpr std::size_t most_known_rows = 1000;
constexpr std::size_t most_known_points = 300;

double quantile_95(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(0.95 * static_cast<double>(values.size() - 1))];
}

// The value of a stand-in before the model ran there.
struct Surprise {
    double of_deviation = 0.0, of_range = 0.0; // the error of a response
};

// Numbers of further candidates, those first of which the stand-in is least sure, no two near each other. sure: whether
// it is of all but one in twenty.
std::vector<std::size_t> next_candidates(const study::Study& study, const study::StandIn& now, double limit,
                                         const std::vector<std::vector<double>>& candidates,
                                         const std::vector<char>& taken, std::size_t count, bool& sure) {
    std::vector<double> error(candidates.size());
    for (std::size_t c = 0; c < candidates.size(); ++c) {
        error[c] = study::error_of_allowed(study, now, limit, now.between.at(candidates[c], false));
    }
    sure = quantile_95(error) <= 1.0;
    std::vector<std::size_t> order;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
        if (taken[c] == 0) {
            order.push_back(c);
        }
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return error[a] > error[b]; });
    const double apart =
        0.5 * std::pow(static_cast<double>(now.between.known().size()), -1.0 / study.space.dimension());
    std::vector<std::size_t> chosen;
    for (const std::size_t c : order) {
        const bool near = std::any_of(chosen.begin(), chosen.end(), [&](std::size_t other) {
            return search::squared_distance(candidates[c], candidates[other]) < apart * apart;
        });
        if (!near && chosen.size() < count) {
            chosen.push_back(c);
        }
    }
    return chosen;
}

} // namespace

std::optional<ReducedProblem> stand_in(Session& session, const problem::Problem& fitted, const study::Study& study,
                                       const ModelOptions& model) {
    const double limit = model.limit_percent / 100.0;
    const bool with_slopes = study.external->simulator().has_jacobian();
    const auto dimension = static_cast<std::size_t>(study.space.dimension());
    const std::size_t most = std::min(most_known_points, most_known_rows / (with_slopes ? 1 + dimension : 1));
    const auto candidates = search::sobol(study.space, candidate_points, candidate_seed).points;
    std::vector<char> taken(candidates.size(), 0);
    search::Design design{.name = "where the stand-in is not sure", .points = {}, .family = "stand-in"};
    const auto take = [&](std::size_t candidate) {
        taken[candidate] = 1;
        design.points.push_back(candidates[candidate]);
    };
    for (std::size_t c = 0; c < std::min(most, std::max<std::size_t>(16, 4 * (1 + dimension))); ++c) {
        take(c);
    }
    const problem::Problem full = study::make_prediction_problem(study, {});
    const std::string settings = fmt::format("stand-in of {} %", model.limit_percent);
    auto engine = session.engine(full, session.begin(study, "stand-in", settings));
    std::vector<inference::KnownPoint> known;
    std::vector<std::vector<double>> holes;
    std::string why; // a point has no answer
    std::vector<Surprise> surprises;
    std::shared_ptr<study::StandIn> now;
    for (bool sure = false; !sure;) {
        const std::size_t before = known.size() + holes.size();
        const auto evaluations = engine.evaluate(design, with_slopes, before);
        if (!evaluations) {
            return std::nullopt;
        }
        std::vector<Surprise> newest;
        for (const problem::Evaluation& evaluation : *evaluations) {
            if (!evaluation.converged()) {
                holes.push_back(study.space.unit(evaluation.parameters));
                why = why.empty() ? evaluation.reason : why;
                continue;
            }
            known.push_back(study::known_point(study, evaluation));
            if (now != nullptr) {
                const Kriging::Answer said = now->between.at(known.back().unit, false);
                const Eigen::VectorXd ranges = now->between.ranges();
                for (Eigen::Index i = 0; i < said.values.size(); ++i) {
                    const double error = std::abs(said.values[i] - known.back().values[i]);
                    newest.push_back({error / said.deviations[i], ranges[i] > 0.0 ? error / ranges[i] : 0.0});
                }
            }
        }
        if (known.size() < 1 + dimension) {
            throw std::runtime_error(fmt::format("the model has {} at {} points, too few for a stand-in{}",
                                                 pave::counted(known.size(), "answer", "answers"), design.points.size(),
                                                 why.empty() ? "" : "; where it has none it says: " + why));
        }
        if (!newest.empty()) {
            surprises = std::move(newest);
        }
        now = std::make_shared<study::StandIn>(study::StandIn{.between = Kriging(known), .holes = holes});
        if (!surprises.empty()) {
            std::vector<double> ratios;
            for (const Surprise& s : surprises) {
                ratios.push_back(s.of_deviation);
            }
            constexpr double least = 0.5; // a batch may flatter
            now->factor = std::max(least, quantile_95(std::move(ratios)));
        }
        if (design.points.size() >= most) {
            break;
        }
        const std::size_t more = std::min(most - design.points.size(), std::max<std::size_t>(8, known.size() / 4));
        const auto next = next_candidates(study, *now, limit, candidates, taken, more, sure);
        sure = (sure && !surprises.empty()) || next.empty();
        if (!sure) {
            std::for_each(next.begin(), next.end(), take);
        }
    }
    double error_95 = 0.0;
    if (!surprises.empty()) {
        std::vector<double> shares;
        for (const Surprise& s : surprises) {
            shares.push_back(s.of_range);
        }
        error_95 = quantile_95(std::move(shares));
    }
    return ReducedProblem{.problem = study::with_stand_in(fitted, study, now, limit),
                          .settings = ", " + settings,
                          .loads = {{"model",
                                     {.full_runs = static_cast<int>(design.points.size()),
                                      .modes = 0,
                                      .points = static_cast<int>(known.size()),
                                      .error_95 = error_95}}},
                          .built = engine.tally().computed > 0};
}

} // namespace explore::analysis
