// The readings of a study: which sensor each is, which group it belongs to, what noise it has. Private to study/.
#pragma once

#include "base/error.h"
#include "study/study.h"
#include "study/table_reader.h"

#include <toml++/toml.h>

namespace explore::study {

template <class T>
std::vector<std::string> names_of(const std::vector<T>& items) {
    std::vector<std::string> names;
    names.reserve(items.size());
    for (const T& item : items) {
        names.push_back(item.name);
    }
    return names;
}

// Throw pave::Error at `place` for a name that there is not.
int find_load(const pave::pavement::Case& model, const std::string& name, const pave::Place& place);
pave::pavement::Quantity find_quantity(const std::string& name, const pave::Place& place);

// When a reading under a load is taken [s]; none: its extreme. Throws pave::Error at `place` for a load without a
// history and for a time out of range.
std::optional<double> time_of(std::optional<double> time_ms, const pave::pavement::Load& load,
                              const pave::Place& place);

// Adds a measured reading and its sensor. Throws pave::Error where it does not fit the model.
void add_measurement(Study& study, data::Reading reading);

// The largest |measured| [SI] of the load and quantity of each measured reading.
std::vector<double> largest_of_group(const Study& study);

// Sorts the measured readings into groups. A name in held_out or weights is that of a group or of a load (all its
// groups). Throws pave::Error for a name that no reading has.
void set_groups(Study& study, const pave::Place& place, const std::vector<std::string>& held_out,
                const toml::table* weights);

// [data.noise]; of_data: the reader of [data]. Throws pave::Error.
void read_noise(const toml::table& table, Study& study, const TableReader& of_data);

// The standard deviation of every measured reading, and how those of a load are tied. Throws pave::Error where errors
// are said to be correlated that no reading states, and for two readings of one place whose errors would be the same.
void set_noise(Study& study);
// Share of each reading that the size of the noise is a factor of, where it is fitted and none is stated.
inline constexpr double unit_of_sought_noise = 0.02;

// Where a sensor reads, for the correlation of its noise.
data::NoisePlace noise_place(const pave::pavement::Sensor& sensor);

// Of a text that fixes the model, with the measurements.
std::string hash_with_readings(std::string text, std::span<const data::Reading> readings);

// Until all sensors are known, the wall stands nowhere: see settle_extent.
inline constexpr double extent_not_stated = 1e9;
// Unless stated, the wall stands where the sensors and the depth want it.
void settle_extent(Study& study);

} // namespace explore::study
