// Roads whose thicknesses vary, and sections that are not the study's. Deflections by the transform solution of
// tests/reference; other expected values are calculated by hand, as written beside them.
#include "analysis/survey/survey_stations.h"
#include "base/error.h"
#include "data/condition.h"
#include "data/fwd_csv.h"
#include "data/station_layers.h"
#include "data/structural_number.h"
#include "reference/multilayer_elastic.h"
#include "study/station.h"
#include "support/folder.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>

using namespace explore;

namespace {

constexpr double offsets_mm[] = {0, 200, 300, 450, 600, 900, 1200, 1500, 1800};

std::string written(const std::string& name, const std::string& text) {
    const std::string file = test::own_folder() + name;
    std::ofstream(file) << text;
    return file;
}

// 80 mm of asphalt and 260 mm of base on a half-space, the moduli sought. more: further tables.
study::Study survey_study(const std::string& name, const std::string& more = "") {
    std::string text = "schema = 1\n[section]\nbottom = \"half-space\"\n";
    const auto layer = [&](const std::string& layer_name, const std::string& thickness, double modulus) {
        text += "[[layers]]\nname = \"" + layer_name + "\"\n" + thickness +
                "density_kg_m3 = 2100\nk0 = 0.5\nlaw = \"linear\"\nmodulus_MPa = " + std::to_string(modulus) +
                "\npoisson = 0.35\n";
    };
    layer("asphalt", "thickness_mm = 80\n", 4000);
    layer("base", "thickness_mm = 260\n", 300);
    layer("subgrade", "", 90);
    text += "[[loads]]\nname = \"fwd\"\ntype = \"plate\"\nradius_mm = 150\npressure_kPa = 700\n"
            "[data]\nmisfit = \"weighted\"\n";
    for (const char* of : {"asphalt", "base", "subgrade"}) {
        const bool is_stiff = std::string(of) == "asphalt";
        text += "[[parameters]]\nname = \"" + std::string(of) + ".modulus_MPa\"\nmin = " + (is_stiff ? "500" : "15") +
                "\nmax = " + (is_stiff ? "20000" : "2500") + "\nscale = \"log\"\n";
    }
    return study::load_survey_study(written(name, text + more));
}

data::FwdStation station_on(const std::vector<pave::reference::ElasticLayer>& layers, double chainage_m) {
    data::FwdStation s;
    s.name = std::to_string(std::lround(chainage_m));
    s.chainage_m = chainage_m;
    s.file = "road.csv";
    data::FwdDrop drop;
    drop.number = 1;
    drop.radius_mm = 150.0;
    drop.pressure_kPa = 700.0;
    for (const double r : offsets_mm) {
        const auto field =
            pave::reference::multilayer_elastic(layers, pave::reference::Floor::half_space, 0.15, 700e3, r / 1e3, 0.0);
        drop.readings.push_back({r, 1e6 * field.u_z});
    }
    s.drops.push_back(std::move(drop));
    return s;
}

// Moduli and thicknesses of station i of a road that has 69 to 97 mm of asphalt.
std::array<double, 4> truth(int i) {
    return {3000.0 + 700.0 * (i % 3), 250.0 + 40.0 * (i % 4), 70.0 + 9.0 * (i % 5), 69.0 + 4.0 * i};
}
constexpr int road_stations = 8;

data::FwdFile road(bool with_layers) {
    data::FwdFile file;
    for (int i = 0; i < road_stations; ++i) {
        const auto [asphalt, base, subgrade, mm] = truth(i);
        auto s = station_on({{mm / 1e3, asphalt * 1e6, 0.35}, {0.26, base * 1e6, 0.35}, {0.0, subgrade * 1e6, 0.35}},
                            50.0 * i);
        if (with_layers) {
            s.layers["Asphalt"].mm = mm;
        }
        file.stations.push_back(std::move(s));
    }
    return file;
}

analysis::SurveyResult surveyed(data::FwdFile file, study::Study study, const std::string& table = "") {
    analysis::Session session({.threads = 1, .show_progress = false});
    return *analysis::survey(session, {std::move(file)}, std::move(study), {.layers = table});
}

// Of the asphalt modulus over the stations: largest |found / true - 1|.
double worst_asphalt(const analysis::SurveyResult& result) {
    double worst = 0.0;
    for (int i = 0; i < road_stations; ++i) {
        const auto& fit = result.stations[static_cast<std::size_t>(i)].fit;
        worst = std::max(worst, fit ? std::abs(fit->parameters[0].value / truth(i)[0] - 1.0) : INFINITY);
    }
    return worst;
}

bool holds(const std::vector<std::string>& words, const std::string& part) {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& w) { return w.find(part) != std::string::npos; });
}

} // namespace

