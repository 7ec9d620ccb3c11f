// Premises of a diagnosis that the study's model suggests: two instruments exchanged of which no bowl shows it,
// readings that a wrong one makes look exchanged, a section without a floor.
#pragma once

#include "analysis/diagnose/diagnose.h"

#include <functional>
#include <optional>

namespace explore::analysis {

// Of one study; nothing: interrupted.
using DiagnoseBy = std::function<std::optional<DiagnoseResult>(const Premises&)>;

// The answer by the most probable premises. study: as it was read; seen: its answer by the faults that its readings
// show. Others are computed where they may be more probable. Nothing: interrupted.
std::optional<DiagnoseResult> weigh_premises(const study::Study& study, DiagnoseResult seen, const DiagnoseBy& by);

} // namespace explore::analysis
