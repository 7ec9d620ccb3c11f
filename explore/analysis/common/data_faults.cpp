#include "analysis/common/data_faults.h"

#include "base/text.h"
#include "data/median.h"
#include "data/rounding.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace explore::analysis {

using data::BowlFault;
using data::BowlPoint;
using pave::pavement::Quantity;

namespace {

bool is_of_bowl(const study::Study& study, std::size_t row) {
    const auto& sensor = study.model.sensors[row];
    return study.readings[row].censored == data::Censored::no && sensor.quantity == Quantity::deflection &&
           sensor.depth == 0.0 && study.model.loads[static_cast<std::size_t>(sensor.load)].is_axisymmetric();
}

// The readings of one sensor under one load, at whatever time.
std::vector<std::size_t> rows_beside(const study::Study& study, std::size_t row) {
    const data::Reading& own = study.readings[row];
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < study.measured().size(); ++i) {
        const data::Reading& other = study.readings[i];
        if (other.load == own.load && other.quantity == own.quantity && other.place_words() == own.place_words()) {
            rows.push_back(i);
        }
    }
    return rows;
}

// The readings of some sensors take the places of others.
void move_sensors(study::Study& study, const std::vector<std::pair<std::size_t, std::size_t>>& moves) {
    const study::Study before = study;
    for (const auto& [from, to] : moves) {
        for (const std::size_t row : rows_beside(before, from)) {
            study.readings[row].x_mm = before.readings[to].x_mm;
            study.readings[row].y_mm = before.readings[to].y_mm;
            study.readings[row].depth_mm = before.readings[to].depth_mm;
            study.model.sensors[row].x = before.model.sensors[to].x;
            study.model.sensors[row].y = before.model.sensors[to].y;
            study.model.sensors[row].depth = before.model.sensors[to].depth;
        }
    }
}

// The errors of these readings may have been stated in the unit that was meant, or in that of the file: as they are
// elsewhere, relative to the values: of the same sensors under other loads or, where there are none, of all others.
bool are_errors_of_file(const study::Study& study, const std::vector<std::size_t>& rows, double factor) {
    const auto share = [&](std::size_t row) {
        const data::Reading& reading = study.readings[row];
        return std::log(reading.noise.absolute / std::abs(reading.measured()));
    };
    const auto states = [&](std::size_t row) {
        const data::Reading& reading = study.readings[row];
        return reading.noise.absolute > 0.0 && reading.measured() != 0.0;
    };
    double by_file = 0.0;
    double by_meant = 0.0;
    for (const std::size_t row : rows) {
        std::vector<double> same_place;
        std::vector<double> all;
        for (std::size_t i = 0; states(row) && i < study.measured().size(); ++i) {
            if (is_of_bowl(study, i) && states(i) && std::find(rows.begin(), rows.end(), i) == rows.end()) {
                all.push_back(share(i));
                if (study.readings[i].place_words() == study.readings[row].place_words()) {
                    same_place.push_back(share(i));
                }
            }
        }
        if (!all.empty()) {
            const double elsewhere = data::median(same_place.empty() ? std::move(all) : std::move(same_place));
            by_file += std::abs(share(row) - elsewhere);
            by_meant += std::abs(share(row) + std::log(factor) - elsewhere);
        }
    }
    return by_file < by_meant;
}

void rescale(study::Study& study, const std::vector<std::size_t>& rows, double factor) {
    const bool with_errors = are_errors_of_file(study, rows, factor);
    for (const std::size_t row : rows) {
        data::Reading& own = study.readings[row];
        own.value /= factor;
        if (with_errors) {
            own.noise.absolute /= factor;
            if (own.sigma) {
                *own.sigma /= factor;
            }
        }
    }
}

} // namespace

std::vector<BowlFault> data_faults(const study::Study& study) {
    std::map<std::pair<int, std::string>, BowlPoint> peaks;
    for (std::size_t i = 0; i < study.measured().size(); ++i) {
        if (!is_of_bowl(study, i)) {
            continue;
        }
        const data::Reading& reading = study.readings[i];
        const auto& sensor = study.model.sensors[i];
        const auto& load = study.model.loads[static_cast<std::size_t>(sensor.load)];
        const BowlPoint own{.row = i,
                            .load = sensor.load,
                            .offset = std::hypot(sensor.x, sensor.y),
                            .value = reading.measured(),
                            .deviation = reading.noise.deviation(reading.measured()),
                            .strength = load.pressure * load.radius};
        const auto [at, is_new] = peaks.try_emplace({sensor.load, reading.place_words()}, own);
        if (!is_new && own.value > at->second.value) {
            at->second = own;
        }
    }
    std::vector<BowlPoint> readings;
    readings.reserve(peaks.size());
    for (const auto& [place, reading] : peaks) {
        readings.push_back(reading);
    }
    return data::bowl_faults(readings);
}