TEST(StationLayers, TrueModuliComeBackWithEveryStationsOwnThicknessAndNotWithOne) {
    const auto own = surveyed(road(true), survey_study("own.toml"));
    for (int i = 0; i < road_stations; ++i) {
        const auto& s = own.stations[static_cast<std::size_t>(i)];
        ASSERT_TRUE(s.is_fitted()) << s.reason;
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(s.fit->parameters[k].value / truth(i)[k], 1.0, 2e-3) << "station " << i << ", parameter " << k;
        }
    }
    EXPECT_TRUE(holds(own.remarks, "asphalt is 69 to 97 mm thick by what 8 of 8 stations state"));
    EXPECT_GT(worst_asphalt(surveyed(road(false), survey_study("one.toml"))), 0.2);
    // The same by a table of two rows: 69 mm at 0 m, 97 mm at 350 m, linear between.
    const std::string table = written("cores.csv", "chainage_m;Asphalt (cm)\n0+000;6,9\n0+350;9,7\n");
    EXPECT_LT(worst_asphalt(surveyed(road(false), survey_study("table.toml"), table)), 2e-3);
}

TEST(StationLayers, NamesOfColumnsAreALayerAndAUnit) {
    const auto is = [](const char* name, const std::string& layer, double to_mm, bool is_error) {
        const auto c = data::layer_column(name);
        return c && c->layer == layer && std::abs(c->to_mm - to_mm) < 1e-9 && c->is_error == is_error;
    };
    EXPECT_TRUE(is("asphalt_mm", "asphalt", 1.0, false));
    EXPECT_TRUE(is("Base course (cm)", "Base course", 10.0, false));
    EXPECT_TRUE(is("asphalt_sd_mm", "asphalt", 1.0, true));
    EXPECT_TRUE(is("base in", "base", 25.4, false));
    EXPECT_FALSE(data::layer_column("asphalt") || data::layer_column("asphalt_C") || data::layer_column("_mm"));
}

TEST(StationLayers, AreReadBesideTheDeflectionsAndThoseThatNameNoLayerAreSaid) {
    const std::string text =
        "station,chainage_m,radius_mm,pressure_kPa,asphalt_mm,asphalt_sd_mm,rut_mm,D0_um,D300_um,"
        "D600_um,D900_um\nA,0,150,700,72.5,4,3,500,330,180,110\nB,20,150,700,,,3,500,330,180,110\n";
    data::FwdFile file = data::read_fwd_csv(text, "road.csv", {});
    ASSERT_EQ(file.stations.size(), 2U);
    EXPECT_EQ(file.stations[0].layers.at("asphalt").mm, 72.5);
    EXPECT_EQ(file.stations[0].layers.at("asphalt").sd_mm, 4.0);
    EXPECT_FALSE(file.stations[1].layers.contains("asphalt"));
    const auto result = analysis::begin_survey({file}, survey_study("names.toml"), {});
    EXPECT_TRUE(holds(result.remarks, "columns not used, as they name no layer of the study (asphalt, base): rut"));
    EXPECT_TRUE(holds(result.remarks, "1 of 2 stations state; the study's 80 mm at the others"));
    EXPECT_TRUE(holds(result.remarks, "asphalt_sd_mm is not used"));
    EXPECT_FALSE(result.stations[0].station.layers.contains("rut"));
}

