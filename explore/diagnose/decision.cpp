#include "diagnose/decision.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::diagnose {

namespace {

using hypotheses::Kind;

constexpr double level_rejected = 0.0005;  // by the pattern of the residuals alone, or where nothing else is near
constexpr double level_unexplained = 0.05; // evidence that is due to chance so often names nothing
constexpr double level_finds_more = 0.01;  // a correction finds more than what was named
constexpr double least_rate = 0.95;        // of telling two effects apart
constexpr double most_noise = 2.2;         // times the stated noise: more is no matter of noise
constexpr double most_of_structure = 1.5;  // the same, beside errors in common or heavy tails
constexpr double little = 0.05;            // probability that keeps a name from standing alone
constexpr double impossible = 3.0;         // margins: less probable by a factor of 8,000 than another
constexpr double hardly_possible = 2.0;    // margins: of a name whose size ends its range
constexpr double doubtful = 0.1; // that errors are larger than stated: chance names something in some of such cases

class Decider {
public:
    explicit Decider(const Ledger& ledger) : ledger_(ledger) { rank(); }

    Decision decide() {
        d_.noise = noise_;
        d_.as_stated = is_explained_as_stated();
        if (is_adequate()) {
            conclude_adequate();
        } else {
            decide_on_names();
        }
        add_premise();
        weigh_elsewhere();
        return std::move(d_);
    }

private:
    const Row& row(std::size_t r) const { return ledger_.rows()[r]; }
    bool is_stated() const { return ledger_.noise_is_stated(); }

    void rank() {
        std::vector<double> weights;
        for (const std::size_t r : rows_that_count(ledger_)) {
            const Row& own = row(r);
            if (own.is_premise) {
                d_.premise = r;
                continue;
            }
            if (!own.is_tried()) {
                continue;
            }
            d_.hypotheses.push_back({r, own.log_weight()});
            weights.push_back(own.log_weight());
        }
        const double all = hypotheses::log_sum(weights);
        for (Decision::Ranked& ranked : d_.hypotheses) {
            ranked.probability = std::exp(ranked.probability - all);
        }
        std::sort(d_.hypotheses.begin(), d_.hypotheses.end(), [&](const auto& a, const auto& b) {
            const double left = row(a.row).log_weight();
            const double right = row(b.row).log_weight();
            return left != right ? left > right : row(a.row).hypothesis.key() < row(b.row).hypothesis.key();
        });
        for (const auto& [r, probability] : d_.hypotheses) {
            const Row& own = row(r);
            if (own.hypothesis.kind == Kind::none) {
                none_ = r;
            }
            if (own.hypothesis.is_of_noise()) {
                d_.of_noise += probability;
                of_size_ += own.is_independent ? probability : 0.0;
                of_tails_ += own.has_tails ? probability : 0.0;
                of_holding_ += holds(own) ? probability : 0.0;
                if (!noise_ || (!holds(row(*noise_)) && holds(own))) {
                    noise_ = r;
                }
            } else if (own.hypothesis.kind == Kind::correction) {
                correction_ = correction_ ? correction_ : std::optional(r);
            } else {
                names_.push_back(r);
                of_names_ += leaves_noise(own) ? probability : 0.0;
            }
        }
    }

    // Whether its model is contradicted with the noise as it is stated.
    bool is_contradicted(const Row& own) const {
        return is_stated() && (own.fit.p_value < level_contradicted || own.fit.p_pattern < level_contradicted);
    }
    bool leaves_noise(const Row& own) const {
        return !is_stated() || (own.fit.p_value >= level_noise && own.fit.p_pattern >= level_contradicted);
    }
    bool is_rejected(const Row& own) const {
        return is_stated() && (own.fit.p_value < level_contradicted || own.fit.p_pattern < level_rejected);
    }
    // Rejected by little, where next to nothing else is probable: what comes nearest is then an answer, though not all.
    bool is_far_ahead(std::size_t r) const {
        constexpr double nearly_all = 0.9;
        const Fit& fit = row(r).fit;
        return fit.p_value >= level_rejected && fit.p_pattern >= level_rejected && d_.probability_of(r) >= nearly_all;
    }
    // Twice the logarithm of how much less probable than another.
    double behind(const Row& own, const Row& other) const { return 2.0 * (other.log_weight() - own.log_weight()); }

