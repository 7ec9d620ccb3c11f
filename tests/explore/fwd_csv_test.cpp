// Survey tables as spreadsheets save them. Expected values are those of the cells, or calculated as written beside
// them.
#include "base/error.h"
#include "data/fwd.h"
#include "data/fwd_places.h"
#include "support/folder.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>

using namespace explore;

namespace {

data::FwdFile read_file(const std::string& text, const data::ColumnMap& columns = {}) {
    const std::string file = test::own_folder() + "road.csv";
    std::ofstream(file, std::ios::binary) << text;
    return data::read_fwd(file, columns);
}

std::vector<data::FwdStation> read(const std::string& text, const data::ColumnMap& columns = {}) {
    return read_file(text, columns).stations;
}

void expect_complaint(const std::string& text, const std::vector<std::string>& words) {
    std::string message = "none";
    try {
        read(text);
    } catch (const pave::Error& error) {
        message = error.what();
    }
    for (const std::string& word : words) {
        EXPECT_NE(message.find(word), std::string::npos) << "'" << word << "' in: " << message;
    }
}

std::vector<double> deflections(const data::FwdDrop& drop) {
    std::vector<double> um;
    for (const auto& r : drop.readings) {
        um.push_back(r.deflection_um);
    }
    return um;
}

std::string utf16(const std::string& ascii, bool big_end_first) {
    std::string out = big_end_first ? "\xfe\xff" : "\xff\xfe";
    for (const char c : ascii) {
        (out += big_end_first ? '\0' : c) += big_end_first ? c : '\0';
    }
    return out;
}

const std::string plain = "station,chainage_m,radius_mm,load_kN,D0_um,D200_um,D300_um\n"
                          "A,0,150,50.2,500.1,400,330\n"
                          "B,50,150,50.1,510,405,333\n";

void expect_plain(const std::vector<data::FwdStation>& stations) {
    ASSERT_EQ(stations.size(), 2U);
    EXPECT_EQ(stations[1].chainage_m, 50.0);
    EXPECT_NEAR(*stations[0].drops[0].force_kN, 50.2, 1e-12);
    const auto um = deflections(stations[0].drops[0]);
    ASSERT_EQ(um.size(), 3U);
    EXPECT_NEAR(um[0], 500.1, 1e-9);
    EXPECT_NEAR(um[2], 330.0, 1e-9);
}

} // namespace

TEST(FwdCsv, OneColumnMayHaveTwoMeanings) {
    const auto stations =
        read("Ponto;Carga (kN);D0 (um);D300 (um)\n12;40;420;240\n14;40;430;250\n",
             {{"station", "Ponto"}, {"chainage_m", "Ponto"}, {"radius_mm", "150"}, {"load_kN", "Carga (kN)"}});
    ASSERT_EQ(stations.size(), 2U);
    EXPECT_EQ(stations[0].name, "12");
    EXPECT_EQ(stations[0].chainage_m, 12.0);
    EXPECT_EQ(stations[1].chainage_m, 14.0);
}

TEST(FwdCsv, ANumberedSensorThatTheMapDoesNotNameIsNotUsed) {
    const data::ColumnMap map{{"chainage_m", "Metros"}, {"load_kN", "Carga"},      {"radius_mm", "150"},
                              {"D0_um", "D1"},          {"D200 (1/100 mm)", "D2"}, {"D300_um", "D3"}};
    // Without a unit; and with one, where the numbers of the others are no places.
    for (const std::string last : {"D4", "D4 (um)"}) {
        const auto file = read_file("Metros,Carga,D1,D2,D3," + last + "\n10,40,420,31,240,33\n", map);
        ASSERT_EQ(file.stations.size(), 1U);
        EXPECT_EQ(deflections(file.stations[0].drops[0]), (std::vector<double>{420.0, 310.0, 240.0}));
        EXPECT_NE(pave::join(file.remarks).find("columns not used: " + last), std::string::npos);
    }
    // A map of other columns leaves deflections with places as they are.
    EXPECT_EQ(deflections(read("km,Carga,D0_um,D200_um\n1,40,420,310\n",
                               {{"chainage_km", "km"}, {"load_kN", "Carga"}, {"radius_mm", "150"}})[0]
                              .drops[0]),
              (std::vector<double>{420.0, 310.0}));
}

