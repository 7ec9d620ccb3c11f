// The minima that searches from random starts have not found: bounds and estimates.
#pragma once

#include <cstddef>
#include <vector>

namespace explore::landscape {

struct Unseen {
    int starts = 0;    // independent and uniform in the box, that ended in a minimum
    int since_new = 0; // of them, after the last that found a minimum not known before
    // Share of the box whose searches end in minima not found: below this at 95 %. (1 - v)^since_new = 0.05, about 3 /
    // m.
    double volume_bound = 1.0;
    // Posterior means of Boender and Rinnooy Kan (1987, Mathematical Programming 37): with w minima found in m
    // starts, the share w (w + 1) / (m (m - 1)), and the number of minima w (m - 1) / (m - w - 2). Not numbers when m
    // is too small for them.
    double volume_mean = 0.0;
    double expected_minima = 0.0;
    // Chao (1984, Scandinavian Journal of Statistics 11), bias-corrected: w + f1 (f1 - 1) / (2 (f2 + 1)), f1 and f2
    // the minima found once and twice: at least so many minima.
    double chao = 0.0;
};

// found[i]: the number of the minimum that independent start i ended in, -1: in none, which says nothing of minima.
// known_before: minima that were
// known when the first of them began are numbered below this.
Unseen unseen(const std::vector<int>& found, int known_before);

} // namespace explore::landscape
