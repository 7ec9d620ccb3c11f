// pavescape report: one HTML file from a run.
#include "analysis/build.h"
#include "cli/commands.h"
#include "report/page.h"
#include "run/files.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <sstream>

namespace explore::cli {
namespace {

using report::Json;

constexpr std::size_t most_points = 5000; // of a picture of the landscape

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

// A result has no study, or one with a file, a title and a hash.
bool names_its_study(const Json& result) {
    if (!result.contains("study")) {
        return true;
    }
    const Json& of = result["study"];
    return of.is_object() && std::all_of(of.begin(), of.end(), [](const Json& value) { return value.is_string(); });
}

// What each command left in the folder when it was done.
Json results_in(const std::filesystem::path& folder) {
    Json results = Json::object();
    for (const auto& [command, add, keeps_a_run] : commands()) {
        const auto path = folder / (std::string(command) + ".json");
        if (!keeps_a_run || !std::filesystem::is_regular_file(path)) {
            continue;
        }
        const std::string text = contents(path);
        Json result = is_deep(text) ? Json() : Json::parse(text, nullptr, false);
        if (!result.is_object() || !names_its_study(result)) {
            throw pave::Error({.file = path.string()}, "this is not the result of a run", {},
                              "the file that pavescape " + std::string(command) + " wrote");
        }
        results[std::string(command)] = std::move(result);
    }
    return results;
}

// What was computed when, and how fast.
Json sessions_in(const run::Store& store) {
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
        const std::size_t lowest = std::min(all.size(), most_points / 2);
        const std::size_t stride = 1 + (all.size() - lowest) / (most_points / 2 + 1);
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

// The studies that the results came from, while they are still the same.
Json studies_of(const Json& results) {
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
        try {
            if (study::load_study(file).hash == hash) {
                study["text"] = contents(file);
            } else {
                study["note"] = "The study or its data have been changed since this run; they are not shown.";
            }
        } catch (const pave::Error&) {
            study["note"] = "The study can no longer be read where it was.";
        }
        studies.push_back(std::move(study));
    }
    return studies;
}

int make_report(const std::string& folder, const std::string& out) {
    if (!std::filesystem::is_directory(folder)) {
        throw pave::Error({.file = folder, .key = "RUN"}, "there is no such folder", {}, "the folder of a run");
    }
    Json results = results_in(folder);
    Json evaluations;
    Json sessions = Json::array();
    if (std::filesystem::exists(std::filesystem::path(folder) / "run.sqlite")) {
        const run::Store store(folder);
        evaluations = evaluations_in(store);
        sessions = sessions_in(store);
    }
    if (results.empty() && evaluations.is_null()) {
        throw pave::Error({.file = folder, .key = "RUN"}, "this folder holds no run", {},
                          "a folder that a pavescape command wrote");
    }
    Json studies = studies_of(results);
    const std::string text = report::page({{"folder", std::filesystem::canonical(folder).filename().string()},
                                           {"version", analysis::version},
                                           {"results", std::move(results)},
                                           {"evaluations", std::move(evaluations)},
                                           {"sessions", std::move(sessions)},
                                           {"studies", std::move(studies)}});
    const std::filesystem::path path =
        out.empty() ? std::filesystem::path(folder) / "report.html" : std::filesystem::path(out);
    const std::string parent = path.parent_path().string();
    run::write_file(parent.empty() ? "." : parent, path.filename().string(), text);
    fmt::print("{} ({:.1f} MB): open it in a browser\n", path.string(), static_cast<double>(text.size()) / 1e6);
    return done;
}

} // namespace

void add_report(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("report", "one HTML file from a run, to read in a browser or on paper");
    auto folder = std::make_shared<std::string>();
    auto out = std::make_shared<std::string>();
    command->add_option("RUN", *folder, "folder of the run")->required();
    command->add_option("--out", *out, "the file (default: RUN/report.html)")->type_name("FILE");
    command->footer("Example: pavescape report output/captif-p1-fwd");
    command->callback([=, &action] { action = [=] { return make_report(*folder, *out); }; });
}

} // namespace explore::cli