TEST(FwdCsv, PlacesMayBeStationsOf20Metres) {
    const auto places = [](const std::string& name, const std::vector<std::string>& cells) {
        std::string text = name + ",radius_mm,load_kN,D0_um,D200_um\n";
        for (const std::string& cell : cells) {
            text += cell + ",150,40,420,310\n";
        }
        const auto file = read_file(text);
        std::vector<double> m;
        for (const auto& s : file.stations) {
            m.push_back(*s.chainage_m);
        }
        return std::pair(m, pave::join(file.remarks));
    };
    using Metres = std::vector<double>;
    // 20 x 211 + 10 = 4230
    const auto mixed = places("chainage_m", {"212", "211+10", "211", "210+10"});
    EXPECT_EQ(mixed.first, (Metres{4240, 4230, 4220, 4210}));
    EXPECT_NE(mixed.second.find("stations of 20 m"), std::string::npos);
    // From the beginning of a road, where the same numbers could be metres: by the way along it.
    EXPECT_EQ(places("chainage_m", {"0", "0+10", "1", "1+10", "2"}).first, (Metres{0, 10, 20, 30, 40}));
    // Kilometres + metres beside metres.
    EXPECT_EQ(places("chainage_m", {"12+000", "12010", "12+020", "12030"}).first, (Metres{12000, 12010, 12020, 12030}));
    EXPECT_EQ(places("chainage_m", {"12+000", "12010", "12+020", "12030"}).second.find("20 m"), std::string::npos);
    // Neither: asked.
    const auto asked = places("chainage_m", {"45", "12+340", "12+360"});
    EXPECT_EQ(asked.first, (Metres{45, 12340, 12360}));
    EXPECT_NE(asked.second.find("are they stations of 20 m"), std::string::npos);
    EXPECT_NE(places("chainage_m", {"7+0", "7+10", "8+0", "8+10", "9+0"}).second.find("are they stations of 20 m"),
              std::string::npos);
    EXPECT_EQ(places("chainage_m", {"0+000", "0+025", "0+050", "1+000"}).second.find("20 m"), std::string::npos);
    // A column of that name counts them without a plus, too, where they are next to each other.
    const auto alone = [](const std::vector<std::string>& cells, const std::string& column) {
        const data::Places read(cells, column, 1.0, false);
        return std::pair(*read.metres(cells[1]), read.remark().empty());
    };
    EXPECT_EQ(alone({"163", "164", "165"}, "Estaca"), std::pair(3280.0, false));
    EXPECT_EQ(alone({"0", "20", "40"}, "Estaca"), std::pair(20.0, true));
    EXPECT_EQ(alone({"163", "164", "165"}, "chainage_m"), std::pair(164.0, true));
    // In feet "12+34" is 1234 ft, and "14" beside it 1400 ft; "1400" is that, too.
    const auto feet = [](const std::vector<double>& list) {
        Metres m;
        for (const double ft : list) {
            m.push_back(0.3048 * ft);
        }
        return m;
    };
    const auto near = [](const Metres& found, const Metres& expected) {
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
            EXPECT_NEAR(found[i], expected[i], 1e-9);
        }
    };
    const auto full = places("chainage_ft", {"12+34", "12+84", "13+34", "14", "14+50"});
    near(full.first, feet({1234, 1284, 1334, 1400, 1450}));
    EXPECT_NE(full.second.find("full stations of 100 ft"), std::string::npos) << full.second;
    near(places("chainage_ft", {"1234", "1284", "13+34", "1400"}).first, feet({1234, 1284, 1334, 1400}));
    near(places("chainage_ft", {"1234", "1284", "1400"}).first, feet({1234, 1284, 1400}));
}

