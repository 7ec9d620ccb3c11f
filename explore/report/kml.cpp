#include "report/kml.h"

#include <fmt/format.h>

namespace explore::report {

namespace {

// In the content of elements and in attributes; characters that XML does not have become spaces.
std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
        case '&': result += "&amp;"; break;
        case '<': result += "&lt;"; break;
        case '>': result += "&gt;"; break;
        case '"': result += "&quot;"; break;
        default: result += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c; // NOLINT
        }
    }
    return result;
}

std::string text_of(const Json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump();
}

} // namespace

std::string kml_of(const Json& map, const std::string& name) {
    std::string text = fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                                   "<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>{}</name>\n",
                                   escaped(name));
    for (const Json& feature : map.at("features")) {
        const Json& properties = feature.at("properties");
        const Json& at = feature.at("geometry").at("coordinates");
        text +=
            fmt::format("<Placemark>\n<name>{}</name>\n<ExtendedData>\n", escaped(text_of(properties.at("station"))));
        for (const auto& [key, value] : properties.items()) {
            if (key != "station" && !value.is_null()) {
                text +=
                    fmt::format("<Data name=\"{}\"><value>{}</value></Data>\n", escaped(key), escaped(text_of(value)));
            }
        }
        text += fmt::format("</ExtendedData>\n<Point><coordinates>{},{}</coordinates></Point>\n</Placemark>\n",
                            at.at(0).dump(), at.at(1).dump());
    }
    return text + "</Document>\n</kml>\n";
}

} // namespace explore::report
