// What the fuzz targets share: a file of the given bytes, and which ends are right.
#pragma once

#include "base/error.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

namespace fuzz {

// A folder of this process in memory, removed when it ends.
class Folder {
public:
    Folder() : path_("/dev/shm/pavescape-fuzz-" + std::to_string(getpid())) {
        std::filesystem::create_directories(path_);
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    std::string path(const std::string& name) const { return path_ + "/" + name; }
    std::string write(const std::string& name, std::string_view text) const {
        std::ofstream(path(name), std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
        return path(name);
    }

private:
    std::string path_;
};

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
    return {reinterpret_cast<const char*>(data), size};
}

// Reading ends well, or with a message for people that names the file, or the option that was wrong. Any other
// exception is a fault.
template <class Read>
void expect_message(const Read& read, std::string_view option = "/dev/shm/") {
    try {
        read();
    } catch (const pave::Error& error) {
        const std::string_view words = error.what();
        if (words.find("/dev/shm/") == std::string_view::npos && words.find(option) == std::string_view::npos) {
            std::abort(); // of what?
        }
    }
}

} // namespace fuzz
