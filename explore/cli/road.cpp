// pavescape road: the stations of a road as one experiment, whose material is the same.
#include "analysis/road/road.h"
#include "cli/road_input.h"
#include "report/road.h"
#include "report/survey.h"

namespace explore::cli {
namespace {

int fit_road(const RoadInput& input, const analysis::RoadOptions& chosen) {
    return run_road(input, "road", [&](analysis::Session& session, auto files) -> std::optional<RoadPages> {
        analysis::RoadOptions options = chosen;
        options.survey = input.options;
        const auto result =
            analysis::road(session, std::move(files), study::load_survey_study(input.common.study), options);
        return !result ? std::nullopt
                       : std::optional(RoadPages{report::road_json(*result), report::road_csv(*result),
                                                 report::road_text(*result), report::survey_geojson(result->survey),
                                                 result->stations.empty()});
    });
}

} // namespace

void add_road(CLI::App& app, Action& action) {
    auto* sub = app.add_subcommand("road", "a road of FWD stations as one experiment: what they have in common");
    auto input = std::make_shared<RoadInput>();
    sub->add_option("--study", input->common.study, "study (TOML) whose parameters state their level")
        ->required()
        ->type_name("FILE");
    add_road_input(*sub, *input);
    auto chosen = std::make_shared<analysis::RoadOptions>();
    add_load(*sub, "--withhold", "keep this load out of the fit and predict it: 40kN, 566kPa",
             [chosen](const analysis::LoadLevel& level) { chosen->withhold = level; });
    sub->add_flag("--diagnose", chosen->diagnose, "look for what the model lacks at all stations alike");
    sub->footer("Example: pavescape road grids/road-together.csv --study grids/road-together.toml");
    sub->callback([=, &action] { action = [=] { return fit_road(*input, *chosen); }; });
}

} // namespace explore::cli
