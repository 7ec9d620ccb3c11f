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

// A folder holds one road. Throws pave::Error where FOLDER/NAME.json is of other files with other content.
void refuse_other_road(const std::string& folder, const std::string& name, const RoadFiles& road);

// The study that FOLDER/NAME.json was made with; empty: there is no such file, or it took none.
std::string study_of_result(const std::string& folder, const std::string& name);
// A line on standard error where the result that stands there now was made with another study than the one before.
void say_what_was_replaced(const std::string& folder, const std::string& name, const std::string& before);

} // namespace explore::analysis
