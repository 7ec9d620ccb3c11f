#include "analysis/common/candidate_readings.h"

#include "inference/information_gain.h"
#include "run/interrupt.h"
#include "study/candidates.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace explore::analysis {

CandidateReadings::CandidateReadings(const study::Study& study)
    : list_(study::candidates(study)),
      problem_(study::make_prediction_problem(list_)),
      workspace_(problem_.function->make_workspace()) {}

problem::Evaluation CandidateReadings::at(const std::vector<double>& unit, bool with_jacobian) {
    const std::clock_t begin = std::clock();
    auto evaluation = problem_.evaluate(unit, with_jacobian, *workspace_);
    forward_cpu_seconds_ += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    return evaluation;
}

std::vector<problem::Evaluation> CandidateReadings::at_many(std::span<const std::vector<double>> units) {
    const std::clock_t begin = std::clock();
    auto evaluations = problem_.evaluate_many(units, false, *workspace_);
    forward_cpu_seconds_ += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    return evaluations;
}

std::vector<data::Reading> CandidateReadings::readings(const std::vector<double>& responses) const {
    std::vector<data::Reading> readings = list_.readings;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        readings[i].value = readings[i].in_unit(responses[i]);
        readings[i].noise.absolute = study::candidate_noise(list_.model.sensors[i].quantity, responses[i]);
    }
    return readings;
}

Eigen::MatrixXd CandidateReadings::rows(const problem::Evaluation& there, const std::vector<double>& unit,
                                        const std::vector<data::Reading>& readings) const {
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(readings.size()), static_cast<Eigen::Index>(unit.size()));
    for (std::size_t i = 0; i < readings.size(); ++i) {
        for (std::size_t k = 0; k < unit.size(); ++k) {
            const auto row = static_cast<Eigen::Index>(i);
            const auto column = static_cast<Eigen::Index>(k);
            rows(row, column) =
                there.jacobian(row, column) * problem_.space.axes[k].d_physical(unit[k]) / readings[i].noise.absolute;
        }
    }
    return rows;
}

bool is_at_hand(const study::Study& study, const data::Reading& reading) {
    const auto found = std::find_if(std::begin(pave::pavement::quantities), std::end(pave::pavement::quantities),
                                    [&](const auto& about) { return about.name == reading.quantity; });
    return found != std::end(pave::pavement::quantities) && study.is_at_hand(found->quantity);
}

namespace {

// Those at hand first, of either the most telling.
void put_in_order(const study::Study& study, std::vector<TellingReading>& telling) {
    std::stable_sort(telling.begin(), telling.end(), [](const auto& a, const auto& b) { return a.bits > b.bits; });
    std::stable_partition(telling.begin(), telling.end(),
                          [&](const auto& own) { return is_at_hand(study, own.reading); });
}

} // namespace

std::vector<TellingReading> telling_readings(const study::Study& study, const std::vector<double>& unit,
                                             const Eigen::MatrixXd& covariance, std::size_t others) {
    if (study.has_own_model) {
        return {};
    }
    CandidateReadings candidates(study);
    const auto there = candidates.at(unit, true);
    std::vector<TellingReading> telling;
    if (!there.converged()) {
        return telling;
    }
    const auto readings = candidates.readings(there);
    const Eigen::MatrixXd rows = candidates.rows(there, unit, readings);
    // Of the others, where those of interest are known.
    const auto n = static_cast<Eigen::Index>(others);
    const Eigen::Index asked = covariance.rows() - n;
    const Eigen::MatrixXd across = covariance.topRightCorner(n, asked);
    const Eigen::MatrixXd given = covariance.topLeftCorner(n, n) -
                                  across * covariance.bottomRightCorner(asked, asked).llt().solve(across.transpose());
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const Eigen::RowVectorXd row = rows.row(static_cast<Eigen::Index>(i));
        const Eigen::RowVectorXd own = row.head(n);
        const double before = 1.0 + row.dot(covariance * row.transpose());
        const double after = 1.0 + std::max(0.0, own.dot(given * own.transpose()));
        telling.push_back({readings[i], 0.5 * std::log2(std::max(1.0, before / after))});
    }
    put_in_order(study, telling);
    return telling;
}

std::vector<TellingReading> telling_readings(const study::Study& study, const Eigen::MatrixXd& draws) {
    std::vector<TellingReading> telling;
    if (study.has_own_model || draws.rows() == 0) {
        return telling;
    }
    constexpr Eigen::Index runs = 64, at_once = 8;
    CandidateReadings candidates(study);
    std::vector<Eigen::Index> sample;
    std::vector<std::vector<double>> responses;
    for (Eigen::Index first = 0; first < runs && !run::interrupted(); first += at_once) {
        std::vector<std::vector<double>> units;
        std::vector<Eigen::Index> rows;
        for (Eigen::Index i = first; i < first + at_once; ++i) {
            rows.push_back(i * draws.rows() / runs);
            units.emplace_back(draws.row(rows.back()).begin(), draws.row(rows.back()).end());
        }
        auto evaluations = candidates.at_many(units);
        for (std::size_t i = 0; i < evaluations.size(); ++i) {
            if (evaluations[i].converged()) {
                sample.push_back(rows[i]);
                responses.push_back(std::move(evaluations[i].responses));
            }
        }
    }
    if (run::interrupted() || 2 * sample.size() <= static_cast<std::size_t>(runs)) {
        return telling;
    }
    Eigen::MatrixXd predicted(static_cast<Eigen::Index>(responses[0].size()), static_cast<Eigen::Index>(sample.size()));
    for (std::size_t i = 0; i < sample.size(); ++i) {
        predicted.col(static_cast<Eigen::Index>(i)) =
            Eigen::Map<const Eigen::VectorXd>(responses[i].data(), static_cast<Eigen::Index>(responses[i].size()));
    }
    const Eigen::VectorXd mean = predicted.rowwise().mean();
    const auto readings = candidates.readings({mean.begin(), mean.end()});
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const Eigen::VectorXd own = predicted.row(static_cast<Eigen::Index>(i)).transpose();
        telling.push_back({readings[i], inference::information_gain(draws, sample, own / readings[i].noise.absolute)});
    }
    put_in_order(study, telling);
    return telling;
}

} // namespace explore::analysis
