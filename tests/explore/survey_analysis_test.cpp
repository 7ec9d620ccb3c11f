// What a survey makes of bowls. Expected values are calculated by hand, as written beside them.
#include "analysis/survey/survey_findings.h"
#include "analysis/survey/survey_road.h"
#include "analysis/survey/survey_sensors.h"
#include "analysis/survey/survey_stations.h"
#include "data/asphalt_temperature.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;

namespace {

data::DeflectionBowl bowl_of(const std::vector<std::pair<double, double>>& readings, double pressure_kPa = 700.0) {
    data::DeflectionBowl bowl;
    bowl.radius_mm = 150.0;
    bowl.pressure_kPa = pressure_kPa;
    bowl.drops = {1};
    for (const auto& [offset, um] : readings) {
        bowl.readings.push_back({.offset_mm = offset, .deflection_um = um});
    }
    return bowl;
}

// A station with this D0 at its place along the road.
analysis::StationResult station(double chainage_m, double d0_um) {
    analysis::StationResult s;
    s.station.name = std::to_string(static_cast<int>(chainage_m));
    s.station.chainage_m = chainage_m;
    s.bowls.emplace().levels = {bowl_of({{0, d0_um}, {300, d0_um / 2}})};
    s.indices = data::indices_of(s.bowl(), 700.0);
    return s;
}

} // namespace

TEST(BowlIndices, AreThoseOfTheTrade) {
    const auto bowl = bowl_of({{0, 500}, {200, 400}, {300, 330}, {600, 180}, {900, 110}});
    const auto i = data::indices_of(bowl, 700.0);
    EXPECT_NEAR(*i.sci_um, 170.0, 1e-9);
    EXPECT_NEAR(*i.bdi_um, 150.0, 1e-9);
    EXPECT_NEAR(*i.bci_um, 70.0, 1e-9);
    EXPECT_NEAR(*i.area_mm, 489.0, 1e-9);                        // 150 (1 + 1.32 + 0.72 + 0.22)
    EXPECT_NEAR(*i.curvature_radius_m, 200.0, 1e-9);             // 0.04 / (2 x 500e-6 x 0.2)
    ASSERT_EQ(i.surface_moduli.size(), 4U);                      // at the centre and from 300 mm on
    EXPECT_NEAR(i.surface_moduli[0].modulus_MPa, 368.55, 1e-9);  // 2 x 0.8775 x 700 x 150 / 500
    EXPECT_NEAR(i.surface_moduli[2].modulus_MPa, 127.97, 0.005); // 0.8775 x 700 x 22500 / (600 x 180)
    // Half the pressure: half of every deflection, the same moduli and shapes.
    const auto half = data::indices_of(bowl, 350.0);
    EXPECT_NEAR(half.d0_um, 250.0, 1e-9);
    EXPECT_NEAR(*half.area_mm, 489.0, 1e-9);
    EXPECT_NEAR(half.surface_moduli[2].modulus_MPa, i.surface_moduli[2].modulus_MPa, 1e-9);
    // 7.07 kN on 300 mm, 100 kPa: 22.5 / 0.468 mm.
    const auto light = data::indices_of(bowl_of({{0, 468}}, 100.0), 100.0);
    ASSERT_TRUE(light.evd_MPa);
    EXPECT_NEAR(*light.evd_MPa, 48.08, 0.005);
    EXPECT_FALSE(i.evd_MPa);
    const auto few = data::indices_of(bowl_of({{0, 500}, {450, 200}}), 700.0);
    EXPECT_FALSE(few.sci_um || few.bdi_um || few.bci_um || few.area_mm || few.curvature_radius_m);
}

TEST(AsphaltTemperature, IsThatOfBells3) {
    // The guide's own sine at 13:15 is -0.707; sin(2 pi (13.25 - 13.5)/18) = -0.08716:
    // 0.95 + 22.3 + 0.75 (-11.2 + 9.315 - 1.2940) - 0.0915 = 20.774
    EXPECT_NEAR(data::bells3(25.0, 15.0, 13.25, 100.0), 20.774, 0.001);
    // Held at -1 in the morning: 0.95 + 22.3 + 0.75 (-11.2 + 9.315 - 1.83) - 1.05 = 19.414
    EXPECT_NEAR(data::bells3(25.0, 15.0, 8.0, 100.0), 19.414, 0.001);
    // At the ends of the held hours the wave is continuous.
    EXPECT_NEAR(data::bells3(25.0, 15.0, 11.0001, 100.0), data::bells3(25.0, 15.0, 10.9999, 100.0), 0.01);
    EXPECT_NEAR(data::bells3(25.0, 15.0, 23.9999, 100.0), data::bells3(25.0, 15.0, 0.0, 100.0), 0.01);
    // The guide's example: from 10 C to 21 C by the default slope 0.587.
    EXPECT_NEAR(data::modulus_factor(10.0, 21.0), 0.587, 0.001);
}