TEST(StationLayers, OfATableLieBetweenItsRows) {
    const auto table = data::read_layer_table(written(
        "layers.csv", "chainage_m,lane,asphalt_mm,asphalt_sd_mm,base_mm\n0,,80,4,\n100,,100,8,300\n50,L,60,,\n"));
    const auto at = [&](const char* lane, double m) { return data::thickness_at(table, "asphalt", lane, m); };
    EXPECT_DOUBLE_EQ(at("R", 25)->mm, 85.0); // 80 + 20 / 4, 4 + 4 / 4
    EXPECT_DOUBLE_EQ(*at("R", 25)->sd_mm, 5.0);
    EXPECT_DOUBLE_EQ(at("l", 25)->mm, 70.0); // between 80 and the lane's own 60; one has no error
    EXPECT_FALSE(at("l", 25)->sd_mm);
    EXPECT_DOUBLE_EQ(at("R", 400)->mm, 100.0);
    EXPECT_DOUBLE_EQ(data::thickness_at(table, "base", "R", 0)->mm, 300.0);
    EXPECT_FALSE(data::thickness_at(table, "subbase", "R", 0));
    // Places as a road's file writes them: stations of 20 m.
    const auto of_20_m =
        data::read_layer_table(written("stations.csv", "chainage_m,asphalt_mm\n163,80\n163+10,90\n164,100\n"));
    EXPECT_DOUBLE_EQ(data::thickness_at(of_20_m, "asphalt", "", 3270)->mm, 90.0);
    EXPECT_NE(of_20_m.places.find("stations of 20 m"), std::string::npos);
    const auto fails = [](const std::string& text) {
        EXPECT_THROW(data::read_layer_table(written("bad.csv", text)), pave::Error) << text;
    };
    fails("chainage_m,rut\n0,3\n");
    fails("asphalt_mm\n80\n");
    fails("chainage_m,asphalt_mm\n0,-80\n");
    fails("chainage_m,asphalt_mm\n0,80\n0,90\n");
}

TEST(StationLayers, AreThePriorOfAThicknessThatIsSought) {
    const std::string sought = "[[parameters]]\nname = \"asphalt.thickness_mm\"\nmin = 50\nmax = 120\n";
    const study::Study study = survey_study("sought.toml", sought);
    data::FwdFile file = road(true);
    EXPECT_THROW(analysis::begin_survey({file}, study, {}), pave::Error) << "nobody states the error";
    for (auto& s : file.stations) {
        s.layers["Asphalt"].sd_mm = 5.0;
    }
    const auto begun = analysis::begin_survey({file}, study, {});
    const auto& s = begun.stations[1];
    const study::Study own = study::station_study(study, s.station, {&s.bowl()}, std::nullopt);
    ASSERT_TRUE(own.space.axes[3].prior);
    EXPECT_EQ(own.space.axes[3].prior->mean, 73.0);
    EXPECT_EQ(own.space.axes[3].prior->sd, 5.0);
    data::FwdStation thick = s.station;
    thick.layers["asphalt"].mm = 130.0;
    EXPECT_THROW(study::station_study(study, thick, {&s.bowl()}, std::nullopt), pave::Error);
}

TEST(StationLayers, DepthsOfOutputsMoveWithTheirLayer) {
    const auto output = [](const char* name, int depth_mm) {
        return "[[outputs]]\nname = \"" + std::string(name) +
               "\"\nload = \"fwd\"\nquantity = \"strain_zz\"\ndepth_mm = " + std::to_string(depth_mm) + "\n";
    };
    const study::Study study = survey_study("outputs.toml", output("in asphalt", 20) + output("bottom", 80) +
                                                                output("in base", 210) + output("in subgrade", 500));
    data::FwdStation s = road(false).stations[0];
    s.layers["asphalt"].mm = 100.0;
    const auto bowls = data::bowls_of(s);
    ASSERT_TRUE(bowls);
    const auto sensors = study::station_outputs(study, s, bowls->bowl()).model.sensors;
    ASSERT_EQ(sensors.size(), 4U);
    EXPECT_NEAR(sensors[0].depth, 0.025, 1e-12); // a quarter of the asphalt
    EXPECT_EQ(sensors[1].depth, 0.1);
    EXPECT_NEAR(sensors[2].depth, 0.23, 1e-12); // half of the base
    EXPECT_NEAR(sensors[3].depth, 0.52, 1e-12); // 160 mm into the subgrade
}

