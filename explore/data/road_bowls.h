// The bowls of a road's stations, which tell of each other.
#pragma once

#include "base/outcome.h"
#include "data/deflection_bowl.h"

namespace explore::data {

// Of each station as bowls_of(), with what the road tells: by what its drops scatter (where five groups of repeated
// drops or more do, of a sensor eight), in which steps its files are written, and that the first of two drops seats the
// plate, as it does at most of the stations where three tell.
std::vector<pave::Outcome<StationBowls>> bowls_of_road(const std::vector<const FwdStation*>& stations,
                                                       DropChoice choice = {});

// Of these; nothing: too few.
std::optional<RepeatScatter> scatter_of(const std::vector<pave::Outcome<StationBowls>>& stations);

} // namespace explore::data