TEST(FwdCsv, PlacesInFeetAreToldByMilsAndPounds) {
    const auto file =
        read_file("Station,radius_mm,load_lbf,D0_mil,D200_mil\n12+34,150,9000,15,12\n13+34,150,9000,15,12\n"
                  "1400,150,9000,15,12\n");
    EXPECT_NEAR(*file.stations[0].chainage_m, 0.3048 * 1234, 1e-9);
    EXPECT_NEAR(*file.stations[2].chainage_m, 0.3048 * 1400, 1e-9);
    EXPECT_NE(pave::join(file.remarks).find("\"1400\" are taken for feet"), std::string::npos)
        << pave::join(file.remarks);
}

TEST(FwdCsv, ARowOfPlacesMayLeaveASensorOut) {
    const auto file = read_file("chainage_m,radius_mm,load_kN,D1_um,D2_um,D3_um,D4_um\n,,,0,200 mm,?,600\n"
                                "0,150,40,420,310,99,150\n");
    std::vector<double> offsets;
    for (const auto& reading : file.stations[0].drops[0].readings) {
        offsets.push_back(reading.offset_mm);
    }
    EXPECT_EQ(offsets, (std::vector<double>{0, 200, 600}));
}

TEST(FwdCsv, UnitsAreReadAsTablesWriteThem) {
    for (const std::string unit : {"x10-2 mm", "x 10^-2 mm", "mm/100", "1/100 mm", "0.01 mm", "cmm"}) {
        const auto file =
            read_file("chainage_m,radius_mm,pressure (kN/m2),D0 (" + unit + "),D300 (" + unit + ")\n0,150,700,42,31\n");
        EXPECT_NEAR(file.stations[0].drops[0].readings[0].deflection_um, 420.0, 1e-9) << unit;
        EXPECT_NEAR(file.stations[0].drops[0].pressure_kPa, 700.0, 1e-9) << unit;
    }
    const auto file =
        read_file("chainage_m,radius_mm,pressure (N/mm2),D0 (0.001 mm),D300 (mm/1000)\n0,150,0.7,420,310\n");
    EXPECT_NEAR(file.stations[0].drops[0].readings[1].deflection_um, 310.0, 1e-9);
    EXPECT_NEAR(file.stations[0].drops[0].pressure_kPa, 700.0, 1e-9);
    try {
        read_file("chainage_m,radius_mm,load_kN,D0 (furlong),D300 (furlong)\n0,150,40,1,1\n");
        FAIL();
    } catch (const pave::Error& error) {
        EXPECT_NE(std::string(error.what()).find("the unit of this column is not known"), std::string::npos)
            << error.what();
    }
}

TEST(FwdCsv, LanesThatDifferInCaseOnlyAreOneInEveryAlphabet) {
    EXPECT_EQ(data::lower_case("S\u00dcD \u0160 \u0394 \u041c L"), "s\u00fcd \u0161 \u03b4 \u043c l");
    EXPECT_EQ(data::lower_case("\u00d7 \u20ac s\u00fcd"), "\u00d7 \u20ac s\u00fcd"); // no letters, or small ones
}

TEST(FwdCsv, ReadsStationsDropsAndUnits) {
    const auto stations = read("\xef\xbb\xbf# a road\r\n"
                               "D200_um,chainage_m,station,lane,load_kN,radius_mm,D0_mm,surface_C\r\n"
                               "300,10.5,\"A, north\",L1,42.4115,150,0.5,21\r\n"
                               "\r\n"
                               ",20,B,L1,42.4115,150,0.6,\r\n"
                               "330,10.5,\"A, north\",L1,42.4115,150,0.55,22\r\n");
    ASSERT_EQ(stations.size(), 2U);
    const data::FwdStation& a = stations[0];
    EXPECT_EQ(a.name, "A, north");
    EXPECT_EQ(a.lane, "L1");
    EXPECT_EQ(a.chainage_m, 10.5);
    EXPECT_EQ(a.line, 3);
    EXPECT_EQ(a.surface_C, 21.0);
    EXPECT_FALSE(a.air_C);
    ASSERT_EQ(a.drops.size(), 2U); // not one after the other in the file
    EXPECT_EQ(a.drops[1].number, 2);
    // 42.4115 kN / (pi 0.15^2 m2) = 42.4115 / 0.0706858 kPa = 600.0 kPa
    EXPECT_NEAR(a.drops[0].pressure_kPa, 600.0, 0.001);
    EXPECT_EQ(a.drops[0].readings[0].offset_mm, 0.0); // by offset, whatever the order of the columns
    EXPECT_EQ(deflections(a.drops[0]), (std::vector{500.0, 300.0}));
    EXPECT_EQ(stations[1].drops[0].readings.size(), 1U); // an empty cell: not read
    EXPECT_EQ(stations[1].line, 5);
}

