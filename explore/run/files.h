// Files of a run's folder.
#pragma once

#include <string>

namespace explore::run {

// Writes a file at once: whoever reads it meets the old text or the new one, never a part. The folder is created when
// missing. Throws pave::Error where it cannot be written, std::runtime_error where there is no room.
void write_file(const std::string& folder, const std::string& name, const std::string& text);

// A folder of this process, removed with all in it at the end. Throws pave::Error where none can be made.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::string& path() const { return path_; }

private:
    std::string path_;
};

} // namespace explore::run
