// Hypotheses on data: the model as it is with noise of some kind, or something that the model lacks.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace explore::hypotheses {

enum class Kind {
    none,      // nothing is wrong, the noise as stated
    noise,     // nothing but the noise: its size, errors that readings share, heavy tails
    readings,  // single readings, one or several
    effect,    // one of the catalogue
    effects,   // two
    layout,    // of the sensors, or of the file
    correction // smooth, of the model or of what it is compared with
};
inline constexpr std::string_view kind_names[] = {"none",    "noise",  "readings",  "effect",
                                                  "effects", "layout", "correction"};

// Something that changes what is computed: an effect on what it acts on, or a wrong reading.
struct Term {
    std::string effect;  // "outlier" of readings
    std::string on;      // "": what it always acts on
    std::string subject; // layer whose stiffness is all that it changes; "readings": what instruments say; "": other
};
inline constexpr std::string_view of_readings = "readings";

struct Hypothesis {
    Kind kind = Kind::none;
    std::string name;
    std::vector<Term> terms{};           // of effects and readings
    std::vector<std::string> subjects{}; // of a correction: as of terms

    // The same for the same thing, whatever order hypotheses are found in.
    std::string key() const { return std::string(kind_names[static_cast<int>(kind)]) + ": " + name; }
    bool is_of_noise() const { return kind == Kind::none || kind == Kind::noise; }
    // Whether it names a cause.
    bool is_name() const { return !is_of_noise() && kind != Kind::correction; }
};

// How many there are of each kind: what shares its probability beforehand.
struct Counts {
    std::size_t readings = 0, effects = 0, channels = 0;
};

// Probability beforehand, its logarithm: half of the cases have nothing wrong but noise; of the others most lack one
// effect, and each further wrong reading is as rare as another. variants: of the effect (of both, multiplied);
// bad: how many readings.
double log_prior(Kind kind, const Counts& counts, std::size_t variants, std::size_t bad);
// Of what errors are like, beside their size.
double log_prior_of_structure(std::string_view key, const Counts& counts);

} // namespace explore::hypotheses
