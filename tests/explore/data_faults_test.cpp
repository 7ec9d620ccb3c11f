// Faults that the readings of bowls show by themselves, on bowls of a formula.
#include "data/bowl_faults.h"
#include "data/rounding.h"

#include "base/random.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

using namespace explore;
using data::BowlFault;
using data::BowlPoint;

namespace {

const std::vector<double> offsets{0.0, 0.2, 0.3, 0.45, 0.6, 0.9, 1.2, 1.5};

// D0 / (1 + (r / length)^1.5) under so many loads, 1 % and 1 um of noise, or more.
std::vector<BowlPoint> bowls(std::uint64_t seed, int loads = 2, double share = 0.01, double least = 1e-6) {
    const pave::RandomStream random(seed, 0);
    std::uint64_t next = 0;
    const double length = 0.2 + 0.4 * random.uniform(next++);
    std::vector<BowlPoint> list;
    for (int load = 0; load < loads; ++load) {
        for (const double r : offsets) {
            const double value = 0.4e-3 * (1.0 + 0.8 * load) / (1.0 + std::pow(r / length, 1.5));
            const double deviation = std::hypot(share * value, least);
            list.push_back({list.size(), load, r, value + deviation * random.normal(next++), deviation});
        }
    }
    return list;
}

void exchange(std::vector<BowlPoint>& list, std::size_t a, std::size_t b) {
    for (std::size_t first = 0; first < list.size(); first += offsets.size()) {
        std::swap(list[first + a].value, list[first + b].value);
        std::swap(list[first + a].deviation, list[first + b].deviation);
    }
}

} // namespace

TEST(BowlFaults, AreNoneInBowlsAsTheyAre) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        for (const int loads : {1, 2, 3}) {
            const auto found = data::bowl_faults(bowls(seed, loads));
            EXPECT_TRUE(found.empty()) << seed << ": " << found[0].words();
        }
    }
}

TEST(BowlFaults, TwoSensorsExchangedAreNamed) {
    int right = 0;
    int count = 0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        for (std::size_t a = 0; a + 1 < offsets.size(); ++a) {
            for (std::size_t b = a + 1; b < std::min(a + 4, offsets.size()); ++b) {
                auto list = bowls(seed);
                exchange(list, a, b);
                const auto found = data::bowl_faults(list);
                ++count;
                right += found.size() == 1 && found[0].kind == BowlFault::Kind::exchanged &&
                         found[0].offsets == std::vector<double>{offsets[a], offsets[b]};
            }
        }
    }
    EXPECT_GE(right, count * 95 / 100) << "of " << count;
    auto list = bowls(1);
    exchange(list, 4, 5);
    EXPECT_EQ(data::bowl_faults(list)[0].words(), "the sensors at 600 and 900 mm are exchanged");
}

TEST(BowlFaults, ReadingsExchangedUnderOneLoadAreNamed) {
    int right = 0;
    constexpr int count = 20;
    for (std::uint64_t seed = 0; seed < count; ++seed) {
        auto list = bowls(seed);
        std::swap(list[3].value, list[4].value);
        std::swap(list[3].deviation, list[4].deviation);
        const auto found = data::bowl_faults(list);
        right += found.size() == 1 && found[0].kind == BowlFault::Kind::exchanged && found[0].of_one_load &&
                 found[0].rows == std::vector<std::size_t>{3, 4};
    }
    EXPECT_GE(right, count * 9 / 10);
}

// Deflections over pressure times radius are about the same under every load.
TEST(BowlFaults, AllReadingsOfOneLoadInAnotherUnitAreNamed) {
    for (const double factor : {10.0, 25.4, 1.0 / 25.4, 0.1}) {
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            auto list = bowls(seed, 3);
            for (auto& reading : list) {
                reading.strength = 0.15 * 400e3 * (1.0 + 0.8 * reading.load);
            }
            EXPECT_TRUE(data::bowl_faults(list).empty());
            for (auto& reading : list) {
                if (reading.load == 1) {
                    reading.value *= factor;
                    reading.deviation *= factor;
                }
            }
            const auto found = data::bowl_faults(list);
            ASSERT_EQ(found.size(), 1U) << factor << " " << seed;
            EXPECT_TRUE(found[0].of_one_load && found[0].kind == BowlFault::Kind::factor);
            EXPECT_NEAR(found[0].factor, factor, 1e-12);
            EXPECT_EQ(found[0].rows.size(), offsets.size());
        }
    }
}

// A rise of three and a half standard deviations under each load is five and more under all of them.
TEST(BowlFaults, TwoSensorsExchangedAreNamedByAllLoadsTogether) {
    for (const double rise : {3.5, 0.5}) {
        auto list = bowls(1);
        exchange(list, 3, 4);
        std::map<int, std::pair<double, double>> of_load; // what the two sensors read
        for (const auto& reading : list) {
            if (reading.offset == offsets[3]) {
                of_load[reading.load].first = reading.value;
            } else if (reading.offset == offsets[4]) {
                of_load[reading.load].second = reading.value;
            }
        }
        ASSERT_GT(of_load.size(), 1U);
        for (auto& reading : list) {
            const auto& [near, far] = of_load[reading.load];
            reading.deviation = (far - near) / (rise * std::sqrt(2.0));
        }
        const auto found = data::bowl_faults(list);
        EXPECT_EQ(found.size(), rise > 1.0 ? 1U : 0U) << "of " << rise;
        if (!found.empty()) {
            EXPECT_EQ(found[0].kind, BowlFault::Kind::exchanged);
        }
    }
}

