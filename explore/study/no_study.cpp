#include "study/no_study.h"

#include "base/error.h"
#include "data/fwd.h"
#include "data/reading.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::study {

void refuse_deep_keys(const std::string& text, const std::string& file) {
    constexpr std::ptrdiff_t most_parts = 1000;
    int line = 1;
    for (std::size_t begin = 0; begin < text.size(); ++line) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        if (std::count(text.begin() + static_cast<std::ptrdiff_t>(begin),
                       text.begin() + static_cast<std::ptrdiff_t>(end), '.') > most_parts) {
            throw pave::Error({.file = file, .line = line}, "a line with so many full stops is no key or value", {},
                              fmt::format("at most {}", most_parts));
        }
        begin = end + 1;
    }
}

void refuse_readings(const std::string& text, const std::string& file) {
    const auto formats = data::fwd_formats();
    const auto format =
        std::find_if(formats.begin(), formats.end(), [&](const auto& f) { return f.recognises(text, {}); });
    if (format != formats.end()) {
        throw pave::Error({.file = file}, "this is a file of FWD readings, not a study", std::string(format->name),
                          "a study (TOML); survey and road take FWD files (survey FILE --study STUDY), new --from FILE "
                          "--station S makes a study of a station");
    }
    if (text.find(data::measurement_header()) != std::string::npos) {
        throw pave::Error({.file = file}, "this is a file of readings, not a study", "a table of readings",
                          "a study (TOML), which names it in [data] files");
    }
}

} // namespace explore::study
