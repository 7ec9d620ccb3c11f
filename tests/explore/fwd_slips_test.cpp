// Slips and faults that leave a file readable: nothing is changed for them, and nothing is silent. Expected values are
// those of the cells, or calculated as written beside them.
#include "base/error.h"
#include "data/deflection_bowl.h"
#include "data/fwd.h"
#include "data/fwd_values.h"
#include "data/plausibility.h"
#include "support/folder.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;

// Built as one source with the other tests.
namespace fwd_slips {

namespace {

data::FwdFile read(const std::string& text, const char* name = "road.csv", const data::ColumnMap& columns = {}) {
    const std::string file = test::own_folder() + name;
    std::ofstream(file, std::ios::binary) << text;
    return data::read_fwd(file, columns);
}

std::string complaint(const std::string& text, const char* name = "road.csv") {
    try {
        read(text, name);
    } catch (const pave::Error& error) {
        return error.what();
    }
    return "none";
}

std::string joined(const std::vector<std::string>& list) {
    return pave::join(list, "\n");
}

bool holds(const std::string& text, std::string_view words) {
    return text.find(words) != std::string::npos;
}

// A drop of 40 kN on 150 mm (566 kPa) with this bowl.
data::FwdStation station(std::vector<data::FwdReading> readings, double radius_mm = 150.0, double force_kN = 40.0) {
    data::FwdDrop drop;
    drop.number = 1;
    drop.radius_mm = radius_mm;
    drop.force_kN = force_kN;
    drop.pressure_kPa = data::plate_pressure_kPa(force_kN, radius_mm);
    drop.readings = std::move(readings);
    data::FwdStation s;
    s.drops.push_back(std::move(drop));
    return s;
}

// The bowl of a half-space of 200 MPa times `share` far from the plate, rounded to a tenth.
std::vector<data::FwdReading> bowl(double share = 1.0) {
    return {{0, 450 * share},   {200, 320 * share}, {300, 240 * share},
            {600, 100 * share}, {900, 62 * share},  {1200, 46 * share}};
}

std::string said(const data::FwdStation& s) {
    const auto made = data::bowls_of(s);
    return made ? joined(made->remarks) : made.failure().reason;
}

const std::string header = "station,chainage_m,radius_mm,load_kN,D0_um,D200_um,D300_um,D600_um,D900_um\n";
const std::string line_a = "A,0,150,50,500,400,330,180,110\n";
const std::string line_b = "B,50,150,50,510,405,333,182,111\n";

} // namespace

TEST(Slips, ThatStayInTheRangesAreAsked) {
    EXPECT_EQ(said(station(bowl())), "");
    EXPECT_EQ(said(station(bowl(0.2))), ""); // 0.8775 x 566 x 22500 / (900 x 12.4) = 1001 MPa only at one sensor
    // 4.1 t, 9 kips in kN: 58 and 127 kPa
    EXPECT_TRUE(holds(said(station(bowl(), 150, 4.1)), "tonnes"));
    EXPECT_TRUE(holds(said(station(bowl(), 150, 9.0)), "kips"));
    auto pressure = station(bowl());
    pressure.drops[0].force_kN.reset();
    pressure.drops[0].pressure_kPa = 40.0; // kN; 82 psi
    EXPECT_TRUE(holds(said(pressure), "kN in a kPa column") || holds(said(pressure), "kN or psi in a kPa column"));
    pressure.drops[0].pressure_kPa = 82.0;
    EXPECT_TRUE(holds(said(pressure), "psi"));
    // mils, or hundredths of a millimetre, for micrometres: the ground would have 0.8775 x 566 x 22500 / (600 x 10) =
    // 1863 MPa
    EXPECT_TRUE(holds(said(station(bowl(1.0 / 25.4))), "mils in a _um column"));
    EXPECT_TRUE(holds(said(station(bowl(0.1))), "hundredths of a mm"));
    // The radius 150 in the place of the diameter: 40 kN on 75 mm
    EXPECT_TRUE(holds(said(station(bowl(), 75.0)), "the radius in place of the diameter"));
    // Offsets in cm of three sensors.
    EXPECT_TRUE(holds(said(station({{0, 450}, {30, 240}, {90, 62}})), "offsets in cm"));
}

TEST(Slips, SoundPlatesAndLoadsAreNotAsked) {
    EXPECT_EQ(said(station(bowl(), 225.0, 27.0)), "");               // 170 kPa
    EXPECT_EQ(said(station({{0, 400}, {300, 150}}, 50.0, 3.0)), ""); // light: 382 kPa
    EXPECT_EQ(said(station({{0, 64}, {200, 57}, {300, 52}, {600, 45}, {900, 36}, {1200, 28}}, 150.0, 51.0)),
              ""); // stiff road
    // The lower levels of a drop sequence are nobody's slip.
    auto levels = station(bowl(0.3), 150.0, 12.0);
    levels.drops.push_back(station(bowl()).drops[0]);
    levels.drops[1].number = 2;
    EXPECT_EQ(said(levels), "");
}

TEST(Slips, ALightDeflectometerHasItsOwnStandardLoad) {
    // 7.07 kN on 300 mm: 100 kPa. Beside other sensors it may be kips.
    EXPECT_EQ(said(station({{0, 520}}, 150.0, 7.07)), "");
    EXPECT_EQ(said(station({{0, 310}}, 100.0, 6.28)), ""); // 200 kPa on 200 mm
    EXPECT_TRUE(holds(said(station(bowl(), 150.0, 7.07)), "kips"));
    EXPECT_TRUE(holds(said(station({{0, 520}}, 150.0, 1.5)), "?")); // 21 kPa is nobody's standard
}

TEST(Slips, SeveralReadingsThatCannotBeAreASlip) {
    EXPECT_TRUE(holds(said(station({{0, 500}, {200, 400}, {300, 330e3}, {600, 180e3}})), "2 deflections beyond 10 mm"));
    EXPECT_TRUE(holds(said(station({{0, 500}, {200, 0.4}, {300, 0.33}, {600, 0.18}})), "millimetres in a _um column"));
    EXPECT_TRUE(holds(said(station(bowl(-1.0))), "the sign is turned"));
}

TEST(Sensors, TheOneThatContradictsTheOthersIsLeftOut) {
    const auto offsets = [](std::vector<data::FwdReading> readings) {
        std::vector<double> list;
        const auto made = data::bowls_of(station(std::move(readings)));
        if (made) {
            for (const auto& r : made->bowl().readings) {
                list.push_back(r.offset_mm);
            }
        }
        return list;
    };
    using Offsets = std::vector<double>;
    EXPECT_EQ(offsets({{0, 500}, {200, 400}, {300, 330}, {600, 180}, {900, 9999}}),
              (Offsets{0, 200, 300, 600})); // no value
    EXPECT_EQ(offsets({{0, 500}, {200, 400}, {300, 330}, {600, 180}, {900, 900}}), (Offsets{0, 200, 300, 600}));
    EXPECT_EQ(offsets({{0, 500}, {200, 400}, {300, 330}, {600, 600}, {900, 110}}), (Offsets{0, 200, 300, 900}));
    EXPECT_EQ(offsets({{0, 500}, {200, 100}, {300, 330}, {600, 180}, {900, 110}}), (Offsets{0, 300, 600, 900}));
    EXPECT_EQ(offsets({{0, 500}, {200, 5}, {300, 6}, {600, 180}, {900, 110}}), (Offsets{0, 600, 900})); // two are dead
    // Of one pair nobody can tell; and without the centre there is no bowl, which names the sensor.
    EXPECT_EQ(offsets({{0, 500}, {200, 300}, {300, 200}, {600, 250}, {900, 110}}), Offsets{});
    const std::string dead = said(station({{0, 20}, {200, 400}, {300, 330}, {600, 180}}));
    EXPECT_TRUE(holds(dead, "no reading at the centre") && holds(dead, "the sensor at 0 mm reads 20.0 um")) << dead;
}

TEST(Sensors, FarOnesThatAreNearlyDeadAreRemarked) {
    EXPECT_TRUE(holds(said(station({{0, 500}, {300, 330}, {600, 180}, {900, 11}})),
                      "from 180.0 um at 600 mm to 11.0 um at 900 mm"));
    EXPECT_TRUE(holds(said(station({{0, 500}, {300, 330}, {600, 180}, {900, 2}, {1200, 1.5}})), "nearly dead"));
    EXPECT_EQ(said(station({{0, 500}, {300, 330}, {600, 120}, {1800, 20}})), ""); // three times as far out
    EXPECT_TRUE(holds(said(station({{0, 500}, {300, 500}, {600, 500}, {900, 500}})), "does not fall"));
}

TEST(Sensors, WhatNoDropReadIsRemarkedWhereOthersReadIt) {
    const auto file = read(header + "A,0,150,50,500,400,N0,,110\n" + line_b + "C,90,150,50,520,410\n");
    EXPECT_EQ(said(file.stations[0]), "the sensors at 300, 600 mm gave no reading here");
    EXPECT_EQ(said(file.stations[1]), "");
    EXPECT_EQ(said(file.stations[2]), "the sensors at 300, 600, 900 mm gave no reading here");
    const auto never = read(header + "A,0,150,50,500,400,330,180,\nB,9,150,50,500,400,330,180,-\n");
    EXPECT_EQ(said(never.stations[0]), "");
    EXPECT_TRUE(holds(joined(never.remarks), "the sensor at 900 mm was never read"));
}

TEST(Tables, StationsOfTwoDatesSectionsOrRoadsAreTwo) {
    const auto dates = read("date,drop," + header + "2023-04-12 10:30,1," + line_a + "2023-04-12 10:31,2," + line_a +
                            "2024-04-12,1," + line_a + "2024-04-12,2," + line_a)
                           .stations;
    ASSERT_EQ(dates.size(), 2U);
    EXPECT_EQ(dates[0].drops.size(), 2U); // the time of day is none of the key
    const auto roads = read("Road,Section," + header + "A7,N," + line_a + "A7,S," + line_a + "B3,N," + line_a).stations;
    ASSERT_EQ(roads.size(), 3U);
    EXPECT_EQ(roads[1].profile, "A7 S");
    const auto sides =
        read("chainage_m,radius_mm,load_kN,D0_um,D200_um\nZK0+160,150,50,500,400\nYK0+160,150,50,300,200\n").stations;
    ASSERT_EQ(sides.size(), 2U);
    EXPECT_EQ(sides[0].lane, "ZK");
    EXPECT_EQ(read("chainage_m,radius_mm,load_kN,D0_um,D200_um\nZK0+160,150,50,500,400\n").stations[0].lane, "");
}

TEST(Tables, TheHeaderIsFoundWhereItStands) {
    for (const std::string& text :
         {"Project: A7\nDate: 2023-04-12\n\n" + header + line_a, "Project,A7,,\n,,,\n" + header + line_a,
          std::string("station,\"chainage\n(m)\",\"radius\n(mm)\",\"load\n(kN)\",\"D0\n(um)\",\"D200\n(um)\"\nA,0,150,"
                      "50,500,400\n"),
          std::string("station\uff0cchainage_m\uff0cradius_mm\uff0cload_kN\uff0cD0_um\uff0cD200_"
                      "um\nA\uff0c0\uff0c150\uff0c50\uff0c500\uff0c400\n"),
          std::string("chainage\uff08m\uff09,radius\uff08mm\uff09,load\uff08kN\uff09,D0\uff08um\uff09,"
                      "D200\uff08um\uff09\n0,150,50,\uff15\uff10\uff10,400\n"),
          std::string("station|chainage_m|radius_mm|load_kN|D0_um|D200_um\nA|0|150|50|500|400\n"),
          std::string("sep=,\nstation;chainage_m;radius_mm;load_kN;D0_um;D200_um\nA;0;150;50,0;500;400\n"),
          std::string("# station;chainage_m;radius_mm;load_kN;D0_um;D200_um\nA;0;150;50;500;400\n")}) {
        const auto stations = read(text).stations;
        ASSERT_EQ(stations.size(), 1U) << text;
        EXPECT_EQ(stations[0].chainage_m, 0.0) << text;
        EXPECT_EQ(stations[0].drops[0].force_kN, 50.0) << text;
        EXPECT_EQ(stations[0].drops[0].readings[0].deflection_um, 500.0) << text;
    }
    EXPECT_EQ(read("Project\n\n" + header + line_a).stations[0].line, 4);
    EXPECT_TRUE(holds(joined(read("Project\n" + header + line_a).remarks), "the header is line 2"));
    EXPECT_TRUE(holds(complaint("a,b,c\n1,2,3\n"), "no line of the first 30 names two columns"));
}

TEST(Tables, WhatIsNoTextIsSaid) {
    EXPECT_TRUE(holds(complaint(""), "is empty"));
    EXPECT_TRUE(holds(complaint(" \n\n"), "is empty"));
    EXPECT_TRUE(holds(complaint("PK\x03\x04 and more"), "workbook"));
    EXPECT_TRUE(holds(complaint("\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1 and more"), "workbook"));
    EXPECT_TRUE(holds(complaint("<html><table><tr><td>station</td></tr></table></html>"), "a page"));
    // GBK: two bytes above 0x7f a character. ISO 8859-1 has one here and there.
    EXPECT_TRUE(holds(joined(read("remark," + header + "\xc1\xd1\xb7\xec," + line_a).remarks), "GBK"));
    EXPECT_FALSE(holds(joined(read("remark," + header +
                                   "Stra\xdf"
                                   "e gesp\xfclt," +
                                   line_a)
                                  .remarks),
                       "GBK"));
    // Portuguese in Windows-1252: two letters in a row, a dash.
    EXPECT_FALSE(holds(joined(read("Execu\xe7\xe3o \x96 dia,remark," + header + "1,x," + line_a).remarks), "GBK"));
    EXPECT_TRUE(holds(complaint("\xd7\xae\xba\xc5,\xba\xc9\xd4\xd8\n1,2\n"), "GBK"));
}

TEST(Tables, ADashOfWindowsIsADash) {
    const auto file = read("Lugar \x96 metros;Carga;d0;d30\n20;40;500;300\n", "road.csv",
                           {{"chainage_m", "Lugar \u2013 metros"},
                            {"load_kN", "Carga"},
                            {"radius_mm", "150"},
                            {"D0_um", "d0"},
                            {"D300_um", "d30"}});
    ASSERT_EQ(file.stations.size(), 1U);
    EXPECT_EQ(file.stations[0].chainage_m, 20.0);
}

TEST(Tables, RowsThatAreNoStations) {
    const auto file = read("# above\n" + header + line_a + "#2,9,150,50,500,400,330,180,110\n# below\n" +
                           "STATION,CHAINAGE_M,RADIUS_MM,LOAD_KN,D0_UM,D200_UM,D300_UM,D600_UM,D900_UM\n" + line_b +
                           "Mean,,,50,505,402,331,181,110\nMittelwert,,150,50,505,402,331,181,110\n\x1a");
    ASSERT_EQ(file.stations.size(), 3U);
    EXPECT_EQ(file.stations[1].name, "#2"); // a row as long as the header
    EXPECT_TRUE(holds(joined(file.stations[1].remarks), "begins with #"));
    EXPECT_EQ(file.stations[2].name, "B");
    EXPECT_TRUE(holds(joined(file.remarks), "\"Mean\" is no station") && holds(joined(file.remarks), "\"Mittelwert\""));
}

TEST(Tables, NumbersOfTwoMeanings) {
    const std::string german = "station;chainage_m;radius_mm;load_kN;D0_um;D200_um\n";
    const auto doubt = [&](const std::string& rows) { return joined(read(german + rows).remarks); };
    EXPECT_TRUE(holds(doubt("A;1.250;150;50;500;400\n"), "thousands or decimals"));
    EXPECT_EQ(doubt("A;1.250;150;50,5;500;400\n"), "");
    // Points and commas before three digits: the comma is the decimal sign where it parts no cells.
    const auto both = read(german + "A;1.250;150;50,125;500;400\n").stations[0];
    EXPECT_EQ(both.chainage_m, 1250.0);
    EXPECT_EQ(both.drops[0].force_kN, 50.125);
    EXPECT_FALSE(
        read(header + "A,12+1340,150,50,500,400,330,180,110\n").stations[0].chainage_m); // one of the two is wrong
    // Stations of 100 ft beside pounds, of 1 km without them: 1234 ft = 376.1 m.
    const std::string american =
        "Station,Plate Radius (in),Load (lbf),D0in (mils),D12in (mils),D24in (mils)\n12+34,5.91,9034,19.7,13,7.1\n";
    EXPECT_NEAR(*read(american).stations[0].chainage_m, 1234 * 0.3048, 1e-9);
    EXPECT_EQ(read("Station,radius_mm,load_kN,D0_um,D300_um\n12+034,150,50,500,330\n").stations[0].chainage_m, 12034.0);
    EXPECT_NEAR(*read("chainage_m,radius_mm,load_t,D0 (1/100 mm),D300 (1/100 mm)\n0,150,5.1,50,33\n")
                     .stations[0]
                     .drops[0]
                     .force_kN,
                5.1 * 9.80665, 1e-9);
}

TEST(Tables, TemperaturesClocksAndRemarksOfOperators) {
    const auto s = read("surface_C,air_C,remark,time," + header + "20 \u00b0C,mild,crack,10:30," + line_a +
                        "21,,manhole,10:31," + line_a)
                       .stations[0];
    EXPECT_EQ(s.surface_C, 20.0);
    EXPECT_TRUE(holds(joined(s.remarks), "\"mild\" is no temperature"));
    EXPECT_EQ(s.comment, "crack; manhole");
    EXPECT_NEAR(*read("surface_C," + header + "68 F," + line_a).stations[0].surface_C, 20.0, 1e-9);
    for (const auto& [text, hour] : {std::pair{"1:30 PM", 13.5},
                                     {"12:15 am", 0.25},
                                     {"12:15 PM", 12.25},
                                     {"0.4375", 10.5},
                                     {"10h30", 10.5},
                                     {"10:30 Uhr", 10.5},
                                     {"10.30 Uhr", 10.5},
                                     {"2023-04-12 10:30", 10.5},
                                     {"45028.4375", 10.5},
                                     {"2023-04-12T10:30:00Z", 10.5}}) {
        const auto read_hour = data::hour_of_day(text);
        ASSERT_TRUE(read_hour) << text;
        EXPECT_NEAR(*read_hour, hour, 1e-9) << text;
    }
    for (const char* text : {"noon", "25:00", "13:30 PM", "10.3", "", "am"}) {
        EXPECT_FALSE(data::hour_of_day(text)) << text;
    }
}

TEST(Positions, StandOnTheGlobe) {
    EXPECT_EQ(data::degrees("W2.58"), -2.58);
    EXPECT_EQ(data::degrees("N48.97"), 48.97);
    EXPECT_NEAR(*data::degrees("-48 58 26"), -(48 + 58 / 60.0 + 26 / 3600.0), 1e-12);
    EXPECT_NEAR(*data::degrees("S 48 58 26"), -(48 + 58 / 60.0 + 26 / 3600.0), 1e-12);
    const auto at = [&](const std::string& latitude, const std::string& longitude) {
        return read("latitude,longitude," + header + latitude + "," + longitude + "," + line_a).stations[0];
    };
    EXPECT_EQ(at("48.97", "W2.58").longitude, -2.58);
    for (const auto& [latitude, longitude] :
         {std::pair{"148.97", "2.58"}, {"4858.4362", "00235.24"}, {"48.97", "somewhere"}}) {
        const auto s = at(latitude, longitude);
        EXPECT_FALSE(s.latitude || s.longitude) << latitude;
        EXPECT_TRUE(holds(joined(s.remarks), "no position on the globe")) << latitude;
    }
    const auto none = at("0", "0"); // what receivers write without a fix
    EXPECT_FALSE(none.latitude);
    EXPECT_TRUE(none.remarks.empty());
}

} // namespace fwd_slips