TEST(BowlFaults, SensorsCountedFromTheFarEndAreNamed) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        auto list = bowls(seed);
        const auto before = list;
        for (std::size_t i = 0; i < list.size(); ++i) {
            const std::size_t first = i / offsets.size() * offsets.size();
            const std::size_t from = first + offsets.size() - 1 - (i - first);
            list[i].value = before[from].value;
            list[i].deviation = before[from].deviation;
        }
        const auto found = data::bowl_faults(list);
        ASSERT_EQ(found.size(), 1U) << seed;
        EXPECT_TRUE(found[0].kind == BowlFault::Kind::reversed) << seed << found[0].words();
    }
}

TEST(BowlFaults, ASensorOrAReadingInAnotherUnitIsNamed) {
    int right = 0;
    int count = 0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        for (const double factor : {10.0, 25.4, 1000.0, 1.0 / 25.4, 1.0 / 1000.0}) {
            for (const std::size_t sensor : {0, 3, 5}) {
                for (const bool one_load : {false, true}) {
                    if (sensor == 0 && factor < 1.0) {
                        continue; // a weak centre: the next reading rises
                    }
                    auto list = bowls(seed);
                    for (std::size_t first = 0; first < list.size(); first += offsets.size()) {
                        if (!one_load || first == 0) {
                            list[first + sensor].value *= factor;
                            list[first + sensor].deviation *= factor;
                        }
                    }
                    const auto found = data::bowl_faults(list);
                    ++count;
                    right += found.size() == 1 && found[0].kind == BowlFault::Kind::factor &&
                             std::abs(std::log(found[0].factor / factor)) < 1e-9 &&
                             found[0].offsets[0] == offsets[sensor] && found[0].rows.size() == (one_load ? 1U : 2U);
                }
            }
        }
    }
    EXPECT_GE(right, count * 9 / 10) << "of " << count;
}

TEST(BowlFaults, OneValueForAllIsNamed) {
    auto list = bowls(1);
    for (std::size_t i = 0; i < offsets.size(); ++i) {
        list[i].value = 0.3e-3;
    }
    auto found = data::bowl_faults(list);
    ASSERT_FALSE(found.empty());
    EXPECT_TRUE(found[0].kind == BowlFault::Kind::constant && found[0].offsets.empty());
    list = bowls(1);
    list[3].value = list[3 + offsets.size()].value;
    found = data::bowl_faults(list);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].words(), "the sensor at 450 mm reads one value under every load");
}

// One reading that is wrong by chance is no exchange: the others say so.
TEST(BowlFaults, AWrongReadingIsNoExchange) {
    int taken = 0;
    constexpr int trials = 100;
    for (std::uint64_t seed = 0; seed < trials; ++seed) {
        auto list = bowls(seed);
        list[5].value *= 1.6; // under one load
        for (const auto& fault : data::bowl_faults(list)) {
            taken += fault.kind == BowlFault::Kind::exchanged || fault.kind == BowlFault::Kind::reversed;
        }
    }
    EXPECT_LE(taken, 2);
}

// Nor a unit, where what it would read in the other one is far from what its neighbours say.
TEST(BowlFaults, AWrongReadingIsNoUnit) {
    int taken = 0;
    constexpr int trials = 100;
    for (std::uint64_t seed = 0; seed < trials; ++seed) {
        auto list = bowls(seed, 2, 0.05, 10e-6);
        list[offsets.size() - 1].value *= 3.5; // under one load
        for (const auto& fault : data::bowl_faults(list)) {
            taken += fault.kind == BowlFault::Kind::factor;
        }
    }
    EXPECT_LE(taken, 2);
}

TEST(RoundingStep, IsWhatReadingsAreMultiplesOf) {
    std::vector<double> mils;
    std::vector<double> decimals;
    std::vector<double> fives;
    for (const int count : {181, 138, 113, 83, 61, 32, 16, 7, 2}) {
        mils.push_back(std::round(2.54 * count * 1e5) / 1e8); // 0.1 mil in mm
        decimals.push_back(0.001 * count);
        fives.push_back(5.0 * count);
    }
    EXPECT_NEAR(data::rounding_step(mils), 0.00254, 1e-12);
    EXPECT_NEAR(data::rounding_step(decimals), 0.001, 1e-12);
    EXPECT_NEAR(data::rounding_step(fives), 5.0, 1e-12);
    EXPECT_EQ(data::rounding_step({0.1, 0.2, 0.3}), 0.0); // too few
    const pave::RandomStream random(2, 0);
    std::vector<double> fine;
    for (std::uint64_t i = 0; i < 12; ++i) {
        fine.push_back(0.1 + random.uniform(i));
    }
    EXPECT_LT(data::rounding_step(fine), 1e-5);
}
