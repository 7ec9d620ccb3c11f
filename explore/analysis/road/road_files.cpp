#include "analysis/road/road_files.h"

#include "base/error.h"
#include "base/text.h"
#include "data/csv.h"
#include "data/hash.h"
#include "run/message.h"

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>

namespace explore::analysis {

RoadFiles read_road(const std::vector<std::string>& names, const std::string& columns, const std::string& layers) {
    RoadFiles road{.names = names, .files = data::read_fwd_files(names, columns), .inputs = {}, .content = {}};
    std::string text;
    for (const data::FwdFile& file : road.files) {
        road.inputs.insert(road.inputs.end(), file.inputs.begin(), file.inputs.end());
        text += file.inputs[0].bytes + '\f';
    }
    if (std::error_code error; !columns.empty() && std::filesystem::exists(columns, error)) {
        road.inputs.push_back({columns, data::read_file(columns, "list of columns", data::Encoding::of_instruments)});
    }
    if (!layers.empty()) {
        road.inputs.push_back({layers, data::read_file(layers, "table of layers", data::Encoding::of_instruments)});
    }
    road.content = data::hash_of(text);
    return road;
}

std::string earlier_study(const std::string& folder, const std::string& name, const RoadFiles& road) {
    using Json = nlohmann::json;
    std::ifstream stream(std::filesystem::path(folder) / (name + ".json"));
    const auto before = Json::parse(stream, nullptr, false);
    if (!before.is_object() || !before.contains("files") || !before["files"].is_array()) {
        return {};
    }
    const bool same_names = before["files"] == Json(road.names);
    const bool same_content = before.value("content", Json()) == Json(road.content);
    if (!same_names && !same_content) {
        std::vector<std::string> names;
        for (const auto& file : before["files"]) {
            names.push_back(file.is_string() ? file.get<std::string>() : "?");
        }
        throw pave::Error({.file = folder},
                          fmt::format("this folder holds the {} of another road", name == "road" ? "fit" : name),
                          pave::join(names), "another folder: --out DIR");
    }
    const Json study = before.value("study", Json());
    const Json file = study.is_object() ? study.value("file", Json()) : Json();
    return file.is_string() ? file.get<std::string>() : std::string();
}

void say_what_was_replaced(const std::string& folder, const std::string& name, const std::string& before,
                           const std::string& now) {
    if (!before.empty() && now != before) {
        run::message("{}/{}.json was made with {} before. To keep both, name another folder: --out DIR\n", folder, name,
                     before);
    }
}

} // namespace explore::analysis