TEST(FwdCsv, ReadsWhateverPartsCellsAndDecimals) {
    expect_plain(read(plain));
    std::string semicolons = plain;
    std::replace(semicolons.begin(), semicolons.end(), ',', ';');
    expect_plain(read(semicolons));
    std::string german = semicolons;
    std::replace(german.begin(), german.end(), '.', ',');
    expect_plain(read(german));
    expect_plain(read("sep=;\n" + german));
    std::string tabs = semicolons;
    std::replace(tabs.begin(), tabs.end(), ';', '\t');
    expect_plain(read(tabs));
    std::string returns = plain;
    std::replace(returns.begin(), returns.end(), '\n', '\r');
    expect_plain(read(returns));
    expect_plain(read(utf16(plain, false)));
    expect_plain(read(utf16(plain, true)));
    expect_plain(read("\xef\xbb\xbf" + plain));
    expect_plain(read(utf16(plain, false).substr(2))); // without its mark
    // Commas at the end of every line, and lines of nothing but commas.
    std::string trailing;
    for (const char c : plain) {
        trailing += c == '\n' ? std::string(",,\n") : std::string(1, c);
    }
    expect_plain(read(trailing + ",,,,,,,,\n"));
    // Decimal commas in quotes.
    expect_plain(read("station,chainage_m,radius_mm,load_kN,D0_um,D200_um,D300_um\n"
                      "A,0,150,\"50,2\",\"500,1\",400,330\nB,50,150,\"50,1\",510,405,333\n"));
}

TEST(FwdCsv, ReadsThousands) {
    const std::string header = "chainage_m;radius_mm;load_kN;D0_um\n";
    EXPECT_EQ(read(header + "12.340,5;150;50,0;1.234,5\n")[0].chainage_m, 12340.5);
    EXPECT_NEAR(deflections(read(header + "0;150;50,0;1.234,5\n")[0].drops[0])[0], 1234.5, 1e-9);
    EXPECT_NEAR(deflections(read(header + "0;150;50,0;1 234,5\n")[0].drops[0])[0], 1234.5, 1e-9);
    EXPECT_NEAR(deflections(read(header + "0;150;50.0;1'234.5\n")[0].drops[0])[0], 1234.5, 1e-9);
    EXPECT_NEAR(deflections(read(header + "0;150;50.5;1,234\n")[0].drops[0])[0], 1234.0, 1e-9); // a point elsewhere
    EXPECT_EQ(read("chainage_m,radius_mm,load_kN,D0_um\n\"12,340\",150,50,500\n")[0].chainage_m, 12340.0);
    expect_complaint(header + "0;150;50,2;500\n5;150;50.3;500\n", {":3", "load_kN", "50.3", "50,2", "line 2"});
}

