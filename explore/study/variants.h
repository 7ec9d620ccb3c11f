// The ways in which an effect may be missing from a study's model.
#pragma once

#include "study/study.h"

namespace explore::study {

// An effect with its options: what `diagnose` may add to a study.
struct Variant {
    pave::pavement::AppliedEffect applied; // at its null size
    std::string on; // what its options name, in words: "fwd, deflection"; empty: the effect's own choice
    std::optional<double> typical{}; // a size that is seen in practice; nothing: the effect's
};

// Its size as a parameter: "NAME.size" over its prior range, from its null value.
problem::Axis size_axis(const pave::pavement::Effect& effect);

// Every effect of the catalogue that the study can have and does not have yet: where it takes a load, a quantity or a
// reading, on each of those with readings that are fitted; then on what it acts on by itself. Effects named in
// `without` are left out. is_one_of_many: the study is a station of a road, where an instrument with one reading has
// others at other stations; else it is left to that reading's error.
std::vector<Variant> variants(const Study& study, const std::vector<std::string>& without, bool is_one_of_many = false);

// The study with these effects, the size of each a further parameter ("NAME.size", over its prior range) after the
// study's own.
Study with_free_effects(Study study, const std::vector<Variant>& variants);

// The study file's text with these parameter values in place of its own, with the effects among the parameters as
// [[effects]] and [[parameters]], with the number of load steps that was chosen and the bottom of its section, so that
// it reads the same, and with data files found from `folder`; everything else to the letter. extended: of
// with_free_effects, values: of all its parameters, file units.
std::string extended_text(const Study& extended, const std::vector<Variant>& variants,
                          const std::vector<double>& values, const std::string& folder);

} // namespace explore::study
