// Starting points of searches: values given by the user, points of an earlier run or of a file.
#pragma once

#include "study/study.h"

namespace explore::analysis {

// Unit coordinates of "base.k1=900, base.k2=0.5"; what is not named begins at the study's own value. Throws pave::Error
// for a name that is no parameter of the study and for a value out of its bounds.
std::vector<double> start_of(const study::Study& study, const std::string& text);

// At most so many points of a run's folder or of a file of parameter sets: the lowest that lie within the study's
// bounds and apart from each other; where no misfits are stated, points spread over the list. Throws pave::Error where
// there are none.
std::vector<std::vector<double>> starts_from(const study::Study& study, const std::string& folder_or_file,
                                             std::size_t most);

} // namespace explore::analysis
