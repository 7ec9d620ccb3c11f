// The files of a road, and the folder that its results lie in.
#pragma once

#include "data/fwd.h"

namespace explore::analysis {

struct RoadFiles {
    std::vector<std::string> names;
    std::vector<data::FwdFile> files;
    std::vector<data::InputFile> inputs; // of all that was read, the list of columns included
    std::string content;                 // a hash of what the files hold, whatever they are called
};

// columns: as data::read_column_map takes it; empty: the columns' own names. layers: a table of thicknesses, or empty.
// Throws pave::Error.
RoadFiles read_road(const std::vector<std::string>& names, const std::string& columns, const std::string& layers);

// The study that FOLDER/NAME.json was made with; empty: there is no such file, or it took none. A folder holds one
// road: throws pave::Error where that file is of other files with other content.
std::string earlier_study(const std::string& folder, const std::string& name, const RoadFiles& road);
// A line on standard error where a result with the study `now` has taken the place of one with another.
void say_what_was_replaced(const std::string& folder, const std::string& name, const std::string& before,
                           const std::string& now);

} // namespace explore::analysis