    // Whether what the study's model leaves may be noise of that kind: not far more than stated, and without a pattern.
    bool holds(const Row& of_noise) const {
        const double k = of_noise.noise;
        const Fit& fit = of_noise.fit;
        const bool has_pattern =
            fit.pattern_dof > 0 && gsl_cdf_chisq_Q(fit.pattern_chi2 / (k * k), fit.pattern_dof) < level_contradicted;
        const bool is_of_size = of_noise.is_independent && !of_noise.has_tails;
        return !is_stated() || (k <= (is_of_size ? most_noise : most_of_structure) && !has_pattern);
    }

    bool is_explained_as_stated() const {
        constexpr double surely = 0.8; // of errors with something in common, whatever chi2 says
        const bool is_common = noise_ && !row(*noise_).is_independent && d_.probability_of(*noise_) >= surely;
        return !is_common && none_ && !is_contradicted(row(*none_)) && ledger_.score() >= level_family;
    }
    bool is_adequate() const {
        constexpr double most = 0.5;
        return d_.as_stated || (noise_ && of_holding_ >= most);
    }

    void conclude_adequate() {
        d_.verdict = Verdict::adequate;
        const Row& leading = row(*noise_);
        const bool is_larger = is_stated() && !d_.as_stated && leading.hypothesis.kind == Kind::noise;
        d_.noise_factor = is_larger ? std::max(1.0, leading.noise_by_data.value_or(leading.noise)) : 1.0;
    }

    // Whether a name explains as much with no more numbers.
    bool is_outdone(const Row& own) const {
        return std::any_of(names_.begin(), names_.end(), [&](std::size_t r) {
            return row(r).fit.chi2 <= own.fit.chi2 && row(r).fit.numbers <= own.fit.numbers;
        });
    }

    // Whether a name may head the answer: its model is not rejected, and chance does not make as much too often.
    bool can_lead(std::size_t r) const {
        return !is_rejected(row(r)) && ledger_.chance(row(r).hypothesis.key()) < level_unexplained;
    }

    // A name that leaves noise does not vanish for one that leaves more, or that takes more numbers.
    bool is_first_of_its_size(std::size_t r) const {
        return can_lead(r) && leaves_noise(row(r)) &&
               std::none_of(names_.begin(), names_.end(), [&](std::size_t other) {
                   return can_lead(other) && leaves_noise(row(other)) && row(other).fit.numbers <= row(r).fit.numbers &&
                          behind(row(r), row(other)) >= margin;
               });
    }

    bool stands_beside(std::size_t r) const {
        const Row& own = row(r);
        const Row& first = row(*best_);
        const double distance = behind(own, first);
        const bool is_contradicted_itself = is_contradicted(own);
        // Where the best one leaves more than noise, another that does no better is no worse.
        if (distance < margin && (!is_contradicted_itself || !leaves_noise(first) || distance < 0.0)) {
            return true;
        }
        // Whatever such readings could not tell from the leading one stands beside it, whatever these say; unless it is
        // next to impossible, or they reject it by themselves, more clearly where the leading one leaves noise.
        const double rate = ledger_.rate(own.hypothesis.key(), first.hypothesis.key());
        const double most = (is_contradicted_itself ? (leaves_noise(first) ? 1.0 : 2.0) : impossible) * margin;
        if (rate < least_rate && distance <= most) {
            return true;
        }
        return is_first_of_its_size(r);
    }

    void collect_names() {
        if (names_.empty()) {
            return;
        }
        const auto leader = std::find_if(names_.begin(), names_.end(), [&](std::size_t r) { return can_lead(r); });
        best_ = leader != names_.end() ? *leader : names_[0];
        d_.names.push_back(*best_);
        for (const std::size_t r : names_) {
            const bool is_known = std::any_of(d_.names.begin(), d_.names.end(),
                                              [&](std::size_t other) { return effects_of(other) == effects_of(r); });
            if (!is_known && stands_beside(r) && !is_leader_and_more(r)) {
                d_.names.push_back(r);
            }
        }
    }