TEST(SectionTrials, NameTheLayerThatTheStudyLacks) {
    data::FwdFile file;
    for (int i = 0; i < 10; ++i) { // one metre of fill on something much stiffer
        file.stations.push_back(station_on({{0.08, (4000.0 + 150.0 * i) * 1e6, 0.35},
                                            {0.26, (300.0 + 15.0 * (i % 4)) * 1e6, 0.35},
                                            {1.0, (60.0 + 2.0 * (i % 3)) * 1e6, 0.35},
                                            {0.0, (400.0 + 10.0 * i) * 1e6, 0.35}},
                                           25.0 * i));
    }
    const auto result = surveyed(file, survey_study("three.toml"));
    ASSERT_FALSE(result.trials.empty());
    EXPECT_EQ(result.trials[0].words, "a further layer, subgrade parted 1 m below its top");
    EXPECT_LT(result.trials[0].misfit_ratio, 0.05);
    EXPECT_LT(result.trials[0].rms_percent, 0.5);
    // Nothing is tried where the section is right.
    EXPECT_TRUE(surveyed(road(true), survey_study("right.toml")).trials.empty());
}

namespace {

data::DeflectionBowl bowl(const std::vector<std::pair<double, double>>& readings, double pressure_kPa) {
    data::DeflectionBowl made;
    made.radius_mm = 150.0;
    made.pressure_kPa = pressure_kPa;
    for (const auto& [offset, um] : readings) {
        made.readings.push_back({.offset_mm = offset, .deflection_um = um});
    }
    return made;
}

} // namespace

TEST(Condition, IsByThePublishedLimitsOfEachKindOfBase) {
    using data::Condition;
    // At 566 kPa: D0 520, RoC 0.04 / (2 x 520e-6 x (1 - 416/520)) = 192 m, SCI 190, BDI 190, BCI 40.
    const auto indices =
        data::indices_of(bowl({{0, 520}, {200, 416}, {300, 330}, {600, 140}, {900, 100}}, data::condition_pressure_kPa),
                         data::condition_pressure_kPa);
    const auto granular = data::condition_of(indices, data::BaseKind::granular);
    EXPECT_EQ(granular.d0, Condition::warning);
    EXPECT_EQ(granular.roc, Condition::sound);
    EXPECT_EQ(granular.sci, Condition::sound);
    EXPECT_EQ(granular.bdi, Condition::warning);
    EXPECT_EQ(granular.bci, Condition::sound);
    const auto bituminous = data::condition_of(indices, data::BaseKind::bituminous);
    EXPECT_EQ(bituminous.d0, Condition::warning);
    EXPECT_EQ(bituminous.roc, Condition::warning);
    const auto cemented = data::condition_of(indices, data::BaseKind::cemented);
    EXPECT_EQ(cemented.d0, Condition::severe);
    EXPECT_EQ(cemented.bdi, Condition::severe);
    EXPECT_EQ(cemented.bci, Condition::warning);
    EXPECT_NEAR(data::condition_pressure_kPa, 565.88, 0.005); // 40 kN / (pi 0.15^2 m2)
}

TEST(StructuralNumber, IsThatOfTheGuide) {
    // 700 kPa on 150 mm: P = 49 480 N. At 600 mm: M_R = 0.24 x 49480 / (600 x 0.18) = 109.96 MPa. E_p and SN by the
    // formulas in pounds and inches (15 937 psi, 101.5 psi, H = 13.386 in), solved apart: 610.83 MPa and 2.6853. The
    // sensor at 300 mm is nearer than 0.7 a_e, some 430 mm.
    const auto found = data::structural_number(bowl({{0, 500}, {300, 330}, {600, 180}, {900, 110}}, 700.0), 340.0);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->offset_mm, 600.0);
    EXPECT_NEAR(found->subgrade_MPa, 109.96, 0.005);
    EXPECT_NEAR(found->pavement_MPa, 610.83, 0.01);
    EXPECT_NEAR(found->sn_eff, 2.6853, 1e-4);
    EXPECT_FALSE(data::structural_number(bowl({{0, 500}, {300, 330}}, 700.0), 340.0));
}