TEST(FwdCsv, ReadsHeadersInOtherWords) {
    const auto check = [](const std::string& header, const std::string& row) {
        const auto stations = read(header + "\n" + row + "\n");
        const data::FwdDrop& drop = stations[0].drops[0];
        EXPECT_NEAR(drop.radius_mm, 150.0, 1e-5) << header;
        EXPECT_NEAR(drop.pressure_kPa, 700.0, 0.1) << header;
        ASSERT_EQ(drop.readings.size(), 2U) << header;
        EXPECT_NEAR(drop.readings[1].offset_mm, 304.8, 0.1) << header;
        EXPECT_NEAR(drop.readings[0].deflection_um, 508.0, 0.1) << header;
    };
    check("Station,Chainage_m,Radius_mm,Pressure_kPa,d0_um,d304.8_um", "A,0,150,700,508,200");
    check("CHAINAGE (m),PLATE RADIUS [mm],Stress (kPa),D0 (um),D304.8 [um]", "0,150,700,508,200");
    // 101.526 psi = 700 kPa; 11124 lbf on 0.0706858 m2 = 49.48 kN = 700 kPa; 20 mils = 508 um; 12 in = 304.8 mm
    check("Station (ft),Plate Radius (in),Pressure (psi),D0 (mils),D12in (mils)", "0,5.905512,101.526,20,8");
    check("Distance_ft,Plate diameter_mm,Load (lbf),D0_mils,D12in_mils", "0,300,11124,20,8");
    check("km,radius_mm,Load (kip),D0_\xc2\xb5m,D304.8_\xc2\xb5m", "0,150,11.124,508,200");
    check("\"Chainage, m\",\"Radius, mm\",\"Pressure, kPa\",\"D0, um\",\"D304.8, um\"", "0,150,700,508,200");
    check("km,radius_mm,Load (kPa),D(0) [mm],D(304.8) [mm]", "0,150,700,0.508,0.2");
}

TEST(FwdCsv, ReadsChainagesAsSurveyorsWriteThem) {
    const auto place = [](const std::string& unit, const std::string& cell) {
        return read("chainage_" + unit + ",radius_mm,load_kN,D0_um\n" + cell + ",150,50,500\n")[0].chainage_m.value_or(
            -1.0);
    };
    EXPECT_EQ(place("m", "12+340"), 12340.0);
    EXPECT_EQ(place("m", "ZK0+160"), 160.0);
    EXPECT_EQ(place("m", "K12+340.5"), 12340.5);
    EXPECT_EQ(place("m", "km 12+340"), 12340.0);
    EXPECT_EQ(place("km", "12+340"), 12340.0);
    EXPECT_EQ(place("km", "12.34"), 12340.0);
    EXPECT_NEAR(place("ft", "12+34"), 1234 * 0.3048, 1e-9); // stations of 100 ft
    EXPECT_NEAR(place("ft", "1234"), 1234 * 0.3048, 1e-9);
    // A table may have nothing but such a name.
    EXPECT_EQ(read("station,radius_mm,load_kN,D0_um\nK1+200,150,50,500\n")[0].chainage_m, 1200.0);
}

TEST(FwdCsv, WhatIsMissingCostsThatReadingAndNothingElse) {
    const std::string header = "station,chainage_m,radius_mm,load_kN,D0_um,D300_um,air_C,surface_C\n";
    for (const char* nil : {"", "-", "N/A", "NaN", "N0", "#VALUE!", "about 5"}) {
        const auto stations = read(header + "A,0,150,50,500," + nil + "," + nil + "," + nil + "\n");
        EXPECT_EQ(deflections(stations[0].drops[0]), std::vector{500.0}) << nil;
        EXPECT_FALSE(stations[0].air_C || stations[0].surface_C) << nil;
    }
    EXPECT_EQ(read(header + "A,0,150,50,500\n")[0].drops[0].readings.size(), 1U); // a short line
    EXPECT_EQ(read(header + "A,0,150,50,500,a lot,,\n")[0].remarks,
              std::vector<std::string>{"line 2, D300_um: \"a lot\" is not a number"});
    EXPECT_TRUE(std::isnan(read(header + "A,0,150,,500,200,,\n")[0].drops[0].pressure_kPa));
    EXPECT_TRUE(std::isnan(read(header + "A,0,,50,500,200,,\n")[0].drops[0].pressure_kPa));
    const auto nowhere = read(header + "A,?,150,50,500,200,,\n")[0];
    EXPECT_FALSE(nowhere.chainage_m);
    EXPECT_EQ(nowhere.remarks, std::vector<std::string>{"line 2: no chainage"});
    EXPECT_EQ(read("chainage_m,drop,radius_mm,pressure_kPa,D0_um\n0,first,150,600,500\n")[0].drops[0].number, 1);
    // A line with a cell too many is not to be trusted, the others are.
    const auto stations = read(header + "A,0,150,50,500,200,1,2,3\nB,9,150,50,500,200,1,2\n");
    EXPECT_NE(stations[0].unusable.find("9 cells and 8 columns"), std::string::npos);
    EXPECT_EQ(stations[1].unusable, "");
    expect_complaint(header + "A,0,150,50,2,500,200,10,20\n", {":2", "9", "8", "decimal commas"});
}

