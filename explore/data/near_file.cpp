#include "data/near_file.h"

#include "base/error.h"

#include <filesystem>
#include <vector>

namespace explore::data {

std::string near_file_words(const std::string& path) {
    const std::filesystem::path wanted(path);
    const std::filesystem::path folder = wanted.has_parent_path() ? wanted.parent_path() : std::filesystem::path(".");
    std::error_code error;
    std::vector<std::string> names;
    constexpr std::size_t most = 5000; // entries that are looked at
    for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end && names.size() < most;
         entry.increment(error)) {
        if (entry->path().extension() == wanted.extension()) {
            names.push_back(entry->path().filename().string());
        }
    }
    const std::string near = pave::nearest_name(wanted.filename().string(), names);
    return near.empty() ? "" : ", did you mean \"" + (wanted.parent_path() / near).string() + "\"?";
}

} // namespace explore::data