    // Whether it says what the leading name says, and more: that may be so, too.
    bool is_leader_and_more(std::size_t r) const {
        const auto own = effects_of(r);
        const auto leader = effects_of(*best_);
        return own.size() > leader.size() && std::includes(own.begin(), own.end(), leader.begin(), leader.end());
    }
    // Of the leading name, with more beside it or not.
    double probability_of_leader() const {
        double sum = d_.probability_of(*best_);
        for (const std::size_t r : names_) {
            sum += is_leader_and_more(r) ? d_.probability_of(r) : 0.0;
        }
        return sum;
    }

    // Names of the effects, sorted: another variant of one is no other name, but for an instrument; of wrong readings
    // alone which they are.
    std::vector<std::string> effects_of(std::size_t r) const {
        const auto& hypothesis = row(r).hypothesis;
        std::vector<std::string> list;
        for (const auto& term : hypothesis.terms) {
            const bool is_instrument = term.subject == hypotheses::of_readings && term.effect != "outlier";
            list.push_back(is_instrument || hypothesis.kind == Kind::readings ? term.effect + term.on : term.effect);
        }
        std::sort(list.begin(), list.end());
        return list;
    }

    // The same statement of the same thing: of instruments, or of the stiffness of one layer.
    bool says_the_same(const Row& correction, const Row& name) const {
        const auto& subjects = correction.hypothesis.subjects;
        return !subjects.empty() && std::all_of(subjects.begin(), subjects.end(), [&](const std::string& subject) {
            return std::any_of(name.hypothesis.terms.begin(), name.hypothesis.terms.end(),
                               [&](const auto& term) { return !subject.empty() && term.subject == subject; });
        });
    }

    // Why the correction is no answer; none: it is one.
    Reason why_not_located(Says needed) const {
        if (!correction_) {
            return Reason::nothing_explains;
        }
        const Row& own = row(*correction_);
        const std::string key = own.hypothesis.key();
        // Next to impossible beside a name it is no answer, though the name leaves more.
        const bool is_impossible = best_ && behind(own, row(*best_)) >= impossible * margin;
        if (is_rejected(own) || is_outdone(own) || is_impossible) {
            return Reason::nothing_explains;
        }
        if (ledger_.says(key) < needed) {
            return Reason::no_place;
        }
        if (ledger_.is_predicted_worse(key)) {
            return Reason::predicts_worse;
        }
        return d_.of_noise < little ? Reason::none : Reason::noise;
    }

    // The correction as the answer, or why it is none; then it stands as what comes nearest.
    Reason locate(Says needed) {
        d_.correction = correction_;
        const Reason why = why_not_located(needed);
        if (why == Reason::none) {
            d_.verdict = Verdict::located;
            d_.reason = Reason::none;
            d_.nearest = std::move(d_.names);
            d_.names.clear();
            d_.model = correction_;
            d_.leaves_more_than_noise = !leaves_noise(row(*correction_));
            d_.noise_factor = factor_of(row(*correction_));
        }
        return why;
    }

    double factor_of(const Row& own) const {
        return is_stated() && own.fit.dof > 0 && own.fit.p_value < level_noise ? std::sqrt(own.fit.chi2 / own.fit.dof)
                                                                               : 1.0;
    }

    void conclude_unexplained(Reason reason) {
        const Reason why = locate(Says::between_places);
        if (why == Reason::none) {
            return;
        }
        d_.verdict = Verdict::unexplained;
        d_.reason = reason == Reason::nothing_explains ? why : reason;
        if (why == Reason::predicts_worse) { // it comes nearest
            d_.model = correction_;
        }
        d_.nearest = std::move(d_.names);
        d_.names.clear();
    }

