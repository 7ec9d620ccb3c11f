#include "report/run_folder.h"

#include "base/error.h"
#include "data/near_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

namespace explore::report {

namespace {

constexpr std::size_t most_pictured = 5000; // of a picture of the landscape

std::string contents(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    if (!stream) {
        throw pave::Error({.file = path.string()}, "cannot be read");
    }
    return text.str();
}

// Brackets within brackets, more than any result has: writing such JSON takes a call a level.
bool is_deep(std::string_view text) {
    int depth = 0;
    bool in_text = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_text) {
            i += c == '\\' ? 1 : 0;
            in_text = c != '"';
            continue;
        }
        in_text = c == '"';
        depth += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
        if (depth > 100) {
            return true;
        }
    }
    return false;
}

// A result has no study, or one with a file, a title and a hash; its layers are a list.
bool names_its_study(const Json& result) {
    if (!result.contains("study")) {
        return true;
    }
    const Json& of = result["study"];
    return of.is_object() && std::all_of(of.items().begin(), of.items().end(), [](const auto& item) {
               return item.key() == "layers" ? item.value().is_array() : item.value().is_string();
           });
}

// The results that each command left in the folder when it was done.
Json results_in(const std::filesystem::path& folder, const std::vector<std::string>& commands) {
    Json results = Json::object();
    std::vector<std::string> names;
    for (const std::string& command : commands) {
        names.push_back(command);
        if (command == "sample") {
            names.emplace_back("sample-prior"); // by its option --prior
        }
    }
    for (const std::string& command : names) {
        const auto path = folder / (command + ".json");
        if (!std::filesystem::is_regular_file(path)) {
            continue;
        }
        const std::string text = contents(path);
        Json result = is_deep(text) ? Json() : Json::parse(text, nullptr, false);
        if (!result.is_object() || !names_its_study(result)) {
            throw pave::Error({.file = path.string()}, "this is not the result of a run", {},
                              "the file that pavescape " + command + " wrote");
        }
        results[command] = std::move(result);
    }
    return results;
}

// The points of the run that shows the landscape best, lowest misfit first.
Json evaluations_in(const run::Store& store) {
    const auto runs = store.runs();
    for (const std::string_view command : {"map", "unique", "fit"}) {
        const auto found = std::find_if(runs.begin(), runs.end(),
                                        [&](const run::RunHeader& run) { return run.key.command == command; });
        if (found == runs.end()) {
            continue;
        }
        std::vector<problem::Evaluation> all;
        store.each(found->id, [&](run::RunNumber, const problem::Evaluation& e) {
            problem::Evaluation& kept = all.emplace_back();
            kept.status = e.status;
            kept.parameters = e.parameters;
            kept.misfit = e.misfit;
        });
        std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
            return a.converged() != b.converged() ? a.converged() : a.converged() && a.misfit < b.misfit;
        });
        // The lowest half of what is shown, and evenly of the rest.
        const std::size_t lowest = std::min(all.size(), most_pictured / 2);
        const std::size_t stride = 1 + (all.size() - lowest) / (most_pictured / 2 + 1);
        Json rows = Json::array();
        for (std::size_t i = 0; i < all.size(); i += i < lowest ? 1 : stride) {
            Json row = {std::string(to_string(all[i].status)), all[i].converged() ? Json(all[i].misfit) : Json()};
            for (const double value : all[i].parameters) {
                row.push_back(value);
            }
            rows.push_back(std::move(row));
        }
        return {{"command", command},
                {"settings", found->key.settings},
                {"parameters", found->parameters},
                {"left_out", all.size() - rows.size()},
                {"rows", std::move(rows)}};
    }
    return nullptr;
}

} // namespace

RunFolder read_run_folder(const std::string& folder, const std::vector<std::string>& commands) {
    if (std::filesystem::exists(folder) && !std::filesystem::is_directory(folder)) {
        throw pave::Error({.file = folder, .key = "RUN"}, "this is a file", {},
                          "the folder of a run, as --out names it");
    }
    if (!std::filesystem::is_directory(folder)) {
        throw pave::Error({.file = folder, .key = "RUN"}, "there is no such folder" + data::near_file_words(folder), {},
                          "the folder of a run");
    }
    RunFolder read{.results = results_in(folder, commands), .evaluations = {}};
    if (std::filesystem::exists(std::filesystem::path(folder) / "run.sqlite")) {
        read.evaluations = evaluations_in(run::Store(folder));
    }
    if (read.results.empty() && read.evaluations.is_null()) {
        throw pave::Error({.file = folder, .key = "RUN"}, "this folder holds no run", {},
                          "a folder that a pavescape command wrote");
    }
    return read;
}

Json sessions_json(const run::Store& store) {
    Json sessions = Json::array();
    for (const run::Session& s : store.sessions()) {
        sessions.push_back({{"began", s.began},
                            {"arguments", s.arguments},
                            {"version", s.version},
                            {"libraries", s.libraries},
                            {"threads", s.threads},
                            {"evaluations", s.evaluations},
                            {"seconds", s.seconds}});
    }
    return sessions;
}

Json studies_json(const Json& results, const run::Store* store) {
    Json studies = Json::array();
    std::set<std::string> seen;
    for (const auto& [command, result] : results.items()) {
        if (!result.contains("study")) {
            continue;
        }
        const Json& of = result["study"];
        const std::string file = of.value("file", "");
        const std::string hash = of.value("hash", "");
        if (!seen.insert(file + hash).second) {
            continue;
        }
        Json study = {{"file", std::filesystem::path(file).filename().string()},
                      {"title", of.value("title", "")},
                      {"hash", hash}};
        if (const auto text = store != nullptr ? store->study_text(hash) : std::nullopt) {
            study["text"] = *text;
        } else {
            study["note"] = "This run has not kept the text of its study.";
        }
        studies.push_back(std::move(study));
    }
    return studies;
}

} // namespace explore::report
