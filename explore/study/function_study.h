// A study whose model is a function that the caller has, as Python does: no file can name it.
#pragma once

#include "external/simulator.h"
#include "study/study.h"

namespace explore::study {

// study_of(), with this model in place of [model]; its description() belongs to the hash of the study. nullptr: what
// the text says.
Study study_with(std::shared_ptr<const external::Simulator> function, std::string text, const std::string& name,
                 const std::map<std::string, std::string>& files);

} // namespace explore::study
