#include "cli/road_input.h"

#include "data/fwd_pddx_written.h"
#include "data/workbook.h"
#include "report/kml.h"
#include "report/road_run.h"
#include "run/files.h"

#include <filesystem>
#include <fmt/format.h>

namespace explore::cli {

void add_load(CLI::App& app, const std::string& name, const std::string& help,
              const std::function<void(const analysis::LoadLevel&)>& keep) {
    const auto is_load = [](std::string& text) {
        return analysis::load_level_of(text) ? std::string() : text + " is no load: 40kN, 566kPa";
    };
    app.add_option_function<std::string>(
           name, [keep](const std::string& text) { keep(*analysis::load_level_of(text)); }, help)
        ->check(CLI::Validator(is_load, "LOAD"));
}

void add_road_input(CLI::App& app, RoadInput& input) {
    data::DropChoice& drops = input.options.drops;
    app.add_option("FILE", input.files, "measured FWD files")->required();
    add_columns(app, input.columns);
    app.add_option("--layers", input.options.layers,
                   "thicknesses by chainage: a table with chainage_m and columns such as asphalt_mm, asphalt_sd_mm")
        ->type_name("FILE");
    app.add_option("--drops", drops.numbers, "use these drops and no others: 2,3")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::Range(0, 1000000));
    add_load(app, "--target-load", "use the drops nearest to this load: 40kN, 566kPa",
             [&drops](const analysis::LoadLevel& level) {
                 drops.target_pressure_kPa = level.pressure_kPa;
                 drops.target_force_kN = level.force_kN;
             });
    add_run_options(app, input.common, "output/<name of the first file>");
    add_depth(app, input.common);
}

int run_road(const RoadInput& input, const std::string& name,
             const std::function<std::optional<RoadPages>(analysis::Session&, std::vector<data::FwdFile>)>& analyse) {
    analysis::RoadFiles road = analysis::read_road(input.files, input.columns, input.options.layers);
    const std::string folder =
        input.common.out.empty() ? "output/" + std::filesystem::path(input.files[0]).stem().string() : input.common.out;
    const std::string before = analysis::earlier_study(folder, name, road);
    analysis::RunOptions run = input.common.run(folder);
    run.inputs = std::move(road.inputs);
    analysis::Session session(std::move(run));
    const auto exchange = data::pddx_of(road.files);
    auto pages = analyse(session, std::move(road.files));
    if (!pages) {
        return report_interrupt(folder);
    }
    report::Json& json = pages->json;
    report::add_run(json, road, session.options());
    std::string written = name + ".csv, " + name + ".json";
    run::write_file(folder, name + ".csv", pages->csv);
    if (const auto workbook = data::workbook_of(pages->csv, name)) {
        run::write_file(folder, name + ".xlsx", *workbook);
        written += ", " + name + ".xlsx";
    }
    session.keep(name, report::json_text(json));
    analysis::say_what_was_replaced(folder, name, before, input.common.study);
    if (pages->map) {
        run::write_file(folder, name + ".geojson", report::json_text(*pages->map) + "\n");
        run::write_file(folder, name + ".kml", report::kml_of(*pages->map, name));
        written += fmt::format(", {0}.geojson, {0}.kml", name);
    }
    for (std::size_t i = 0; i < exchange.size(); ++i) {
        const std::string file = name + (exchange.size() > 1 ? fmt::format("-{}", i + 1) : "") + ".ddx";
        run::write_file(folder, file, exchange[i]);
        written += ", " + file;
    }
    const std::string page = fmt::format("{}\n  results: {}/{}\n", pages->text, folder, written);
    run::write_file(folder, name + ".txt", page);
    fmt::print("{}", input.common.json ? report::json_text(json) + "\n" : shown_answer(input.common, name, json, page));
    return pages->nothing ? computation_failed : done;
}

} // namespace explore::cli
