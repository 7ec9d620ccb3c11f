// The findings of a road taken as one experiment, in words.
#pragma once

#include "analysis/road/road.h"

namespace explore::analysis {

// Of a common parameter: its name, and of a section's from where to where.
std::string common_name(const RoadResult& result, const CommonParameter& parameter);

// Why a station does not belong.
std::string outlier_words(const RoadResult& result, const RoadOutlier& outlier);

// Over what distance stations are similar, by the length of a course along a stretch; beyond the stretch nothing tells
// it.
std::string course_length_words(double length_m, double stretch_m);

// Most important first; without what a survey says of files, drops and sensors (survey_findings.h).
std::vector<std::string> findings_of(const RoadResult& result);

} // namespace explore::analysis
