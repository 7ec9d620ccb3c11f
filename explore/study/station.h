// A study put to a road: the same section and parameters at every FWD station, under the station's own load.
#pragma once

#include "data/deflection_bowl.h"
#include "study/study.h"

namespace explore::study {

// A study that a survey can use: one load of type plate, which comes first, and no parameter of a load; the other loads
// are kept for the outputs. Its data files are not read. Throws pave::Error.
Study load_survey_study(const std::string& file);

// Standard deviation of a reading D, the mean of n drops, in um. repeatability: standard deviation of a reading over
// repeated drops, as a share of it; of a sensor whose drops contradict each other their own where that is more.
//     sqrt(repeatability^2 D^2 / n + r + (1 um)^2 + (0.01 D)^2),
// r what rounding to the steps of the file adds (data/resolution.h), the last two half of what a
// sensor is good to (2 um + 2 %, taken for two standard deviations): a sensor's error in every drop alike.
double bowl_sigma_um(const data::BowlReading& reading, double repeatability);

// The survey's study with the station's own layers under its own loads: one plate a bowl, and its deflections, whose
// noise is the above unless the study states noise_relative or noise_floor. Where a thickness that the station states
// is a parameter, it is its prior (its standard deviation the station's, else the study's). repeatability: nothing: not
// known. Throws pave::Error where the readings do not fit the model.
Study station_study(const Study& survey, const data::FwdStation& station,
                    const std::vector<const data::DeflectionBowl*>& bowls, std::optional<double> repeatability);

// The survey's outputs alone, with the station's own layers, its plate with the radius and the pressure of the bowl.
// The depth of an output keeps its share of the layer that it lies in.
Study station_outputs(const Study& survey, const data::FwdStation& station, const data::DeflectionBowl& bowl);

} // namespace explore::study
