// Faults of deflection bowls that need no model to be seen: a bowl falls with the distance from the load, and a sensor
// reads under one load about the same share more than under another as its neighbours do.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace explore::data {

// The reading of one sensor under one load.
struct BowlPoint {
    std::size_t row = 0; // whoever asks: which of his readings
    int load = 0;
    double offset = 0.0;    // m, from the load
    double value = 0.0;     // m
    double deviation = 0.0; // standard deviation of its error; 0: not stated
    double strength = 0.0;  // of the load: its pressure times its radius [N/m]; 0: not known
};

struct BowlFault {
    enum class Kind {
        rises,     // somewhere with distance, by nothing below
        exchanged, // two sensors are
        reversed,  // the sensors are counted from the far end
        factor,    // one sensor, one reading, or all of one load, is in another unit
        constant   // one value for all, of a load or of a sensor
    };
    Kind kind = Kind::rises;
    // Readings: those exchanged (pairs, one after the other), reversed (of each load, from near to far), in another
    // unit, alike, or where it rises.
    std::vector<std::size_t> rows;
    std::vector<double> offsets;       // m, of the sensors that it names
    std::vector<std::string> places{}; // of the instruments in its stead: of an exchange that the model shows
    double factor = 1.0;               // by which what stands there is too large
    bool of_one_load = false;          // of several
    bool is_by_model() const { return !places.empty(); }
    bool is_mendable() const { return kind != Kind::rises && kind != Kind::constant; }

    std::string words() const;
};

// Readings of sensors on one line under circles of pressure at its beginning, of any number of loads. A rise counts
// where it is four standard deviations, of one load or of several together, a tenth of the reading and a fiftieth of
// the largest; a fault is named where mending it makes every bowl fall, and nothing else does as smoothly.
std::vector<BowlFault> bowl_faults(const std::vector<BowlPoint>& readings);

} // namespace explore::data
