// pavescape survey: a road of FWD stations; deflection ratios, and the parameters of a study at every station.
#include "analysis/survey.h"
#include "analysis/build.h"
#include "cli/commands.h"
#include "data/csv.h"
#include "data/hash.h"
#include "report/survey.h"
#include "report/text.h"
#include "run/files.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>

namespace explore::cli {
namespace {

struct SurveyCommand {
    CommonOptions common;
    std::vector<std::string> files;
    std::string columns;
    std::string target;
    std::string normalise;
    analysis::SurveyOptions options;
};

// "40kN", "566 kPa".
std::optional<analysis::LoadLevel> load_level(const std::string& text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const std::string unit =
        data::lower_case(data::trimmed({end, static_cast<std::size_t>(text.data() + text.size() - end)}));
    if (error != std::errc() || !(value > 0.0 && value < 1e6) || (unit != "kn" && unit != "kpa")) {
        return std::nullopt;
    }
    analysis::LoadLevel level;
    (unit == "kn" ? level.force_kN : level.pressure_kPa) = value;
    return level;
}

CLI::Validator a_load() {
    return {[](std::string& text) { return load_level(text) ? std::string() : text + " is no load: 40kN, 566kPa"; },
            "LOAD"};
}

// What the files hold, whatever they are called.
std::string content_of(const std::vector<data::FwdFile>& files) {
    std::string text;
    for (const data::FwdFile& file : files) {
        text += file.inputs[0].bytes + '\f';
    }
    return data::hash_of(text);
}

std::vector<data::InputFile> inputs_of(const SurveyCommand& command, const std::vector<data::FwdFile>& files) {
    std::vector<data::InputFile> inputs;
    for (const data::FwdFile& file : files) {
        inputs.insert(inputs.end(), file.inputs.begin(), file.inputs.end());
    }
    if (std::error_code error; !command.columns.empty() && std::filesystem::exists(command.columns, error)) {
        inputs.push_back(
            {command.columns, data::read_file(command.columns, "list of columns", data::Encoding::of_instruments)});
    }
    return inputs;
}

// A folder holds one road. Throws pave::Error when it holds another.
void check_folder(const std::string& folder, const std::vector<std::string>& files, const std::string& content) {
    std::ifstream stream(std::filesystem::path(folder) / "survey.json");
    const auto before = report::Json::parse(stream, nullptr, false);
    if (!before.is_object() || !before.contains("files") || !before["files"].is_array()) {
        return;
    }
    const bool same_names = before["files"] == report::Json(files);
    const bool same_content = before.value("content", report::Json()) == report::Json(content);
    if (!same_names && !same_content) {
        std::vector<std::string> names;
        for (const auto& name : before["files"]) {
            names.push_back(name.is_string() ? name.get<std::string>() : "?");
        }
        throw pave::Error({.file = folder}, "this folder holds the survey of another road", pave::join(names),
                          "another folder: --out DIR");
    }
}

int survey_road(const SurveyCommand& command) {
    const CommonOptions& common = command.common;
    const data::ColumnMap columns =
        command.columns.empty() ? data::ColumnMap{} : data::read_column_map(command.columns);
    std::vector<data::FwdFile> files;
    for (const std::string& file : command.files) {
        files.push_back(data::read_fwd(file, columns));
    }
    const std::string stem = std::filesystem::path(command.files[0]).stem().string();
    const std::string folder = common.out.empty() ? "output/" + stem : common.out;
    const std::string content = content_of(files);
    check_folder(folder, command.files, content);

    analysis::SurveyOptions options = command.options;
    if (const auto target = load_level(command.target)) {
        options.drops.target_pressure_kPa = target->pressure_kPa;
        options.drops.target_force_kN = target->force_kN;
    }
    options.normalise = load_level(command.normalise);
    std::optional<study::Study> study;
    if (!common.study.empty()) {
        study = study::load_survey_study(common.study);
    }
    analysis::RunOptions run = common.run(folder);
    run.inputs = inputs_of(command, files);
    analysis::Session session(std::move(run));
    const auto result = analysis::survey(session, std::move(files), std::move(study), options);
    if (!result) {
        return report_interrupt(folder);
    }
    report::Json json = report::survey_json(*result);
    json["seed"] = common.seed;
    json["files"] = command.files;
    json["content"] = content;
    json["version"] = analysis::version;
    json["run"] = folder;
    std::string written = "survey.csv, survey.json";
    run::write_file(folder, "survey.csv", report::survey_csv(*result));
    session.keep("survey", report::json_text(json));
    if (const auto map = report::survey_geojson(*result)) {
        run::write_file(folder, "survey.geojson", report::json_text(*map) + "\n");
        written += ", survey.geojson";
    }
    const auto& counts = json["counts"];
    const bool nothing = result->study ? counts["fitted"] == 0 : counts["rejected"] == counts["stations"];
    if (common.json) {
        fmt::print("{}\n", report::json_text(json));
    } else {
        fmt::print("{}{}\n  results: {}/{}\n", result->study ? report::study_summary(*result->study) + "\n" : "",
                   report::survey_text(*result), folder, written);
    }
    return nothing ? computation_failed : done;
}

} // namespace

void add_survey(CLI::App& app, Action& action) {
    auto* sub =
        app.add_subcommand("survey", "a road of FWD stations: deflection ratios, back-calculation of every station");
    auto command = std::make_shared<SurveyCommand>();
    analysis::SurveyOptions& options = command->options;
    sub->add_option("FILE", command->files, "measured FWD files")->required();
    sub->add_option("--study", command->common.study, "study (TOML) whose section and parameters are fitted");
    sub->add_option(
        "--columns", command->columns,
        "names of the columns of a table: \"load_kN = Force, D0_um = D1, radius_mm = 150\", or a file of such "
        "lines");
    sub->add_option("--drops", options.drops.numbers, "use these drops and no others: 2,3")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::Range(0, 1000000));
    sub->add_option("--target-load", command->target, "use the drops nearest to this load: 40kN, 566kPa")
        ->check(a_load());
    sub->add_option("--normalise", command->normalise, "scale deflections to this load: 40kN, 50kN, 566kPa, 700kPa")
        ->check(a_load());
    sub->add_option("--asphalt-thickness", options.asphalt_thickness_mm,
                    "mm, for the temperature in the asphalt (default: the study's top layer)")
        ->check(within(10, 1000));
    sub->add_option("--air-before", options.air_of_day_before_C,
                    "mean air temperature of the day before in C, for the temperature in the asphalt (BELLS3)")
        ->check(within(-60, 60));
    sub->add_option("--reference-temperature", options.reference_C,
                    "give the asphalt modulus at this temperature, C, too")
        ->check(within(-30, 60));
    add_run_options(*sub, command->common, "output/<name of the first file>");
    sub->footer("Example: pavescape survey grids/road-example.csv --study grids/road-example.toml");
    sub->callback([=, &action] { action = [=] { return survey_road(*command); }; });
}

} // namespace explore::cli
