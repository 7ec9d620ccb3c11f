#include "run/files.h"

#include "base/error.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <stdexcept>
#include <unistd.h>

namespace explore::run {

void write_file(const std::string& folder, const std::string& name, const std::string& text) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const auto path = std::filesystem::path(folder) / name;
    // Of its own: another process may be writing the same file.
    const auto part = std::filesystem::path(folder) / fmt::format("{}.{}.part", name, getpid());
    const auto remove_part = [&] {
        std::error_code ignored;
        std::filesystem::remove(part, ignored);
    };
    {
        std::ofstream stream(part, std::ios::binary);
        if (!stream) {
            throw pave::Error({.file = path.string()}, "cannot be written", std::strerror(errno),
                              "a folder that can be written (--out)");
        }
        stream << text;
        stream.close();
        if (!stream) {
            const std::string reason = std::strerror(errno);
            remove_part();
            throw std::runtime_error(fmt::format("{}: no room to write it: {}", path.string(), reason));
        }
    }
    std::filesystem::rename(part, path, error);
    if (error) {
        remove_part();
        throw pave::Error({.file = path.string()}, "cannot be written", error.message(), "another folder (--out)");
    }
}

TemporaryFolder::TemporaryFolder() {
    std::error_code none;
    std::string name = (std::filesystem::temp_directory_path(none) / "pavescape-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
        throw pave::Error({.file = name}, "no temporary folder can be made", std::strerror(errno),
                          "a folder TMPDIR that can be written");
    }
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

} // namespace explore::run
