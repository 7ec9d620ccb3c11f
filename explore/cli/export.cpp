// pavescape export: the evaluations of a run, one line each in run order.
#include "base/text.h"
#include "cli/commands.h"
#include "data/csv.h"
#include "run/message.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::cli {
namespace {

// wanted: the command whose last run is exported; empty: the run used last.
int export_run(const std::string& folder, const std::string& format, const std::string& wanted) {
    const run::Store store(folder);
    const auto runs = store.runs();
    const auto chosen = std::find_if(
        runs.begin(), runs.end(), [&](const run::RunHeader& r) { return wanted.empty() || r.key.command == wanted; });
    if (chosen == runs.end()) {
        std::vector<std::string> commands;
        for (const run::RunHeader& r : runs) {
            if (std::find(commands.begin(), commands.end(), r.key.command) == commands.end()) {
                commands.push_back(r.key.command);
            }
        }
        throw pave::Error({.file = folder, .key = "--command"}, "this folder holds no run of that command", wanted,
                          pave::join(commands));
    }
    const run::RunHeader& header = *chosen;
    if (runs.size() > 1) {
        run::message("exporting: {} ({}); {} more in this folder (--command)\n", header.key.command,
                     header.key.settings, pave::counted(runs.size() - 1, "run", "runs"));
    }
    const auto phase = [](run::RunNumber n) { return n.start < 0 ? "design" : "search"; };
    if (format == "json") {
        report::Json json = {{"command", header.key.command},       {"settings", header.key.settings},
                             {"study_hash", header.key.study_hash}, {"version", header.version},
                             {"parameters", header.parameters},     {"responses", header.responses},
                             {"evaluations", report::Json::array()}};
        store.each(header.id, [&](run::RunNumber n, const problem::Evaluation& e) {
            report::Json row = {{"phase", phase(n)},
                                {"start", n.start},
                                {"number", n.number},
                                {"status", std::string(to_string(e.status))},
                                {"parameters", e.parameters}};
            if (e.converged()) {
                report::Json responses = report::Json::array();
                for (std::size_t i = 0; i < e.responses.size(); ++i) {
                    responses.push_back(e.responses[i] / header.response_to_si[i]);
                }
                row["misfit"] = e.misfit;
                row["responses"] = std::move(responses);
            } else {
                row["reason"] = e.reason;
            }
            json["evaluations"].push_back(std::move(row));
        });
        fmt::print("{}\n", report::json_text(json));
        return done;
    }
    std::string line = "phase,start,number,status";
    for (const auto& name : header.parameters) {
        line += "," + data::csv_cell(name);
    }
    line += ",misfit";
    for (const auto& name : header.responses) {
        line += "," + data::csv_cell(name);
    }
    fmt::print("{},reason\n", line);
    store.each(header.id, [&](run::RunNumber n, const problem::Evaluation& e) {
        std::string row = fmt::format("{},{},{},{}", phase(n), n.start, n.number, to_string(e.status));
        for (const double value : e.parameters) {
            row += fmt::format(",{}", value);
        }
        row += std::isnan(e.misfit) ? "," : fmt::format(",{}", e.misfit);
        for (std::size_t i = 0; i < header.responses.size(); ++i) {
            const bool known = e.converged() && !std::isnan(e.responses[i]); // of a load that was not computed
            row += known ? fmt::format(",{}", e.responses[i] / header.response_to_si[i]) : ",";
        }
        fmt::print("{},{}\n", row, data::csv_cell(e.reason));
    });
    return done;
}

} // namespace

void add_export(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("export", "the evaluations of a run, one line each in run order");
    auto folder = std::make_shared<std::string>();
    auto format = std::make_shared<std::string>("csv");
    command->add_option("RUN", *folder, "folder of the run")->required();
    auto wanted = std::make_shared<std::string>();
    command->add_option("--command", *wanted,
                        "of the runs in the folder the last one of this command: map, fit, unique, ... (some commands "
                        "keep more than one run: unique-outputs, sensitivity-curves, ...)");
    command->add_option("--format", *format, "csv or json")
        ->check(CLI::IsMember({"csv", "json"}))
        ->capture_default_str();
    command->footer("Example: pavescape export output/captif-p1-fwd > points.csv");
    command->callback([=, &action] { action = [=] { return export_run(*folder, *format, *wanted); }; });
}

} // namespace explore::cli
