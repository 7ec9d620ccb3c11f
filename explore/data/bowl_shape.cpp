#include "data/bowl_shape.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace explore::data {

std::vector<Bowl> bowls_of(const std::vector<BowlPoint>& readings) {
    std::map<int, Bowl> by_load;
    for (const BowlPoint& reading : readings) {
        by_load[reading.load].push_back(reading);
    }
    std::vector<Bowl> bowls;
    for (auto& [load, bowl] : by_load) {
        std::stable_sort(bowl.begin(), bowl.end(),
                         [](const BowlPoint& a, const BowlPoint& b) { return a.offset < b.offset; });
        bowls.push_back(std::move(bowl));
    }
    return bowls;
}

double largest(const Bowl& bowl) {
    double most = 0.0;
    for (const BowlPoint& reading : bowl) {
        most = std::max(most, std::abs(reading.value));
    }
    return most;
}

std::vector<double> offsets_of(const std::vector<Bowl>& bowls) {
    std::vector<double> offsets;
    for (const Bowl& bowl : bowls) {
        for (const BowlPoint& reading : bowl) {
            offsets.push_back(reading.offset);
        }
    }
    std::sort(offsets.begin(), offsets.end());
    constexpr double same = 1e-4; // m
    offsets.erase(std::unique(offsets.begin(), offsets.end(), [](double a, double b) { return b - a < same; }),
                  offsets.end());
    return offsets;
}

namespace {

// Whether the second, farther one reads clearly more.
bool rises(const BowlPoint& near, const BowlPoint& far, double of_bowl) {
    constexpr double deviations = 4.0;
    constexpr double share = 0.1;
    constexpr double of_largest = 0.02;
    const double rise = far.value - near.value;
    return far.offset > near.offset && rise > deviations * std::hypot(near.deviation, far.deviation) &&
           rise > share * std::max(std::abs(near.value), std::abs(far.value)) && rise > of_largest * of_bowl;
}

} // namespace

std::optional<std::pair<std::size_t, std::size_t>> first_rise(const Bowl& bowl) {
    const double most = largest(bowl);
    for (std::size_t i = 0; i < bowl.size(); ++i) {
        for (std::size_t j = i + 1; j < bowl.size(); ++j) {
            if (rises(bowl[i], bowl[j], most)) {
                return std::pair(i, j);
            }
        }
    }
    return std::nullopt;
}

bool rise_together(const std::vector<Bowl>& bowls, double near, double far) {
    constexpr double deviations = 4.0;
    constexpr double share = 0.1;
    double sum = 0.0; // of rises in standard deviations (Stouffer's test)
    double count = 0.0;
    bool is_clear = true;
    for (const Bowl& bowl : bowls) {
        const BowlPoint* a = at(bowl, near);
        const BowlPoint* b = at(bowl, far);
        if (a != nullptr && b != nullptr && a->deviation > 0.0 && b->deviation > 0.0) {
            sum += (b->value - a->value) / std::hypot(a->deviation, b->deviation);
            count += 1.0;
            is_clear = is_clear && b->value - a->value > share * std::abs(b->value);
        }
    }
    return count > 1.0 && is_clear && sum > deviations * std::sqrt(count);
}

bool all_fall(const std::vector<Bowl>& bowls) {
    const std::vector<double> offsets = offsets_of(bowls);
    for (std::size_t i = 0; i + 1 < offsets.size(); ++i) {
        if (rise_together(bowls, offsets[i], offsets[i + 1])) {
            return false;
        }
    }
    return std::none_of(bowls.begin(), bowls.end(), [](const Bowl& bowl) { return first_rise(bowl).has_value(); });
}

double stretched(const BowlPoint& reading) {
    return std::sqrt(0.04 + reading.offset * reading.offset);
}

double roughness(const std::vector<Bowl>& bowls) {
    double sum = 0.0;
    double count = 0.0;
    for (const Bowl& bowl : bowls) {
        const double least = 1e-3 * largest(bowl);
        for (std::size_t i = 1; i + 1 < bowl.size(); ++i) {
            const auto x = [&](std::size_t k) { return stretched(bowl[k]); };
            const auto y = [&](std::size_t k) { return std::log(std::max(bowl[k].value, least)); };
            if (x(i) - x(i - 1) < 1e-6 || x(i + 1) - x(i) < 1e-6) {
                continue;
            }
            const double bend = (y(i + 1) - y(i)) / (x(i + 1) - x(i)) - (y(i) - y(i - 1)) / (x(i) - x(i - 1));
            sum += bend * bend;
            count += 1.0;
        }
    }
    return sum / std::max(1.0, count);
}

} // namespace explore::data
