// Smooth corrections in place of names, or beside them.
#include "diagnose/location.h"
#include "diagnose/steps/investigation.h"

#include <cmath>

namespace explore::diagnose {

using hypotheses::Kind;

namespace {

std::string subject_of(const Channel& channel) {
    return channel.layer.empty() ? std::string(hypotheses::of_readings) : channel.layer;
}

} // namespace

// Where a correction may be the answer or keep a name from standing alone. False: interrupted.
bool Investigation::locate() {
    const Decision now = decide(d_.ledger);
    if (task_.channels.empty() || now.as_stated) {
        return true;
    }
    // Noise that is not as stated is weighed against a smooth error of the model, too.
    const bool is_open = now.verdict == Verdict::adequate || now.verdict == Verdict::unexplained ||
                         now.leaves_more_than_noise || now.reason == Reason::at_end || !now.model;
    const bool is_nearly_alone =
        now.verdict == Verdict::cause_named || now.reason == Reason::two_effects || now.reason == Reason::noise;
    if (!is_open && !is_nearly_alone) {
        return true;
    }
    const Judged* named = now.model ? &models_[d_.ledger.rows()[*now.model].model] : nullptr;
    if (!find_corrections(task_, d_, is_nearly_alone && named != nullptr ? named->aicc + margin : INFINITY,
                          d_.location)) {
        return false;
    }
    if (d_.location) {
        record_location();
    }
    if (named != nullptr && now.verdict == Verdict::cause_named &&
        !(d_.location && d_.location->fit.aicc < named->aicc + margin)) {
        std::vector<double> p;
        if (!test_beside(task_, d_, named->model, p)) {
            return false;
        }
        for (std::size_t c = 0; c < p.size(); ++c) {
            d_.ledger.add(
                Ledger::Beyond{d_.ledger.rows()[*now.model].hypothesis.key(), subject_of(task_.channels[c]), p[c]});
        }
    }
    return true;
}

void Investigation::record_location() {
    const Location& location = *d_.location;
    Row row{.hypothesis = {.kind = Kind::correction, .name = ""},
            .fit = {.mesh = location.fit.model.mesh,
                    .chi2 = location.fit.chi2,
                    .dof = location.fit.dof,
                    .numbers = location.numbers,
                    .p_value = location.fit.p_value,
                    .pattern_chi2 = location.fit.pattern.chi2,
                    .pattern_dof = location.fit.pattern.dof,
                    .p_pattern = location.fit.pattern.p_value}};
    for (const Correction& correction : location.corrections) {
        const Channel& channel = task_.channels[correction.channel];
        row.hypothesis.name += (row.hypothesis.name.empty() ? "" : " and ") + channel.name;
        row.hypothesis.subjects.push_back(subject_of(channel));
        row.log_prior = row.log_prior == 0.0 ? hypotheses::log_prior(Kind::correction, counts(), 1, 0)
                                             : row.log_prior - std::log(static_cast<double>(task_.channels.size()));
    }
    row.log_evidence = location.fit.evidence.log;
    row.noise = location.fit.evidence.noise;
    row.model = models_.size();
    models_.push_back(location.fit);
    d_.ledger.add(std::move(row));
}

} // namespace explore::diagnose
