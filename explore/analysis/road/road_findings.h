// The findings of a road taken as one experiment, in words.
#pragma once

#include "analysis/road/road.h"

namespace explore::analysis {

// Of a common parameter: its name, and of a section's from where to where.
std::string common_name(const RoadResult& result, const CommonParameter& parameter);

// Why a station does not belong.
std::string outlier_words(const RoadResult& result, const RoadOutlier& outlier);

// Most important first; without what a survey says of files, drops and sensors (survey_findings.h).
std::vector<std::string> findings_of(const RoadResult& result);

} // namespace explore::analysis
