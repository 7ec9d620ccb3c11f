#include "base/error.h"

#include "base/text.h"

#include <algorithm>
#include <numeric>

namespace pave {

Error::Error(const Place& place, std::string_view problem, std::string_view found, std::string_view allowed)
    : std::runtime_error(message(place, problem, found, allowed)) {}

std::string Error::message(const Place& place, std::string_view problem, std::string_view found,
                           std::string_view allowed) {
    std::string text;
    if (!place.file.empty()) {
        text += printable(place.file, 300);
        if (place.line > 0) {
            text.append(":").append(std::to_string(place.line));
        }
        text += ": ";
    }
    if (!place.key.empty()) {
        text += printable(place.key, 100) + ": ";
    }
    text += printable(problem, 300);
    if (!found.empty()) {
        text += "; found " + printable(found, 200);
    }
    if (!allowed.empty()) {
        text += "; allowed: " + printable(allowed, 4000);
    }
    return text;
}

std::string nearest_name(std::string_view word, const std::vector<std::string>& names) {
    std::string best;
    std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
    for (const std::string& name : names) {
        std::vector<std::size_t> row(name.size() + 1);
        std::iota(row.begin(), row.end(), std::size_t{0});
        for (std::size_t i = 1; i <= word.size(); ++i) {
            std::size_t diagonal = row[0];
            row[0] = i;
            for (std::size_t j = 1; j <= name.size(); ++j) {
                const std::size_t above = row[j];
                row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (word[i - 1] == name[j - 1] ? 0U : 1U)});
                diagonal = above;
            }
        }
        if (row.back() < best_distance) {
            best_distance = row.back();
            best = name;
        }
    }
    // Cut short, as "noise_rel" is, or with more to it. Two letters that differ are less likely than a cut.
    constexpr std::size_t shortest = 3; // letters
    const auto begins = [](std::string_view part, std::string_view whole) {
        return part.size() >= shortest && whole.starts_with(part);
    };
    std::string whole;
    std::string part;
    for (const std::string& name : names) {
        whole = begins(word, name) && (whole.empty() || name.size() < whole.size()) ? name : whole;
        part = begins(name, word) && name.size() > part.size() ? name : part;
    }
    if (!whole.empty() && (best.empty() || best_distance > 1)) {
        return whole;
    }
    if (!best.empty() || !part.empty()) {
        return best.empty() ? part : best;
    }
    // A slip in the last of a word that was cut short, too.
    for (const std::string& name : names) {
        const std::size_t same = static_cast<std::size_t>(
            std::mismatch(word.begin(), word.end(), name.begin(), name.end()).first - word.begin());
        if (same >= shortest && 4 * same >= 3 * word.size()) {
            return name;
        }
    }
    return "";
}

std::string join(const std::vector<std::string>& names, std::string_view separator) {
    std::string text;
    for (const std::string& name : names) {
        text += (text.empty() ? "" : std::string(separator)) + name;
    }
    return text;
}

} // namespace pave
