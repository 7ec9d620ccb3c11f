#include "analysis/diagnose/weigh_premises.h"

#include "analysis/common/floor.h"
#include "analysis/diagnose/bottom_hint.h"
#include "analysis/diagnose/exchanges.h"
#include "diagnose/evidence.h"

#include <algorithm>
#include <cmath>

namespace explore::analysis {
namespace {

bool is_exchanged(const data::BowlFault& fault) {
    return fault.kind == data::BowlFault::Kind::exchanged;
}

// Whether the study's model, by its premises, misses the readings by more than noise.
bool is_contradicted(const DiagnoseResult& result) {
    return result.diagnosis.ledger.noise_is_stated() &&
           (result.failed() || result.diagnosis.baseline.p_value < diagnose::level_contradicted);
}

// The most probable hypothesis; nullptr: none was tried.
const diagnose::Row* leading(const DiagnoseResult& result) {
    const diagnose::Row* found = nullptr;
    const diagnose::Ledger& ledger = result.diagnosis.ledger;
    for (const std::size_t r : diagnose::rows_that_count(ledger)) {
        const diagnose::Row& row = ledger.rows()[r];
        found = row.is_tried() && (found == nullptr || row.log_weight() > found->log_weight()) ? &row : found;
    }
    return found;
}

// Its probability beforehand and what the data say, the logarithm.
double most_probable(const DiagnoseResult& result) {
    const diagnose::Row* const row = leading(result);
    return row != nullptr ? row->log_weight() : -INFINITY;
}

// log_prior: of the further premise, its probability beforehand.
DiagnoseResult more_probable(DiagnoseResult with, double log_prior, DiagnoseResult without) {
    const bool is_without =
        !without.failed() && (with.failed() || most_probable(without) > log_prior + most_probable(with));
    return std::move(is_without ? without : with);
}

double log_prior_of_exchange(std::size_t exchanges) {
    return hypotheses::log_prior(hypotheses::Kind::layout, {}, exchanges, 0);
}

// A wrong reading far from the load makes a bowl rise as two exchanged sensors do. Where the study's model does not fit
// with them in order, the readings are explained as they stand too: the more probable answer.
std::optional<DiagnoseResult> weigh_exchange(DiagnoseResult in_order, const DiagnoseBy& by) {
    Premises as_read = in_order.premises;
    if (!is_contradicted(in_order) || std::ranges::none_of(as_read.faults, is_exchanged)) {
        return in_order;
    }
    for (data::BowlFault& fault : as_read.faults) {
        fault.kind = is_exchanged(fault) ? data::BowlFault::Kind::rises : fault.kind;
    }
    auto other = by(as_read);
    if (!other) {
        return std::nullopt;
    }
    const std::size_t readings = in_order.layout.rows.size();
    return more_probable(std::move(in_order), log_prior_of_exchange(readings * (readings - 1) / 2), std::move(*other));
}

// Of instruments whose exchange no bowl shows the model may: the more probable of the readings as they stand and with
// the two in order.
std::optional<DiagnoseResult> weigh_likely_exchange(DiagnoseResult as_read, const DiagnoseBy& by) {
    if (as_read.failed() || !is_contradicted(as_read) || std::ranges::any_of(as_read.premises.faults, is_exchanged)) {
        return as_read;
    }
    const auto& rows = as_read.layout.rows;
    auto exchange = likely_exchange(as_read.study, study::make_noise_problem(as_read.study, study::Scope::fitted), rows,
                                    as_read.diagnosis.baseline.model);
    if (!exchange) {
        return as_read;
    }
    Premises premises = as_read.premises;
    premises.faults.push_back(std::move(*exchange));
    auto in_order = by(premises);
    if (!in_order) {
        return std::nullopt;
    }
    const std::size_t exchanges = possible_exchanges(as_read.study, rows);
    return more_probable(std::move(*in_order), log_prior_of_exchange(exchanges), std::move(as_read));
}

// Outputs by either premise.
void hold_both(std::vector<OutputUncertainty>& outputs, const std::vector<OutputUncertainty>& others) {
    for (OutputUncertainty& own : outputs) {
        const auto other = std::ranges::find(others, own.reading, &OutputUncertainty::reading);
        if (other != others.end()) {
            own.wide_low = std::min(own.wide_low, other->wide_low);
            own.wide_high = std::max(own.wide_high, other->wide_high);
            own.take_back(own.best);
        }
    }
}

// A floor cannot be moved away by so many metres that there is none: the study is diagnosed without it where readings
// want it as deep as it may be.
std::optional<DiagnoseResult> weigh_floor(const study::Study& study, DiagnoseResult with_floor, const DiagnoseBy& by) {
    if (with_floor.failed() || !is_contradicted(with_floor) || !is_floor_sought_deepest(with_floor) ||
        !without_floor(study)) {
        return with_floor;
    }
    Premises premises = with_floor.premises;
    premises.no_floor = true;
    auto other = by(premises);
    if (!other) {
        return std::nullopt;
    }
    if (other->failed()) {
        with_floor.is_floor_weighed = true;
        return with_floor;
    }
    const hypotheses::Counts counts{.readings = 0, .effects = with_floor.diagnosis.effects.size(), .channels = 0};
    const double log_prior = hypotheses::log_prior(hypotheses::Kind::effect, counts, 1, 0);
    const double log_odds = log_prior + most_probable(*other) - most_probable(with_floor); // of no floor
    const bool is_without = log_odds >= 0.0;
    DiagnoseResult& result = is_without ? *other : with_floor;
    const DiagnoseResult& loses = is_without ? with_floor : *other;
    const hypotheses::Hypothesis& best = leading(loses)->hypothesis;
    diagnose::Ledger::Elsewhere rival{.words =
                                          is_without ? "with the floor as stated: " + best.name : no_floor_words(study),
                                      .terms = best.terms,
                                      .probability = 1.0 / (1.0 + std::exp(std::abs(log_odds)))};
    if (!is_without) {
        rival.terms.insert(rival.terms.begin(), {"floor-depth", "", ""});
    }
    result.is_floor_weighed = true;
    result.diagnosis.ledger.add(std::move(rival));
    if (diagnose::Decision now = diagnose::decide(result.diagnosis.ledger);
        now.reason == diagnose::Reason::other_premise) {
        result.diagnosis.decision = std::move(now);
        hold_both(result.outputs, loses.outputs);
    }
    return std::move(result);
}

} // namespace

std::optional<DiagnoseResult> weigh_premises(const study::Study& study, DiagnoseResult seen, const DiagnoseBy& by) {
    auto result = weigh_exchange(std::move(seen), by);
    result = result ? weigh_likely_exchange(std::move(*result), by) : std::nullopt;
    return result ? weigh_floor(study, std::move(*result), by) : std::nullopt;
}

} // namespace explore::analysis
