// Readings that could be taken next: what an engineer could add to a study.
#pragma once

#include "study/study.h"

namespace explore::study {

// Surface deflections at the usual offsets, vertical strains in every layer below the first (gauge 75 mm), the
// horizontal strain at the bottom of the first, the vertical stress at the top of the last, under every load; and the
// deflections under every plate with half as much pressure again: as half as much again of a fitted pressure,
// not of one that is known. Of these what the study says is possible. Readings that the study has are left out, but for
// those that are requested again, by their row: another instrument may take them. The study with all these in place of
// its readings: their values mean nothing.
Study candidates(const Study& study, const std::vector<std::size_t>& again = {});

// Standard deviation taken for a candidate of this reading [SI]: deflection 2 % and 2 um (the accuracy commonly
// required of FWD geophones), strain 5 % and 10 microstrain, stress 10 % and 2 kPa.
double candidate_noise(pave::pavement::Quantity quantity, double value);

} // namespace explore::study
