#include "landscape/unseen.h"

#include <cmath>
#include <limits>
#include <map>

namespace explore::landscape {

Unseen unseen(const std::vector<int>& found, int known_before) {
    Unseen u;
    std::map<int, int> times;
    for (const int minimum : found) {
        if (minimum < 0) {
            continue;
        }
        ++u.starts;
        ++u.since_new;
        if (++times[minimum] == 1 && minimum >= known_before) {
            u.since_new = 0;
        }
    }
    constexpr double doubt = 0.05;
    u.volume_bound = u.since_new > 0 ? 1.0 - std::pow(doubt, 1.0 / u.since_new) : 1.0;
    const double w = static_cast<double>(times.size());
    const double m = u.starts;
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    u.volume_mean = m > 1.0 ? std::fmin(1.0, w * (w + 1.0) / (m * (m - 1.0))) : nothing;
    u.expected_minima = m > w + 2.0 ? w * (m - 1.0) / (m - w - 2.0) : nothing;
    double once = 0.0;
    double twice = 0.0;
    for (const auto& [minimum, count] : times) {
        once += count == 1 ? 1.0 : 0.0;
        twice += count == 2 ? 1.0 : 0.0;
    }
    u.chao = w + once * (once - 1.0) / (2.0 * (twice + 1.0));
    return u;
}

} // namespace explore::landscape
