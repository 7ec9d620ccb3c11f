// A study from the texts that it was made of.
#pragma once

#include "study/study.h"

namespace explore::study {

// The study again from Study::inputs, whatever its files hold by now.
Study kept_study(const std::string& file, std::shared_ptr<const std::vector<data::InputFile>> inputs);

} // namespace explore::study
