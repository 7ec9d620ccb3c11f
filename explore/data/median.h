// The middle of some values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace explore::data {

// The middle value; of an even number the mean of the two in the middle. Not of none.
inline double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2.0;
}

} // namespace explore::data