    void decide_on_names() {
        collect_names();
        if (!best_) {
            d_.leaves_more_than_noise = true;
            d_.noise_factor = none_ ? factor_of(row(*none_)) : 1.0;
            conclude_unexplained(Reason::nothing_explains);
            return;
        }
        const Row& first = row(*best_);
        d_.model = best_;
        d_.leaves_more_than_noise = !leaves_noise(first);
        d_.noise_factor = factor_of(first);
        const double chance = ledger_.chance(first.hypothesis.key());
        if (is_rejected(first) && !is_far_ahead(*best_)) { // so are all others
            conclude_unexplained(Reason::nothing_explains);
            return;
        }
        if (chance >= level_unexplained) {
            conclude_unexplained(Reason::weak_evidence);
            return;
        }
        // Names stay that are more probable than noise: together those that leave noise, else the first by three times.
        const double of_rejected = is_contradicted(first) ? 0.0 : probability_of_leader() / 3.0;
        const double of_names = leaves_noise(first) ? of_names_ : of_rejected;
        if (of_size_ - said_of_tails(first) >= doubtful && of_names <= d_.of_noise) {
            conclude_unexplained(Reason::noise);
            return;
        }
        d_.verdict = Verdict::ambiguous;
        d_.reason = reason_against(first, chance);
        if (d_.reason == Reason::none) {
            d_.verdict = Verdict::cause_named;
        }
        if (gives_way(first)) {
            return;
        }
        if (is_rival(first)) {
            d_.correction = correction_;
        }
        name_causes();
    }

    // Whether a name leaves noise and may head the answer. Enough wrong readings explain anything: next to impossible
    // beside a correction, they hold nothing up.
    bool does_a_name_leave_noise() const {
        return std::any_of(names_.begin(), names_.end(), [&](std::size_t r) {
            const bool is_excuse = row(r).hypothesis.kind == Kind::readings && correction_ &&
                                   !is_outdone(row(*correction_)) &&
                                   behind(row(r), row(*correction_)) >= impossible * margin;
            return can_lead(r) && leaves_noise(row(r)) && !is_excuse;
        });
    }

    // Where no name leaves noise, the first gives way to a correction that is clearly more probable: as the answer or,
    // where what was left out speaks against it, as what comes nearer. True: the answer is written.
    bool gives_way(const Row& first) {
        if (!correction_ || does_a_name_leave_noise()) {
            return false;
        }
        const Row& other = row(*correction_);
        const double ahead = behind(first, other);
        if (ahead < margin) {
            return false;
        }
        // A name that is next to impossible beside it is no answer, even where only differences of places are known.
        const double most = (first.fit.at_end ? hardly_possible : impossible) * margin;
        const bool is_impossible = ahead >= most && (leaves_noise(other) || !says_the_same(other, first));
        const Reason why = locate(is_impossible ? Says::between_places : Says::at_places);
        if (why == Reason::none) {
            return true;
        }
        if (why == Reason::predicts_worse || is_impossible) {
            conclude_unexplained(Reason::nothing_explains);
            return true;
        }
        return false;
    }

    // Noise that makes single readings err far does not contradict that these do.
    double said_of_tails(const Row& first) const { return first.hypothesis.kind == Kind::readings ? of_tails_ : 0.0; }

    Reason reason_against(const Row& first, double chance) const {
        // One right answer in twenty leaves as much: no reason where next to nothing else is probable.
        if (d_.leaves_more_than_noise && (is_contradicted(first) || probability_of_leader() < 1.0 - little)) {
            return Reason::leaves_more_than_noise;
        }
        if (d_.names.size() > 1) {
            return Reason::several_names;
        }
        if (d_.of_noise - said_of_tails(first) >= little) {
            return Reason::noise;
        }
        if (first.fit.at_end) {
            return Reason::at_end;
        }
        if (is_rival(first)) {
            return Reason::correction;
        }
        if (first.hypothesis.kind == Kind::effects) {
            return Reason::two_effects;
        }
        std::vector<std::string> subjects;
        for (const auto& term : first.hypothesis.terms) {
            subjects.push_back(term.subject);
        }
        if (ledger_.beyond(first.hypothesis.key(), subjects) < level_finds_more) {
            return Reason::finds_more;
        }
        return chance < level_evidence ? Reason::none : Reason::weak_evidence;
    }

