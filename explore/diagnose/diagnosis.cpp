#include "diagnose/diagnosis.h"

#include "diagnose/steps/investigation.h"

#include <gsl/gsl_cdf.h>

namespace explore::diagnose {

namespace {

constexpr double level_overstated = 0.01;

} // namespace

Investigation::Investigation(const DiagnosisTask& task, const DiagnosisSettings& settings)
    : task_(task),
      bench_(task.bench),
      settings_(settings),
      judge_(task.bench, task.candidates, task.groups),
      noise_is_stated_(judge_.noise_is_stated()),
      arena_(run::concurrency(task.bench.threads())),
      fits_(task.bench, task_.candidates, d_.variance) {
    d_.ledger = Ledger(noise_is_stated_);
}

bool Investigation::is_contradicted(const Judged& j) const {
    return noise_is_stated_ && (j.p_value < level_contradicted || j.pattern.p_value < level_contradicted);
}

std::size_t Investigation::variants_of(std::size_t candidate) const {
    const Candidate& own = task_.candidates[candidate];
    return static_cast<std::size_t>(
        std::count_if(task_.candidates.begin(), task_.candidates.end(), [&](const Candidate& other) {
            return other.effect == own.effect && other.is_layout == own.is_layout;
        }));
}

double Investigation::criterion(const Judged& j) const {
    double sum = j.chi2;
    for (const std::size_t c : j.model.members) {
        sum += 2.0 * std::log(static_cast<double>(variants_of(c)));
    }
    return sum;
}

std::optional<Model> Investigation::fit_from(const Members& members, int number, const std::vector<double>& start,
                                             const Target& target, const FitSettings& settings) {
    return diagnose::fit_from(bench_, members, number, start, d_.variance, target, settings);
}

std::vector<const Judged*> Investigation::fitted_singles() const {
    std::vector<const Judged*> singles;
    for (const EffectResult& effect : d_.effects) {
        if (effect.fit) {
            singles.push_back(&*effect.fit);
        }
    }
    return singles;
}

bool Investigation::find() {
    for (const auto& premise : task_.premises) {
        d_.ledger.add(Row{.hypothesis = premise, .not_tried = "seen in the readings", .is_premise = true});
    }
    if (!fit_baseline()) {
        return false;
    }
    if (!d_.failed.empty()) {
        return true;
    }
    constexpr int baselines = 3;
    bool better = true;
    for (int attempt = 0; better && attempt < baselines; ++attempt) {
        if (!fit_singles()) {
            return false;
        }
        better = false;
        if (attempt + 1 < baselines && !improve_baseline(better)) {
            return false;
        }
    }
    examine_baseline();
    d_.noise_is_overstated = noise_is_stated_ && d_.baseline.dof > 0 &&
                             gsl_cdf_chisq_P(d_.baseline.chi2, d_.baseline.dof) < level_overstated;
    record_noise();
    if (decide(d_.ledger).as_stated) {
        record_singles();
        return true;
    }
    using Step = bool (Investigation::*)();
    for (const Step step :
         {&Investigation::fit_untried, &Investigation::fit_wrong_readings, &Investigation::fit_two_effects,
          &Investigation::weigh_chances, &Investigation::record_all, &Investigation::settle, &Investigation::locate}) {
        if (!(this->*step)()) {
            return false;
        }
    }
    return true;
}

bool Investigation::record_all() {
    record_singles();
    for (const Judged& fit : wrong_readings_) {
        record(fit, hypotheses::Kind::readings);
    }
    for (const Judged& pair : pairs_) {
        record(pair, hypotheses::Kind::effects);
    }
    weigh_confounding();
    return true;
}

Diagnoser::Diagnoser(const DiagnosisTask& task, const DiagnosisSettings& settings)
    : investigation_(std::make_unique<Investigation>(task, settings)) {}

Diagnoser::~Diagnoser() = default;

bool Diagnoser::find() {
    return investigation_->find();
}

const Diagnosis& Diagnoser::found() const {
    return investigation_->diagnosis();
}

bool Diagnoser::conclude(Says says) {
    return investigation_->conclude(says);
}

Diagnosis Diagnoser::result() {
    return std::move(investigation_->diagnosis());
}

std::optional<Diagnosis> diagnose(const DiagnosisTask& task, const DiagnosisSettings& settings, Says says) {
    Diagnoser diagnoser(task, settings);
    if (!diagnoser.find() || !diagnoser.conclude(says)) {
        return std::nullopt;
    }
    return diagnoser.result();
}

} // namespace explore::diagnose
