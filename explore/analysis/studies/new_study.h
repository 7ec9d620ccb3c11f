// A study to start from, as text: of an example, or of a station of an FWD file.
#pragma once

#include "analysis/studies/new_section.h"
#include "data/fwd.h"

#include <string>

namespace explore::analysis {

struct NewStudy {
    std::string study;    // TOML
    std::string readings; // CSV, in the file NAME.csv beside it
    // Further files beside it: name and text.
    std::vector<std::pair<std::string, std::string>> histories{};
};

struct NewOptions {
    std::vector<NewLayer> layers{};  // empty: asphalt, base, subgrade
    bool is_linear = false;          // granular layers too
    std::vector<double> gauges_mm{}; // of example_study: depths of strain gauges under a wheel; empty: a bowl
};

// name: of the study and its readings, of letters, digits and . _ -
// Fits as it stands: the bowl is that of the example's layers, with noise of 2 %; strains of gauges are those of a
// half-space.
NewStudy example_study(const std::string& name, const NewOptions& options = {});

// All load levels of the station, a load each; the noise of every reading by how the drops of the file repeat
// (study/station.h). Layers that are not stated are a template: the file does not say what they are. Asphalt has its
// modulus at the file's temperature (data/asphalt_temperature.h). The subgrade's range is a quarter
// to four times the surface modulus at the farthest sensor (data/bowl_indices.h). station: name or chainage; empty: the
// first that can be used. Throws pave::Error where there is no such station, and for one whose readings cannot be
// right.
NewStudy study_of_station(const std::string& name, const data::FwdFile& file, const std::string& path,
                          const std::string& station, const NewOptions& options = {});

// The whole pulses of the station's drops, a load each with its history: one reading a millisecond of every sensor.
// Throws pave::Error where no drop has a history.
NewStudy study_of_pulses(const std::string& name, const data::FwdFile& file, const std::string& path,
                         const std::string& station, const NewOptions& options = {});

// The name of a station in a file name: its letters, digits and . _ -
std::string plain_name(const std::string& name);

} // namespace explore::analysis