TEST(FwdCsv, KeepsPlaceTimeAndRemarkAndNamesWhatItDoesNotUse) {
    const data::FwdFile file =
        read_file("station,chainage_m,radius_mm,load_kN,D0_um,GPS Lat,Longitude,remark,date,time,crew,weather\n"
                  "A,0,150,50,500,48\xc2\xb0"
                  "58'26.1930\"\"N,2.5W,crack,2023-04-12,09:31,us,dry\n");
    const data::FwdStation& s = file.stations[0];
    EXPECT_EQ(file.remarks, std::vector<std::string>{"columns not used: crew, weather"});
    EXPECT_NEAR(*s.latitude, 48.0 + 58.0 / 60.0 + 26.193 / 3600.0, 1e-9);
    EXPECT_EQ(s.longitude, -2.5);
    EXPECT_EQ(s.comment, "crack");
    EXPECT_EQ(s.date + " " + s.time, "2023-04-12 09:31");
    EXPECT_NEAR(*read("chainage_m,radius_mm,load_kN,D0_um,surface_F\n0,150,50,500,77\n")[0].surface_C, 25.0, 1e-12);
}

TEST(FwdCsv, OneOfSeveralNamesIsMeant) {
    const data::FwdFile file =
        read_file("ID,Distance_m,Station,Chainage_m,radius_mm,load_kN,D0_um\n7,3,A,0,150,50,500\n");
    EXPECT_EQ(file.stations[0].name, "A");
    EXPECT_EQ(file.stations[0].chainage_m, 0.0);
    EXPECT_EQ(file.remarks, std::vector<std::string>{"columns not used: ID, Distance_m"});
    expect_complaint("chainage_m,radius_mm,load_kN,load_lbf,D0_um\n", {":1", "twice", "load_lbf"});
    expect_complaint("chainage_m,radius_mm,Load (stone),D0_um\n", {":1", "not stated", "Load (stone)"});
    // A table behind a table.
    EXPECT_EQ(read(plain + plain).size(), 2U);
    EXPECT_EQ(read(plain + plain)[0].drops.size(), 2U);
    // Points in positions, commas elsewhere.
    const auto s = read("chainage_m;radius_mm;load_kN;D0_um;lat\n0;150;50,2;500;48.97\n")[0];
    EXPECT_EQ(s.latitude, 48.97);
    EXPECT_NEAR(*s.drops[0].force_kN, 50.2, 1e-12);
}

TEST(FwdCsv, NumberedSensorsNeedTheirPlaces) {
    const std::string header = "chainage_m,radius_mm,load_kN,D1_um,D2_um,D3_um\n";
    const auto third = [](const std::vector<data::FwdStation>& stations) {
        return stations[0].drops.size() == 1 ? stations[0].drops[0].readings[2].offset_mm : -1.0;
    };
    expect_complaint(header + "0,150,50,500,400,330\n", {":1", "numbered", "D1_um", "D3_um", "--columns"});
    EXPECT_EQ(third(read(header + ",,,0,200,300\n0,150,50,500,400,330\n")), 300.0);
    EXPECT_EQ(third(read(header + "Offset (cm),,,0,20,30\n0,150,50,500,400,330\n")), 300.0);
    EXPECT_EQ(third(read(header + "0,150,50,500,400,330\n",
                         {{"D0_um", "D1_um"}, {"D200_um", "D2_um"}, {"D300_um", "D3_um"}})),
              300.0);
    // Units in a row of their own.
    const auto stations = read("chainage,radius,load,D0,D200\nm,mm,kN,mils,mils\n0,150,50,20,16\n");
    EXPECT_NEAR(deflections(stations[0].drops[0])[0], 508.0, 1e-9);
    EXPECT_EQ(read_file("chainage,radius_mm,load_kN,D0_um\n7,150,50,500\n").remarks,
              std::vector<std::string>{"the column \"chainage\" states no unit: it is taken for metres"});
}

