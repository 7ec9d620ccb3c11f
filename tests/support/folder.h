// A folder of this process's own: tests run side by side.
#pragma once

#include <filesystem>
#include <string>
#include <unistd.h>

namespace test {

// With a slash at the end; removed when the process ends.
inline const std::string& own_folder() {
    static const struct Folder {
        std::string path =
            (std::filesystem::temp_directory_path() / ("pavescape-test-" + std::to_string(::getpid()))).string() + "/";
        Folder() { std::filesystem::create_directories(path); }
        ~Folder() {
            std::error_code ignored;
            std::filesystem::remove_all(path, ignored);
        }
    } folder;
    return folder.path;
}

} // namespace test
