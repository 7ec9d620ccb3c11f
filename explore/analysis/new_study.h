// A study to start from, as text: of an example, or of a station of an FWD file.
#pragma once

#include "data/fwd.h"

#include <string>

namespace explore::analysis {

struct NewStudy {
    std::string study;    // TOML
    std::string readings; // CSV, in the file NAME.csv beside it
    // Further files beside it: name and text.
    std::vector<std::pair<std::string, std::string>> histories{};
};

// name: of the study and its readings, of letters, digits and . _ -
// Fits as it stands: the readings are those of a section like it, with noise of 2 %.
NewStudy example_study(const std::string& name);

// All load levels of the station, a load each; the noise of every reading by how the drops of the file repeat
// (study/station.h). The layers are a template: the file does not say what they are. The subgrade's range is a quarter
// to four times the surface modulus at the farthest sensor (data/bowl_indices.h). station: name or chainage; empty: the
// first that can be used. Throws pave::Error where there is no such station, and for one whose readings cannot be
// right.
NewStudy study_of_station(const std::string& name, const data::FwdFile& file, const std::string& path,
                          const std::string& station);

// The whole pulses of the station's drops, a load each with its history: one reading a millisecond of every sensor.
// Throws pave::Error where no drop has a history.
NewStudy study_of_pulses(const std::string& name, const data::FwdFile& file, const std::string& path,
                         const std::string& station);

// What a station is called in a file name: its letters, digits and . _ -
std::string plain_name(const std::string& name);

} // namespace explore::analysis