TEST(RoadSections, PartWhereTheDeflectionChanges) {
    analysis::SurveyResult result;
    for (int i = 0; i < 20; ++i) { // alternating by 4 % about 500 um, then about 900 um from 600 m on
        result.stations.push_back(station(50.0 * i, (i < 12 ? 500.0 : 900.0) * (i % 2 == 0 ? 1.02 : 0.98)));
    }
    const auto sections = analysis::road_sections(result);
    ASSERT_EQ(sections.size(), 2U);
    EXPECT_EQ(sections[0].last, 11U);
    EXPECT_EQ(sections[1].first, 12U);
    EXPECT_NEAR(sections[1].d0_um.p50, 900.0, 1e-9); // between 882 and 918
    // A lane and a profile of their own are sections of their own; one of noise alone is one section.
    for (int i = 0; i < 20; ++i) {
        result.stations[static_cast<std::size_t>(i)] = station(50.0 * i, 500.0 * (i % 2 == 0 ? 1.02 : 0.98));
        result.stations[static_cast<std::size_t>(i)].station.lane = i < 10 ? "L" : "R";
    }
    EXPECT_EQ(analysis::road_sections(result).size(), 2U);
    EXPECT_EQ(analysis::road_sections(result)[0].last, 9U);
}

TEST(RoadSections, PercentilesAreLinearBetweenValues) {
    const auto p = analysis::percentiles_of({50, 10, 20, 40, 30}); // places 0.6, 2, 3.4
    EXPECT_NEAR(p.p15, 16.0, 1e-12);
    EXPECT_NEAR(p.p50, 30.0, 1e-12);
    EXPECT_NEAR(p.p85, 44.0, 1e-12);
}

namespace {

// Stations whose fit meets every reading within 1 %, but for the third sensor, where it is `share` too high.
analysis::SurveyResult road_with_residual(int stations, double share, bool same_sign) {
    analysis::SurveyResult result;
    for (int i = 0; i < stations; ++i) {
        analysis::StationResult s = station(50.0 * i, 500.0);
        const double wiggle = i % 2 == 0 ? 0.005 : -0.005;
        const double here = same_sign || i % 2 == 0 ? share : -share;
        s.bowls->levels = {bowl_of({{0, 500}, {200, 400}, {450, 230.0 / (1 + here)}, {600, 180}, {900, 110}})};
        auto& fit = s.fit.emplace();
        fit.levels = {0};
        fit.model_um = {{500 * (1 + wiggle), 400 * (1 - wiggle), 230, 180 * (1 + wiggle), 110}};
        result.stations.push_back(std::move(s));
    }
    return result;
}

} // namespace

TEST(SuspectSensor, IsFoundByAResidualThatRepeats) {
    const auto found = analysis::suspect_sensor(road_with_residual(12, 0.18, true));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->offset_mm, 450.0);
    EXPECT_EQ(found->same_sign, 12U);
    EXPECT_NEAR(found->model_percent, 18.0, 0.01);
    EXPECT_NEAR(found->p, 3 * 2.0 / 4096.0, 1e-9); // all of 12, two-sided, three sensors
    // The model falls from 400 to 180 um over 400 mm: ln(400/180)/400 per mm; ln 1.18 lies 83 mm further out.
    EXPECT_NEAR(*found->fits_at_mm, 450.0 + std::log(1.18) * 400.0 / std::log(400.0 / 180.0), 1.0);
    EXPECT_FALSE(analysis::suspect_sensor(road_with_residual(12, 0.18, false))); // either sign
    EXPECT_FALSE(analysis::suspect_sensor(road_with_residual(6, 0.18, true)));   // too few
    EXPECT_FALSE(analysis::suspect_sensor(road_with_residual(12, 0.01, true)));  // too small
}

TEST(SurveyFindings, DoubtAFitThatMissesByFiveTimesWhatSensorsErr) {
    for (const auto& [rms, state] : {std::pair(9.9, analysis::StationState::ok),
                                     {10.1, analysis::StationState::doubtful},
                                     {24.9, analysis::StationState::doubtful},
                                     {25.1, analysis::StationState::no_fit}}) {
        analysis::StationResult s = station(0.0, 500.0);
        s.fit.emplace().rms_percent = rms;
        s.fit->best.unit = {0.5};
        analysis::judge_fit(s);
        EXPECT_EQ(s.state, state) << rms;
        EXPECT_EQ(s.is_fitted(), state != analysis::StationState::no_fit) << rms;
        EXPECT_EQ(analysis::reason_of(s).empty(), state == analysis::StationState::ok) << rms;
    }
}

TEST(SurveyFindings, SayWhatIsNoBackCalculation) {
    analysis::StationResult s = station(0.0, 500.0);
    s.state = analysis::StationState::no_fit;
    s.fit.emplace().rms_percent = 140.0;
    s.no_fit = analysis::NoFit::far_off;
    EXPECT_EQ(analysis::reason_of(s), "RMS 140 %: the model does not describe this bowl");
    s.no_fit = analysis::NoFit::all_on_bounds;
    EXPECT_NE(analysis::reason_of(s).find("every parameter ends on a bound"), std::string::npos);
}
