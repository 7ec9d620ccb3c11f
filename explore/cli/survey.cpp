// pavescape survey: a road of FWD stations; deflection ratios, and the parameters of a study at every station.
#include "report/survey.h"
#include "cli/road_input.h"

namespace explore::cli {
namespace {

int survey_road(const RoadInput& input) {
    return run_road(input, "survey", [&](analysis::Session& session, auto files) -> std::optional<RoadPages> {
        std::optional<study::Study> study;
        if (!input.common.study.empty()) {
            study = study::load_survey_study(input.common.study);
        }
        const auto result = analysis::survey(session, std::move(files), std::move(study), input.options);
        if (!result) {
            return std::nullopt;
        }
        const auto counts = result->counts();
        return RoadPages{report::survey_json(*result), report::survey_csv(*result), report::survey_text(*result),
                         report::survey_geojson(*result),
                         result->study ? counts.fitted == 0 : counts.rejected == result->stations.size()};
    });
}

} // namespace

void add_survey(CLI::App& app, Action& action) {
    auto* sub =
        app.add_subcommand("survey", "a road of FWD stations: deflection ratios, back-calculation of every station");
    auto input = std::make_shared<RoadInput>();
    analysis::SurveyOptions& options = input->options;
    sub->add_option("--study", input->common.study, "study (TOML) whose section and parameters are fitted")
        ->type_name("FILE");
    add_road_input(*sub, *input);
    add_load(*sub, "--normalise", "scale deflections to this load: 40kN, 50kN, 566kPa, 700kPa",
             [&options](const analysis::LoadLevel& level) { options.normalise = level; });
    sub->add_option("--asphalt-thickness", options.asphalt_thickness_mm,
                    "mm, for the temperature in the asphalt (default: the study's top layer)")
        ->check(within(10, 1000));
    sub->add_option("--air-before", options.air_of_day_before_C,
                    "mean air temperature of the day before in C, for the temperature in the asphalt (BELLS3)")
        ->check(within(-60, 60));
    sub->add_option("--reference-temperature", options.reference_C,
                    "give deflections, indices and the asphalt modulus at this temperature, C, too")
        ->check(within(-30, 60));
    std::map<std::string, data::TemperatureCurve> curves;
    for (std::size_t i = 0; i < data::temperature_curves.size(); ++i) {
        curves[std::string(data::temperature_curves[i].name)] = static_cast<data::TemperatureCurve>(i);
    }
    sub->add_option("--temperature-curve", options.curve,
                    "by which they are taken there: fhwa (FHWA-RD-98-085, default), rws (Rijkswaterstaat, D0 and SCI), "
                    "irc (IRC:115, the modulus alone)")
        ->transform(CLI::CheckedTransformer(curves));
    sub->add_option("--latitude", options.latitude_deg, "degrees, for the curve fhwa where the file has no positions")
        ->check(within(-90, 90));
    sub->footer("Example: pavescape survey grids/road-example.csv --study grids/road-example.toml");
    sub->callback([=, &action] { action = [=] { return survey_road(*input); }; });
}

} // namespace explore::cli
