// From the ledger to the answer.
#include "diagnose/steps/investigation.h"

#include <algorithm>

namespace explore::diagnose {

using hypotheses::Kind;

// Every explanation, or what comes nearest, is fitted on the study's own mesh. False: interrupted.
bool Investigation::settle() {
    constexpr int rounds = 4; // others may come to the fore
    for (int round = 0; round < rounds; ++round) {
        const Decision now = decide(d_.ledger);
        bool is_settled = true;
        for (const auto& list : {now.names, now.nearest}) {
            for (std::size_t i = 0; i < list.size(); ++i) {
                const Row row = d_.ledger.rows()[list[i]];
                const Model coarse = models_[row.model].model;
                if (row.fit.mesh != Mesh::coarse) {
                    continue;
                }
                if (auto own = fits_.confirm(coarse, fit_number)) {
                    record(judged(std::move(*own)), row.hypothesis.kind);
                    is_settled = false;
                }
            }
        }
        is_settled = !look_along_open_directions() && is_settled;
        if (run::interrupted()) {
            return false;
        }
        if (is_settled) {
            break;
        }
    }
    return true;
}

// The decision as models.
void Investigation::take_decision() {
    d_.decision = decide(d_.ledger);
    const auto explanations_of = [&](const std::vector<std::size_t>& rows) {
        std::vector<Explanation> list;
        for (const std::size_t r : rows) {
            const double first = d_.ledger.rows()[rows[0]].log_weight();
            const Row& row = d_.ledger.rows()[r];
            list.push_back({r, models_[row.model], 2.0 * (first - row.log_weight())});
        }
        return list;
    };
    d_.explanations = explanations_of(d_.decision.names);
    d_.nearest = explanations_of(d_.decision.nearest);
    d_.extended.reset();
    if (d_.decision.model) {
        d_.extended = models_[d_.ledger.rows()[*d_.decision.model].model];
    }
}

// Predicts what is left out by the model of the decision. False: interrupted.
bool Investigation::hold_out() {
    d_.places.reset();
    d_.loads.reset();
    if (!d_.extended) {
        return true;
    }
    const std::string key = d_.ledger.rows()[*d_.decision.model].hypothesis.key();
    const Target pull = d_.is_corrected() ? d_.location->pull : Target{};
    const LeftOutTask left_out{task_, d_, *d_.extended, pull, explored_};
    std::vector<std::vector<Fold>> divisions{task_.places};
    if (task_.loads.size() > 1) {
        divisions.push_back(task_.loads);
    }
    auto held = predict_left_out(left_out, divisions, fold_number);
    d_.places = std::move(held[0]);
    if (held.size() > 1) {
        d_.loads = std::move(held[1]);
    }
    for (const auto& predicted : {d_.places, d_.loads}) {
        if (predicted) {
            d_.ledger.add(Ledger::Predicted{key, predicted->before, predicted->after});
        }
    }
    return !run::interrupted();
}

bool Investigation::conclude(Says says) {
    if (!d_.failed.empty()) {
        return true;
    }
    if (d_.location) {
        for (const Row& row : std::vector<Row>(d_.ledger.rows())) {
            if (row.hypothesis.kind == Kind::correction) {
                d_.ledger.add(Ledger::Located{row.hypothesis.key(), says});
            }
        }
    }
    take_decision();
    if (!hold_out()) {
        return false;
    }
    // Readings left out may speak against a correction: the next model is then tried.
    const auto asked = d_.decision.model;
    take_decision();
    if (d_.decision.model != asked && !hold_out()) {
        return false;
    }
    if (!noise_is_stated_ && d_.verdict() == Verdict::adequate) { // it is that of the answer's own residuals
        d_.variance = std::max(d_.baseline.model.sum / std::max(1, d_.baseline.dof), 1e-24);
        judge_effects();
    }
    return true;
}

} // namespace explore::diagnose
