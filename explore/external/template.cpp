#include "external/template.h"

#include "base/error.h"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <fmt/printf.h>
#include <optional>

namespace explore::external {
namespace {

constexpr std::string_view formats = "%e, %f or %g with flags, width and precision, as %12.5e";

// The width of a format of one floating point number, 0 where it has none. Nothing: it is no such format.
std::optional<std::size_t> width_of_format(std::string_view format) {
    std::size_t at = 1;
    const auto is = [&](std::string_view characters) {
        return at < format.size() && characters.find(format[at]) != std::string_view::npos;
    };
    const auto number = [&]() -> std::optional<std::size_t> {
        std::size_t value = 0;
        constexpr std::size_t most = 100;
        while (at < format.size() && std::isdigit(static_cast<unsigned char>(format[at])) != 0) {
            value = 10 * value + static_cast<std::size_t>(format[at++] - '0');
            if (value > most) {
                return std::nullopt;
            }
        }
        return value;
    };
    if (format.empty() || format[0] != '%') {
        return std::nullopt;
    }
    while (is("-+ #0")) {
        ++at;
    }
    const auto width = number();
    if (!width) {
        return std::nullopt;
    }
    if (is(".")) {
        ++at;
        if (!number()) {
            return std::nullopt;
        }
    }
    return is("eEfFgG") && at + 1 == format.size() ? width : std::nullopt;
}

} // namespace

Template::Template(std::string text, std::string file, const std::vector<std::string>& names)
    : text_(std::move(text)),
      file_(std::move(file)) {
    constexpr std::string_view open = "{{";
    constexpr std::string_view close = "}}";
    std::size_t begin = 0;
    for (std::size_t at = text_.find(open); at != std::string::npos; at = text_.find(open, begin)) {
        const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at), '\n');
        const std::size_t end = text_.find(close, at);
        const std::size_t line_end = std::min(text_.find('\n', at), text_.size());
        const pave::Place place{.file = file_, .line = static_cast<int>(line)};
        if (end == std::string::npos || end > line_end) {
            throw pave::Error(place, "a place for a value is not closed",
                              text_.substr(at, std::min(line_end - at, 40UL)),
                              "{{NAME}} or {{NAME:FORMAT}} in one line");
        }
        const std::string inside = text_.substr(at + open.size(), end - at - open.size());
        const std::size_t colon = inside.find(':');
        Place found{.before = text_.substr(begin, at - begin),
                    .value = 0,
                    .name = inside.substr(0, colon),
                    .format = colon == std::string::npos ? "" : inside.substr(colon + 1)};
        const auto known = std::find(names.begin(), names.end(), found.name);
        if (known == names.end()) {
            const std::string near = pave::nearest_name(found.name, names);
            throw pave::Error(place,
                              near.empty() ? "this place names no parameter"
                                           : "this place names no parameter, did you mean \"" + near + "\"?",
                              "\"{{" + inside + "}}\"", pave::join(names));
        }
        found.value = static_cast<std::size_t>(known - names.begin());
        if (colon != std::string::npos) {
            const auto width = width_of_format(found.format);
            if (!width) {
                throw pave::Error(place, "this is no format of a number", "\"{{" + inside + "}}\"", formats);
            }
            found.width = *width;
        }
        places_.push_back(std::move(found));
        begin = end + close.size();
    }
    rest_ = text_.substr(begin);
}

pave::Outcome<std::string> Template::filled(std::span<const double> values) const {
    std::string text;
    for (const Place& place : places_) {
        const double value = values[place.value];
        const std::string number = place.format.empty() ? fmt::format("{}", value) : fmt::sprintf(place.format, value);
        if (place.width > 0 && number.size() > place.width) {
            return pave::Failure{pave::Status::invalid_parameters,
                                 fmt::format("{} = {} does not fit the {} columns that {} has for it ({})", place.name,
                                             number, place.width, file_, place.format)};
        }
        text += place.before + number;
    }
    return text + rest_;
}

bool Template::uses(std::size_t value) const {
    return std::any_of(places_.begin(), places_.end(), [&](const Place& place) { return place.value == value; });
}

} // namespace explore::external