study::Study mended(study::Study study, const std::vector<BowlFault>& faults) {
    for (const BowlFault& fault : faults) {
        if (!fault.is_mendable()) {
            continue;
        }
        study.hash += " with " + fault.words();
        std::vector<std::pair<std::size_t, std::size_t>> moves;
        std::vector<std::size_t> rows;
        switch (fault.kind) {
        case BowlFault::Kind::exchanged:
            for (std::size_t i = 0; i + 1 < fault.rows.size(); i += 2) {
                moves.emplace_back(fault.rows[i], fault.rows[i + 1]);
                moves.emplace_back(fault.rows[i + 1], fault.rows[i]);
            }
            break;
        case BowlFault::Kind::reversed:
            for (std::size_t i = 0; i < fault.rows.size();) {
                std::size_t end = i + 1; // of its load
                while (end < fault.rows.size() &&
                       study.readings[fault.rows[end]].load == study.readings[fault.rows[i]].load) {
                    ++end;
                }
                for (std::size_t k = i; k < end; ++k) {
                    moves.emplace_back(fault.rows[k], fault.rows[i + end - 1 - k]);
                }
                i = end;
            }
            break;
        case BowlFault::Kind::factor:
            for (const std::size_t row : fault.rows) {
                const std::vector<std::size_t> own = rows_beside(study, row);
                rows.insert(rows.end(), own.begin(), own.end());
            }
            rescale(study, rows, fault.factor);
            break;
        case BowlFault::Kind::rises:
        case BowlFault::Kind::constant: break;
        }
        move_sensors(study, moves);
    }
    return study;
}

std::vector<Rounding> roundings(const study::Study& study) {
    std::map<std::pair<Quantity, std::string_view>, std::vector<std::size_t>> alike; // and of one unit
    for (std::size_t i = 0; i < study.measured().size(); ++i) {
        alike[{study.model.sensors[i].quantity, study.readings[i].unit.name}].push_back(i);
    }
    std::vector<Rounding> list;
    for (const auto& [what, rows] : alike) {
        std::vector<double> values;
        for (const std::size_t row : rows) {
            values.push_back(study.readings[row].value);
        }
        const double step = data::rounding_step(values) * study.readings[rows[0]].unit.to_si;
        // A noise of less than two steps' rounding may not have thought of it.
        const bool matters = std::any_of(rows.begin(), rows.end(), [&](std::size_t row) {
            const data::Reading& own = study.readings[row];
            return own.noise.is_stated() && own.noise.deviation(own.measured()) < step / std::sqrt(3.0);
        });
        if (step > 0.0 && matters) {
            list.push_back({what.first, step});
        }
    }
    return list;
}

study::Study with_rounding(study::Study study, const std::vector<Rounding>& roundings) {
    for (const Rounding& rounding : roundings) {
        study.hash += " with " + rounding.words();
        for (std::size_t i = 0; i < study.measured().size(); ++i) {
            data::Noise& noise = study.readings[i].noise;
            if (study.model.sensors[i].quantity == rounding.quantity && noise.is_stated()) {
                noise.absolute = std::hypot(noise.absolute, rounding.step / std::sqrt(12.0));
            }
        }
    }
    return study;
}

std::string Rounding::words() const {
    const auto& about = info(quantity);
    return fmt::format("readings of {} stand in steps of {} {}, whose rounding the stated noise does not hold: "
                       "step^2/12 is added to its variance",
                       about.name, pave::figure(step / about.to_si), about.unit);
}

std::optional<DoubtfulNoise> doubtful_noise(const study::Study& study) {
    constexpr double finest = 1e-4; // of a reading; geophones and strain gauges repeat to some 5e-3
    DoubtfulNoise found;
    for (std::size_t i = 0; i < study.measured().size(); ++i) {
        const data::Reading& own = study.readings[i];
        if (own.sigma && *own.sigma < finest * std::abs(own.value)) {
            found.rows.push_back(i);
        }
    }
    if (found.rows.empty()) {
        return std::nullopt;
    }
    const data::Reading& first = study.readings[found.rows[0]];
    found.words = fmt::format("{}: sigma = {} {} of {} {}, less than 0.01 % of it, which no instrument reaches; sigma "
                              "is in the unit of the value{}",
                              first.words(), pave::figure(*first.sigma), first.unit.name, pave::figure(first.value),
                              first.unit.name,
                              found.rows.size() > 1 ? fmt::format(" ({} readings are so)", found.rows.size()) : "");
    return found;
}

std::vector<std::string> fault_words(const study::Study& study) {
    std::vector<std::string> words;
    for (const BowlFault& fault : data_faults(study)) {
        words.push_back(fault.words());
    }
    if (auto doubtful = doubtful_noise(study)) {
        words.push_back(std::move(doubtful->words));
    }
    return words;
}

} // namespace explore::analysis