    // A correction that is about as probable or, by Akaike's criterion, explains as much for what it takes and is not
    // far less probable, knows a place, and says something else. Where it is more probable than the name, that it knows
    // how places differ is enough.
    bool is_rival(const Row& first) const {
        if (!correction_) {
            return false;
        }
        const Row& own = row(*correction_);
        const auto akaike = [](const Row& of) { return of.fit.chi2 + 2.0 * of.fit.numbers; };
        const double distance = behind(own, first);
        const bool is_near =
            distance < margin || (distance < impossible * margin && akaike(own) - akaike(first) < margin);
        return is_near && !is_outdone(own) && !is_rejected(own) && !says_the_same(own, first) &&
               ledger_.says(own.hypothesis.key()) >= (distance < 0.0 ? Says::between_places : Says::at_places);
    }

    // The effects of the names, best first; within one by what each explains alone.
    void name_causes() {
        const auto alone = [&](const hypotheses::Term& term) {
            double chi2 = INFINITY;
            for (const std::size_t r : names_) {
                const auto& terms = row(r).hypothesis.terms;
                if (terms.size() == 1 && terms[0].effect == term.effect && terms[0].on == term.on) {
                    chi2 = std::min(chi2, row(r).fit.chi2);
                }
            }
            return chi2;
        };
        for (const std::size_t r : d_.names) {
            auto terms = row(r).hypothesis.terms;
            std::stable_sort(terms.begin(), terms.end(),
                             [&](const auto& a, const auto& b) { return alone(a) < alone(b); });
            add_causes(terms);
        }
    }

    void add_causes(const std::vector<hypotheses::Term>& terms) {
        for (const auto& term : terms) {
            if (std::find(d_.causes.begin(), d_.causes.end(), term.effect) == d_.causes.end()) {
                d_.causes.push_back(term.effect);
            }
        }
    }

    // A fault seen in the readings before any model is the first cause.
    void add_premise() {
        if (!d_.premise) {
            return;
        }
        d_.hypotheses.insert(d_.hypotheses.begin(), {*d_.premise, 1.0});
        for (const auto& term : row(*d_.premise).hypothesis.terms) {
            std::erase(d_.causes, term.effect);
            d_.causes.insert(d_.causes.begin(), term.effect);
        }
        if (d_.verdict == Verdict::adequate) {
            d_.verdict = Verdict::cause_named;
        }
    }

    // No name stands alone beside another that another premise makes about as probable.
    void weigh_elsewhere() {
        const auto& other = ledger_.elsewhere();
        if (d_.verdict == Verdict::cause_named && other && other->probability > little) {
            d_.verdict = Verdict::ambiguous;
            d_.reason = Reason::other_premise;
            add_causes(other->terms);
            if (d_.premise) {
                d_.hypotheses.front().probability = 1.0 - other->probability;
            }
        }
    }

    const Ledger& ledger_;
    Decision d_;
    std::vector<std::size_t> names_; // most probable first
    double of_size_ = 0.0;           // probability of noise whose readings have nothing in common
    double of_tails_ = 0.0;          // of such with heavy tails
    double of_holding_ = 0.0;        // of noise that may be: not far larger than stated, without a pattern
    double of_names_ = 0.0;          // of names that leave noise
    std::optional<std::size_t> none_, noise_, correction_, best_;
};

} // namespace

bool Decision::is_noise_possible() const {
    return !as_stated && noise && of_noise >= little;
}

double Decision::probability_of(std::size_t row) const {
    for (const Ranked& ranked : hypotheses) {
        if (ranked.row == row) {
            return ranked.probability;
        }
    }
    return 0.0;
}

Decision decide(const Ledger& ledger) {
    return Decider(ledger).decide();
}

} // namespace explore::diagnose
