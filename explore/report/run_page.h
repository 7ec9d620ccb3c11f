// The report of a run's folder, written.
#pragma once

#include <string>
#include <vector>

namespace explore::report {

struct WrittenPage {
    std::string file;
    std::size_t bytes = 0;
};
// commands: those that leave a result. out: the file; empty: report.html in the folder. Throws as read_run_folder() and
// where it cannot be written.
WrittenPage write_page_of(const std::string& folder, const std::vector<std::string>& commands, const std::string& out);

} // namespace explore::report