TEST(FwdCsv, TakesAListOfColumns) {
    const std::string table = "Ort;Kraft;S1;S2\n0;50;500;400\n";
    const data::ColumnMap map =
        data::read_column_map("chainage_m=Ort, load_kN = Kraft; D0_um=S1, D300_um=S2, radius_mm=150");
    const auto stations = read(table, map);
    EXPECT_EQ(stations[0].drops[0].radius_mm, 150.0);
    EXPECT_EQ(stations[0].drops[0].force_kN, 50.0);
    EXPECT_EQ(stations[0].drops[0].readings[1].offset_mm, 300.0);
    const std::string file = test::own_folder() + "columns.txt";
    std::ofstream(file)
        << "# of our crew\nchainage_m = Ort\nload_kN = Kraft\nD0_um = S1\nD300_um = S2\nradius_mm = 150\n";
    EXPECT_EQ(data::read_column_map(file), map);
    EXPECT_THROW(data::read_column_map("load_kN"), pave::Error); // no such file
    EXPECT_THROW(data::read_column_map("load_kN="), pave::Error);
    EXPECT_THROW(data::read_column_map("load_kN=a,load_kN=b"), pave::Error);
    EXPECT_THROW(read(table, {{"load_kN", "Last"}}), pave::Error);
    EXPECT_THROW(read(table, {{"weight", "Kraft"}}), pave::Error);
}

TEST(FwdCsv, PressureAndLoadMayBothBeStated) {
    const std::string header = "chainage_m,radius_mm,pressure_kPa,load_kN,D0_um\n";
    // 49.48 kN / 0.0706858 m2 = 700.0 kPa
    EXPECT_TRUE(read(header + "0,150,700,49.48,500\n")[0].remarks.empty());
    const auto other = read(header + "0,150,600,49.48,500\n")[0];
    EXPECT_EQ(other.drops[0].pressure_kPa, 600.0);
    ASSERT_EQ(other.remarks.size(), 1U);
    EXPECT_NE(other.remarks[0].find("are 700 kPa"), std::string::npos) << other.remarks[0];
}

TEST(FwdCsv, SaysWhatIsWrongAndWhere) {
    expect_complaint("x,y\n1,2\n", {"known format", "chainage_m", "D0_um", "F25", "PDDX", "KUAB"});
    expect_complaint("", {"this file is empty"});
    expect_complaint("chainage_m,radius_mm,pressure_kPa,D0\n0,150,600,500\n", {":1", "no unit", "\"D0\"", "D0_um"});
    expect_complaint("chainage_m,radius_mm,load,D0_um\n0,150,600,500\n", {":1", "no unit", "\"load\"", "load_kN"});
    expect_complaint("chainage_m,radius_mm,pressure_kPa,D0_um,D0_mm\n", {":1", "twice", "D0_mm"});
    expect_complaint("chainage_m,pressure_kPa,D0_um\n", {":1", "radius_mm", "missing"});
    expect_complaint("radius_mm,pressure_kPa,D0_um\n", {":1", "chainage_m", "missing"});
    expect_complaint("chainage_m,radius_mm,D0_um\n", {"load", "neither", "pressure_kPa and load_kN"});
    expect_complaint("chainage_m,radius_mm,pressure_kPa\n", {"no column of deflections"});
    expect_complaint("chainage_m,radius_mm,pressure_kPa,D0_um\n", {"no stations"});
    expect_complaint("chainage_m,radius_mm,pressure_kPa,D0_um\n\"0,150\n", {":2", "never closed"});
}
