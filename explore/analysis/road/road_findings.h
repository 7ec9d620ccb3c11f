// The findings of a road taken as one experiment, in words.
#pragma once

#include "analysis/road/road.h"

namespace explore::analysis {

// The name of a common parameter; of a section also from where to where it lies.
std::string common_name(const RoadResult& result, const CommonParameter& parameter);

// Why a station does not belong.
std::string outlier_words(const RoadResult& result, const RoadOutlier& outlier);

// The distance over which stations are similar, by the length of a course along a stretch; a length beyond that of the
// stretch cannot be known.
std::string course_length_words(double length_m, double stretch_m);

// Most important first; without what a survey says of files, drops and sensors (survey_findings.h).
std::vector<std::string> findings_of(const RoadResult& result);

} // namespace explore::analysis
