// Hypotheses of what the model may lack, by everything that is known of each.
//
// Hypotheses are compared by their probability, beforehand times marginal likelihood with the size of the noise unknown
// (hypotheses/evidence.h), by whether noise explains what they leave, and by what they predict of readings left out:
//
// - `adequate`: noise as stated explains the study's model, or hypotheses on the noise alone that hold have most of the
//   probability.
// - A name stands in the answer where no other is far more probable (20 to 1), where the readings could not tell it
//   from the most probable one, and, of one effect that leaves noise, where only a hypothesis with more numbers is.
// - `cause-named`: one name that leaves noise, whose sizes' intervals end within their ranges, and that no correction
//   rivals: none that is about as probable, or explains as much for what it takes, and says something of a place, or
//   is more probable and says how places differ, and that says something else.
// - `located`: no name leaves noise, and a correction does at places that it knows, which is not rejected itself,
//   predicts what was left out no worse, and is not outdone by a hypothesis with fewer numbers.
// - `ambiguous`: names that do not stand alone, or one beside another premise. `unexplained`: the rest; where noise of
//   another size is possible (10 %) and no less probable than the names that leave noise, too, with the names as what
//   comes nearest.
#pragma once

#include "diagnose/ledger.h"

namespace explore::diagnose {

enum class Verdict { adequate, cause_named, ambiguous, unexplained, located };
inline constexpr std::string_view verdict_names[] = {"adequate", "cause-named", "ambiguous", "unexplained", "located"};

// Reasons why a name does not stand alone, the most telling first; of `unexplained` why.
enum class Reason {
    none,
    leaves_more_than_noise, // what comes nearest
    several_names,
    noise,            // it may as well be noise of another kind or size
    at_end,           // of the range of a size
    correction,       // explains as much
    two_effects,      // it takes two
    finds_more,       // a correction does, beside the name
    weak_evidence,    // chance makes as much, too often
    nothing_explains, // no hypothesis that was tried
    no_place,         // a correction explains, but knows no place
    predicts_worse,   // a correction explains, but what was left out speaks against it
    other_premise     // by which something else is about as probable
};

struct Decision {
    Verdict verdict = Verdict::adequate;
    Reason reason = Reason::none;
    struct Ranked {
        std::size_t row = 0; // of the ledger
        double probability = 0.0;
    };
    std::vector<Ranked> hypotheses;        // that were tried, and premises; most probable first
    std::vector<std::size_t> names;        // rows of the answer, most probable first
    std::vector<std::size_t> nearest;      // rows that come nearest, where there is no name in the answer
    std::optional<std::size_t> premise;    // row: seen before any model
    std::optional<std::size_t> noise;      // row: the most probable of those on the noise
    bool as_stated = false;                // noise as it is stated explains the study's model
    std::optional<std::size_t> correction; // row: the answer, a rival, or what comes nearest
    std::optional<std::size_t> model;      // row whose model is the answer or comes nearest; none: the study's
    std::vector<std::string> causes;       // effects, most probable first
    bool leaves_more_than_noise = false;   // the model
    double noise_factor = 1.0;             // by which the stated noise would have to be larger; 1 where it need not
    double of_noise = 0.0;                 // probability that nothing is wrong but noise

    // Whether noise of another size or kind is probable enough to be said beside a name.
    bool is_noise_possible() const;
    bool is_located() const { return verdict == Verdict::located; }
    double probability_of(std::size_t row) const;
};

// The study's model is contradicted below this, by any one test.
inline constexpr double level_contradicted = 0.005;
inline constexpr double level_family = 0.01; // of the largest score
// Evidence is due to chance this rarely where a cause is named.
inline constexpr double level_evidence = 0.01;
// Twice the logarithm of how much more probable one hypothesis is than another that does not stand beside it.
inline constexpr double margin = 6.0;

Decision decide(const Ledger& ledger);

} // namespace explore::diagnose
