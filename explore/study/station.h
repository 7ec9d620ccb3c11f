// A study put to a road: the same section and parameters at every FWD station, under the station's own load.
#pragma once

#include "data/deflection_bowl.h"
#include "study/study.h"

namespace explore::study {

// A study that a survey can use: one load of type plate, which is the only one kept, and no parameter of a load. Its
// data files are not read. Throws pave::Error.
Study load_survey_study(const std::string& file);

// The survey's study with the station's plate, pressure and deflections. Throws pave::Error where they do not fit the
// model.
Study station_study(const Study& survey, const data::FwdStation& station, const data::DeflectionBowl& bowl);

} // namespace explore::study
