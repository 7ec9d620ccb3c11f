#include "analysis/diagnose/exchanges.h"

#include "inference/nuisance.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <map>
#include <tuple>

namespace explore::analysis {
namespace {

using Eigen::Index;

// The fitted readings of one instrument: by load and time, where each stands among the residuals.
struct Instrument {
    std::string quantity, place;
    double gauge = 0.0; // mm
    std::map<std::pair<std::string, double>, std::size_t> residuals;
    bool is_exact = true; // no reading only says more or less than

    bool may_be_exchanged_with(const Instrument& other) const {
        return is_exact && other.is_exact && quantity == other.quantity && gauge == other.gauge &&
               std::ranges::equal(residuals, other.residuals, {}, &decltype(residuals)::value_type::first,
                                  &decltype(residuals)::value_type::first);
    }
};

std::vector<Instrument> instruments_of(const study::Study& study, const std::vector<std::size_t>& rows) {
    std::vector<Instrument> list;
    for (std::size_t t = 0; t < rows.size(); ++t) {
        const data::Reading& reading = study.readings[rows[t]];
        const std::string place = reading.place_words();
        auto own = std::ranges::find_if(list, [&](const Instrument& known) {
            return known.quantity == reading.quantity && known.place == place && known.gauge == reading.gauge_mm;
        });
        if (own == list.end()) {
            list.push_back({.quantity = reading.quantity, .place = place, .gauge = reading.gauge_mm, .residuals = {}});
            own = list.end() - 1;
        }
        const bool is_new = own->residuals.emplace(std::pair{reading.load, reading.time_ms.value_or(-1.0)}, t).second;
        own->is_exact = own->is_exact && is_new && reading.censored == data::Censored::no;
    }
    return list;
}

template <class Use>
void for_each_exchange(const std::vector<Instrument>& instruments, const Use& use) {
    for (std::size_t a = 0; a < instruments.size(); ++a) {
        for (std::size_t b = a + 1; b < instruments.size(); ++b) {
            if (instruments[a].may_be_exchanged_with(instruments[b])) {
                use(instruments[a], instruments[b]);
            }
        }
    }
}

} // namespace

std::size_t possible_exchanges(const study::Study& study, const std::vector<std::size_t>& rows) {
    std::size_t count = 0;
    for_each_exchange(instruments_of(study, rows), [&](const Instrument&, const Instrument&) { ++count; });
    return count;
}

std::optional<data::BowlFault> likely_exchange(const study::Study& study, const problem::Problem& problem,
                                               const std::vector<std::size_t>& rows, const diagnose::Model& model) {
    if (study.has_own_model || study.data.correlates_noise() || model.evaluation.jacobian.rows() == 0) {
        return std::nullopt;
    }
    const Eigen::MatrixXd jacobian = problem.residual_jacobian(model.evaluation);
    const Eigen::VectorXd residuals = problem.residuals(model.evaluation);
    double least = residuals.squaredNorm() / 5.0;
    const auto dof = static_cast<double>(std::max<Index>(1, jacobian.rows() - jacobian.cols()));
    constexpr double by_noise = 1e-3;
    least = std::max(least, gsl_cdf_chisq_Qinv(by_noise, dof));
    std::optional<data::BowlFault> found;
    for_each_exchange(instruments_of(study, rows), [&](const Instrument& a, const Instrument& b) {
        Eigen::MatrixXd exchanged = jacobian;
        Eigen::VectorXd left = residuals;
        // The reading keeps its value and its noise, and stands where the other does.
        const auto moves = [&](std::size_t from, std::size_t to) {
            const data::Reading& own = study.readings[rows[from]];
            const double there = model.evaluation.responses[rows[to]];
            const auto row = static_cast<Index>(from);
            left[row] = own.noise.residual(there, own.measured());
            exchanged.row(row) = jacobian.row(static_cast<Index>(to)) * own.noise.slope(there, own.measured()) /
                                 study.readings[rows[to]].noise.slope(there, study.readings[rows[to]].measured());
        };
        std::vector<std::size_t> pairs;
        for (const auto& [when, t] : a.residuals) {
            const std::size_t other = b.residuals.at(when);
            moves(t, other);
            moves(other, t);
            pairs.insert(pairs.end(), {rows[t], rows[other]});
        }
        const double sum = inference::Nuisance(exchanged, model.unit, left).beyond(left).squaredNorm();
        if (sum < least) {
            least = sum;
            found = data::BowlFault{.kind = data::BowlFault::Kind::exchanged,
                                    .rows = std::move(pairs),
                                    .offsets = {},
                                    .places = {a.place, b.place}};
        }
    });
    return found;
}

} // namespace explore::analysis
