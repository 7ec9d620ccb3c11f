// Repeated drops: which of them count, and what their mean is. Expected values are calculated by hand, as written
// beside them, or by simulation of what is stated.
#include "base/random.h"
#include "data/resolution.h"
#include "data/road_bowls.h"
#include "study/station.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;
using data::FwdStation;

// Built as one source with the other tests.
namespace drop_agreement {

namespace {

constexpr double offsets_mm[] = {0.0, 300.0, 450.0, 600.0, 900.0, 1200.0};
constexpr double bowl_um[] = {400.0, 240.0, 180.0, 130.0, 80.0, 50.0};

// Drops at 700 kPa with these deflections over those of the bowl: a row a drop.
FwdStation station(const std::string& name, const std::vector<std::vector<double>>& factors) {
    FwdStation s{.name = name, .lane = {}, .file = "made up"};
    s.chainage_m = 0.0;
    for (const auto& row : factors) {
        data::FwdDrop drop{
            .number = static_cast<int>(s.drops.size()) + 1, .radius_mm = 150.0, .pressure_kPa = 700.0, .readings = {}};
        for (std::size_t i = 0; i < std::size(offsets_mm); ++i) {
            drop.readings.push_back({offsets_mm[i], bowl_um[i] * row[i]});
        }
        s.drops.push_back(std::move(drop));
    }
    return s;
}

const std::vector<double> plain(6, 1.0);
std::vector<double> with(std::size_t sensor, double factor) {
    std::vector<double> row = plain;
    row[sensor] = factor;
    return row;
}
std::vector<double> whole(double factor) {
    return std::vector<double>(6, factor);
}

double deflection(const data::StationBowls& bowls, std::size_t sensor) {
    return bowls.bowl().readings[sensor].deflection_um;
}

std::string joined(const data::StationBowls& bowls) {
    return pave::join(bowls.remarks, "\n");
}

// A road whose drops scatter by so much at every sensor, all of a drop alike and each by itself.
std::vector<FwdStation> road(int stations, int drops, double common, double own, std::uint64_t seed) {
    std::vector<FwdStation> made;
    for (int s = 0; s < stations; ++s) {
        std::vector<std::vector<double>> factors;
        for (int d = 0; d < drops; ++d) {
            const pave::RandomStream random(seed, static_cast<std::uint64_t>(s * drops + d));
            auto& row = factors.emplace_back();
            for (std::size_t i = 0; i < 6; ++i) {
                row.push_back(1.0 + common * random.normal(99) + own * random.normal(i));
            }
        }
        made.push_back(station("S" + std::to_string(s), factors));
    }
    return made;
}

std::vector<pave::Outcome<data::StationBowls>> bowls_of(const std::vector<FwdStation>& stations) {
    std::vector<const FwdStation*> list;
    for (const FwdStation& s : stations) {
        list.push_back(&s);
    }
    return data::bowls_of_road(list);
}

} // namespace

// Two sensors at 600 mm, 130 and 150 um in the first drop, 130 and 134 um in the second: 140 and 132, and of all 136.
TEST(Drops, OfTwoSensorsAtOnePlaceHaveOneReading) {
    FwdStation made = station("A", {plain, plain});
    made.drops[0].readings.push_back({600.0, 150.0});
    made.drops[1].readings.push_back({600.0, 134.0});
    const auto bowls = data::bowls_of(made, {.keeps_contradicted = true});
    ASSERT_TRUE(bowls);
    EXPECT_NEAR(deflection(*bowls, 3), 136.0, 1e-9);
    EXPECT_EQ(bowls->bowl().readings[3].drops, 2);
    made.drops.pop_back(); // of one drop alone there is nothing to compare with
    EXPECT_NEAR(deflection(*data::bowls_of(made, {}), 3), 140.0, 1e-9);
}

TEST(DropAgreement, TheMeanOfTheDropsIsTaken) {
    const auto bowls = data::bowls_of(station("A", {whole(0.99), whole(1.0), whole(1.02)}));
    EXPECT_NEAR(deflection(*bowls, 0), 400.0 * 3.01 / 3.0, 1e-9);
    EXPECT_EQ(bowls->bowl().readings[0].drops, 3);
    EXPECT_TRUE(bowls->remarks.empty() && bowls->readings_left_out.empty());
}

TEST(DropAgreement, AReadingThatItsRepeatsContradictIsLeftOutByName) {
    const auto bowls = data::bowls_of(station("A", {with(5, 17.0), whole(1.01), whole(0.99), plain}));
    ASSERT_EQ(bowls->readings_left_out.size(), 1U);
    EXPECT_EQ(bowls->readings_left_out[0].drop, 1);
    EXPECT_EQ(bowls->readings_left_out[0].offset_mm, 1200.0);
    EXPECT_NE(
        joined(*bowls).find("the sensor at 1200 mm in drop 1 reads 850.0 um, its repeats 50.0 um: it is left out"),
        std::string::npos)
        << joined(*bowls);
    EXPECT_NEAR(deflection(*bowls, 5), 50.0, 1e-9);
    EXPECT_EQ(bowls->bowl().readings[5].drops, 3);
    EXPECT_NEAR(deflection(*bowls, 0), 400.0, 1e-9); // its other readings count
    EXPECT_EQ(bowls->bowl().readings[0].drops, 4);
    EXPECT_LT(*data::repeatability({&bowls->bowl()}), 0.011);
    // A sensor that read nothing in one drop.
    const auto silent = data::bowls_of(station("A", {with(3, 0.0), whole(1.01), whole(0.99)}));
    EXPECT_NEAR(deflection(*silent, 3), 130.0, 1e-9);
}

TEST(DropAgreement, OfTwoDropsTheNeighbouringSensorsTell) {
    // 500 um at 1200 mm where 80 um are read at 900 mm; 10 um at 600 mm between 180 and 80 um.
    const auto high = data::bowls_of(station("A", {with(5, 10.0), plain}));
    EXPECT_NEAR(deflection(*high, 5), 50.0, 1e-9);
    const auto low = data::bowls_of(station("A", {plain, with(3, 1.0 / 13.0)}));
    EXPECT_NEAR(deflection(*low, 3), 130.0, 1e-9);
    EXPECT_EQ(low->readings_left_out[0].drop, 2);
    // 30 % apart and both possible: both stay, with a word that names station and sensor.
    const auto open = data::bowls_of(station("A", {plain, with(3, 0.74)}));
    EXPECT_NEAR(deflection(*open, 3), 130.0 * 0.87, 1e-9);
    EXPECT_TRUE(open->bowl().readings[3].disagrees);
    EXPECT_NE(joined(*open).find("the drops disagree by 30 % at 600 mm (96.2 to 130.0 um)"), std::string::npos)
        << joined(*open);
    // Its own scatter is its error: ln(1 / 0.74) / sqrt(2) over sqrt(2), of 113.1 um: 17.0 um; with 1 um and 1.1 um.
    EXPECT_NEAR(study::bowl_sigma_um(open->bowl().readings[3], 0.01), std::sqrt(17.03 * 17.03 + 1.0 + 1.131 * 1.131),
                0.01);
}

// Three of five agree: the other two go, though they agree with each other. Of four that fall into two halves the
// neighbours tell: 500 um do not stand between 80 um and nothing, as 50 um do.
TEST(DropAgreement, TheMajorityCountsAndOfHalvesTheNeighboursTell) {
    const auto five = data::bowls_of(station("A", {with(5, 10.0), plain, whole(1.01), with(5, 10.1), whole(0.99)}));
    EXPECT_NEAR(deflection(*five, 5), 50.0, 1e-9);
    EXPECT_EQ(five->readings_left_out.size(), 2U);
    EXPECT_TRUE(five->disagreements.empty());
    const auto four = data::bowls_of(station("A", {with(5, 10.0), plain, with(5, 10.1), whole(1.01)}));
    EXPECT_NEAR(deflection(*four, 5), 50.0 * 1.005, 1e-9);
    EXPECT_EQ(four->readings_left_out.size(), 2U);
    const auto open = data::bowls_of(station("A", {with(3, 0.74), plain, with(3, 0.74), plain})); // both possible
    EXPECT_TRUE(open->readings_left_out.empty());
    EXPECT_EQ(open->disagreements.size(), 1U);
}

namespace {

// The same under other loads, proportional to them.
FwdStation levels(const std::vector<double>& kPa, const std::vector<std::vector<double>>& factors) {
    FwdStation s = station("A", factors);
    for (std::size_t d = 0; d < s.drops.size(); ++d) {
        s.drops[d].pressure_kPa = kPa[d];
        for (auto& reading : s.drops[d].readings) {
            reading.deflection_um *= kPa[d] / 700.0;
        }
    }
    return s;
}

} // namespace

TEST(DropAgreement, OneDropALevelIsContradictedByTheOtherLevels) {
    const auto bowls = data::bowls_of(levels({350, 550, 800}, {plain, with(2, 1.6), whole(1.03)}));
    ASSERT_EQ(bowls->readings_left_out.size(), 1U);
    EXPECT_EQ(bowls->readings_left_out[0].drop, 2);
    EXPECT_EQ(bowls->readings_left_out[0].offset_mm, 450.0);
    EXPECT_NE(joined(*bowls).find("under the other loads"), std::string::npos);
    EXPECT_FALSE(bowls->levels[1].has_sensor_at(450.0));
    // A pavement that softens, by as much at every sensor, contradicts nothing; nor does a tenth at one.
    EXPECT_TRUE(data::bowls_of(levels({350, 550, 800}, {plain, whole(1.2), whole(1.5)}))->readings_left_out.empty());
    EXPECT_TRUE(data::bowls_of(levels({350, 550, 800}, {plain, with(2, 1.1), plain}))->readings_left_out.empty());
}

// Twice the pressure and the same deflections: the load is misread.
TEST(DropAgreement, ALoadThatIsMisreadLeavesItsDropOut) {
    FwdStation made = station("A", {plain, whole(1.01), plain, whole(0.99)});
    made.drops[1].pressure_kPa = 1400.0;
    const auto bowls = data::bowls_of(made);
    ASSERT_EQ(bowls->levels.size(), 1U);
    EXPECT_NEAR(bowls->bowl().pressure_kPa, 700.0, 1e-9);
    ASSERT_EQ(bowls->left_out.size(), 1U);
    EXPECT_EQ(bowls->left_out[0].number, 2);
    EXPECT_NE(bowls->left_out[0].words.find("drops 1, 3, 4 under 700 kPa"), std::string::npos)
        << bowls->left_out[0].words;
    // Of a heavier load that bends the road by a third more nothing is said.
    FwdStation heavier = levels({700, 700, 1000}, {plain, plain, whole(0.93)});
    EXPECT_EQ(data::bowls_of(heavier)->levels.size(), 2U);
}

TEST(DropAgreement, ADropThatItsRepeatsContradictIsLeftOut) {
    const auto bowls = data::bowls_of(station("A", {whole(1.01), whole(1.34), whole(0.99)}));
    ASSERT_EQ(bowls->left_out.size(), 1U);
    EXPECT_EQ(bowls->left_out[0].number, 2);
    EXPECT_EQ(bowls->left_out[0].why, data::LeftOut::contradicted);
    EXPECT_NE(bowls->left_out[0].words.find("+34 %"), std::string::npos);
    EXPECT_NEAR(deflection(*bowls, 0), 400.0, 1e-9);
    // Chosen by number it counts.
    const auto chosen = data::bowls_of(station("A", {whole(1.01), whole(1.34), whole(0.99)}), {.numbers = {1, 2, 3}});
    EXPECT_NEAR(deflection(*chosen, 0), 400.0 * 3.34 / 3.0, 1e-9);
    // Three that all differ: none has a majority.
    const auto apart = data::bowls_of(station("A", {whole(0.8), whole(1.0), whole(1.2)}));
    EXPECT_TRUE(apart->left_out.empty() && apart->readings_left_out.empty());
    EXPECT_NE(joined(*apart).find("the drops disagree by 40 %"), std::string::npos) << joined(*apart);
}

TEST(DropAgreement, NoiseIsNoContradiction) {
    // 2.3 % of each drop: a scatter that a single station could take for contradictions. 2000 drops, 12,000 readings.
    std::size_t left_out = 0;
    for (const auto& s : bowls_of(road(400, 5, 0.012, 0.02, 3))) {
        left_out += s->left_out.size() + s->readings_left_out.size();
    }
    EXPECT_LE(left_out, 2U);
}

TEST(DropAgreement, RoundingIsNoContradiction) {
    // Far sensors in whole hundredths of a millimetre: 50 um of two drops and 60 um of one, 17 % apart by rounding.
    std::vector<double> high = plain;
    high[4] = 90.0 / 80.0;
    high[5] = 60.0 / 50.0;
    const FwdStation s = station("A", {plain, high, plain});
    const auto bowls = data::bowls_of(s, {.resolution_um = 10.0});
    EXPECT_TRUE(bowls->readings_left_out.empty() && bowls->left_out.empty() && bowls->disagreements.empty());
    EXPECT_NEAR(deflection(*bowls, 5), 160.0 / 3.0, 1e-9);
    // Read to the micrometre it contradicts its repeats.
    EXPECT_FALSE(data::bowls_of(s, {.resolution_um = 1.0})->readings_left_out.empty());
}

TEST(DropAgreement, OneSpikeDoesNotRuleARoad) {
    for (const int drops : {2, 3, 4}) {
        auto stations = road(20, drops, 0.004, 0.006, 7);
        const auto repeatability_of = [](const std::vector<FwdStation>& list) {
            std::vector<data::DeflectionBowl> bowls;
            for (const auto& s : bowls_of(list)) {
                bowls.push_back(s->bowl());
            }
            std::vector<const data::DeflectionBowl*> all;
            for (const auto& b : bowls) {
                all.push_back(&b);
            }
            return *data::repeatability(all);
        };
        const double clean = repeatability_of(stations);
        EXPECT_NEAR(clean, std::hypot(0.004, 0.006), 0.001);
        // 12 % beyond its repeats at a sensor that repeats within 0.7 %: no single station could tell of two drops.
        stations[4].drops[1].readings[5].deflection_um *= 17.0;
        EXPECT_NEAR(repeatability_of(stations), clean, 0.03 * clean) << drops;
        if (drops > 2) {
            stations[4].drops[1].readings[5].deflection_um *= 1.12 / 17.0;
            EXPECT_EQ(bowls_of(stations)[4]->readings_left_out.size(), 1U) << drops;
        }
    }
}

TEST(Resolution, IsTheLargestStepThatAllReadingsShare) {
    const auto of = [](std::vector<double> values) {
        FwdStation s{.name = "A", .lane = {}, .file = {}};
        for (const double um : values) {
            s.drops.push_back({.number = 1, .readings = {{0.0, um}}});
        }
        return data::resolution_um({&s});
    };
    EXPECT_EQ(of({430, 310, 250, 120, 70}), 10.0);
    EXPECT_EQ(of({431, 310, 252, 120, 77}), 1.0);
    EXPECT_NEAR(of({431.5, 310.2, 252, 120, 77}), 0.1, 1e-12);
    EXPECT_EQ(of({431.53, 310.21, 252.7, 120, 77}), 0.0);
    EXPECT_NEAR(of({16 * 25.4, 11 * 25.4, 7 * 25.4, 4 * 25.4, 2 * 25.4}), 25.4, 1e-9);      // whole mils
    EXPECT_NEAR(of({161 * 2.54, 113 * 2.54, 70 * 2.54, 40 * 2.54, 21 * 2.54}), 2.54, 1e-9); // tenths of them
    // Five readings are even by chance at one of 32 places: not taken for steps of 2 um.
    EXPECT_EQ(of({432, 310, 252, 120, 78}), 1.0);
    // One cell in ten that was mended by hand does not make a file exact; one in five does.
    EXPECT_EQ(of({430, 310, 250, 120, 70, 60, 50, 410, 290, 233}), 10.0);
    EXPECT_EQ(of({430, 310, 250, 121, 77}), 1.0);
    EXPECT_EQ(data::resolution_words(10.0), "whole hundredths of a millimetre");
    EXPECT_EQ(data::resolution_words(25.4), "whole mils");
}

// Half of the stations of a file in whole hundredths of a millimetre: those have that error, the others not.
TEST(Resolution, IsThatOfTheStationWhereTheFileHasNone) {
    std::vector<FwdStation> stations;
    for (int i = 0; i < 12; ++i) {
        auto& s = stations.emplace_back(station("S" + std::to_string(i), {whole(1.0 + 0.013 * i), whole(1.1)}));
        for (auto& drop : s.drops) {
            for (auto& reading : drop.readings) {
                reading.deflection_um =
                    i % 2 == 0 ? 10.0 * std::round(reading.deflection_um / 10.0) : reading.deflection_um + 0.37;
            }
        }
    }
    const auto bowls = bowls_of(stations);
    for (std::size_t i = 0; i < bowls.size(); ++i) {
        EXPECT_EQ(bowls[i]->bowl().readings[0].resolution_um, i % 2 == 0 ? 10.0 : 0.0) << i;
    }
}

// The error of the mean of n rounded readings, by simulation.
TEST(Resolution, RoundingIsAnErrorThatMeansShareOrNot) {
    constexpr double step = 10.0;
    for (const int n : {1, 3, 6}) {
        for (const double sd : {0.0, 0.5, 2.0, 4.0, 8.0}) {
            double error = 0.0;
            constexpr int trials = 40000;
            for (int t = 0; t < trials; ++t) {
                const pave::RandomStream random(11, static_cast<std::uint64_t>(t));
                const double truth = 100.0 + step * random.uniform(1000);
                double mean = 0.0;
                for (int d = 0; d < n; ++d) {
                    mean += step * std::round((truth + sd * random.normal(static_cast<std::uint64_t>(d))) / step) / n;
                }
                error += std::pow(mean - truth, 2) / trials;
            }
            const double stated = sd * sd / n + data::rounding_variance(step, sd, n);
            EXPECT_NEAR(std::sqrt(stated / error), 1.0, 0.05) << n << " drops, " << sd << " um";
        }
    }
}

TEST(Resolution, RoundingIsNoScatterOfTheDrops) {
    // 2 % of 200 um, read in whole 10 um: 4 um and 2.9 um.
    std::vector<data::DeflectionBowl> bowls;
    for (std::uint64_t s = 0; s < 2000; ++s) {
        const pave::RandomStream random(5, s);
        FwdStation made{.name = "A", .lane = {}, .file = {}};
        made.chainage_m = 0.0;
        const double d0 = 195.0 + 10.0 * random.uniform(50);
        for (int d = 0; d < 3; ++d) {
            const double um =
                10.0 * std::round(d0 * (1.0 + 0.02 * random.normal(static_cast<std::uint64_t>(d))) / 10.0);
            made.drops.push_back({.number = d + 1, .radius_mm = 150.0, .pressure_kPa = 700.0, .readings = {{0.0, um}}});
        }
        bowls.push_back(data::bowls_of(made, {.resolution_um = 10.0})->bowl());
    }
    std::vector<const data::DeflectionBowl*> all;
    for (const auto& b : bowls) {
        all.push_back(&b);
    }
    EXPECT_NEAR(*data::repeatability(all), 0.02, 0.001);
}

} // namespace drop_agreement
