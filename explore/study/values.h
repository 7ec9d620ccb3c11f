// Numbers of a study at other values, by their paths.
#pragma once

#include "study/study.h"

namespace explore::study {

struct NamedValue {
    std::string name;
    double value = 0.0; // in the unit of the file
};

// Of "base.k1=900". Throws pave::Error at `place`.
NamedValue named_value(std::string_view text, const pave::Place& place);
// Of "base.k1=900, base.k2=0.5".
std::vector<NamedValue> named_values(std::string_view text, const pave::Place& place);

// The numbers of a study that have a name: of its own model the parameters.
std::vector<std::string> names_of_numbers(const Study& study);
// One of them. Throws pave::Error at `place` for a name that there is not.
pave::pavement::Parameter number_named(const Study& study, const std::string& name, const pave::Place& place);

// The numbers with these paths, as the study may have them at other values: each once, and none that follows others.
// Effects among them are modelled at their null size too. Throws pave::Error at `place`.
std::vector<pave::pavement::Parameter> changeable(Study& study, const std::vector<std::string>& names,
                                                  const pave::Place& place);

// A study and its model at other values. Parameters change on the mesh that the study has, as in a search; for
// other numbers the study itself is another one.
struct ChangedStudy {
    Study study;
    pave::pavement::Case at;
};
// Throws pave::Error at `place` for a name that there is not and a value out of the range of its key.
ChangedStudy with_values(Study study, const std::vector<NamedValue>& values, const pave::Place& place);

} // namespace explore::study
