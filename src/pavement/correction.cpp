#include "pavement/correction.h"

#include "base/units.h"
#include "material/catalog.h"
#include "material/corrected.h"
#include "pavement/buried.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>

namespace pave::pavement {

std::span<const ChannelInfo> channels() {
    static const ChannelInfo all[] = {
        {.channel = Channel::depth,
         .name = "depth",
         .to_si = unit::mm,
         .unit = "mm",
         .meaning = "below the top of the layer"},
        {.channel = Channel::distance,
         .name = "distance",
         .to_si = unit::mm,
         .unit = "mm",
         .meaning = "from the axis of the nearest patch of the load"},
        {.channel = Channel::theta,
         .name = "theta",
         .of_stress = true,
         .to_si = unit::kPa,
         .unit = "kPa",
         .meaning = "sum of the principal stresses"},
        {.channel = Channel::tau,
         .name = "tau",
         .of_stress = true,
         .to_si = unit::kPa,
         .unit = "kPa",
         .meaning = "octahedral shear stress"},
        {.channel = Channel::offset,
         .name = "offset",
         .of_layer = false,
         .to_si = unit::mm,
         .unit = "mm",
         .meaning = "of deflection sensors from the middle of the load"},
        {.channel = Channel::level,
         .name = "level",
         .of_layer = false,
         .to_si = unit::mm,
         .unit = "mm",
         .meaning = "depth of gauges"},
    };
    return all;
}

const ChannelInfo& info(Channel channel) {
    return channels()[static_cast<std::size_t>(channel)];
}

std::string Correction::name() const {
    return (info(channel).of_layer ? layer : "readings") + "-" + std::string(info(channel).name);
}

bool is_active(const Correction& correction) {
    return correction.present || std::any_of(correction.factors.begin(), correction.factors.end(),
                                             [](double factor) { return factor != 1.0; });
}

namespace {

// 1 at a place, 0 at its neighbours, straight between; endless: none on that side. shape: place, distances to the
// neighbours before and after.
double hat(const fe::Field::Shape& shape, double at) {
    const double away = at - shape[0];
    return std::max(0.0, 1.0 - (away < 0.0 ? -away / shape[1] : away / shape[2]));
}

double hat_of_depth(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return hat(shape, at[2]);
}

// shape: as above, then x of the patch at x >= 0.
double hat_of_distance(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return hat(shape, std::hypot(std::abs(at[0]) - shape[3], at[1]));
}

// The shape of hat number i.
fe::Field::Shape shape_of(const std::vector<double>& places, std::size_t i) {
    return {places[i], i > 0 ? places[i] - places[i - 1] : INFINITY,
            i + 1 < places.size() ? places[i + 1] - places[i] : INFINITY, 0.0};
}

void add_fields(Case& c, const Correction& correction, int load) {
    const auto layers = layers_named(c, correction.layer);
    const bool is_depth = correction.channel == Channel::depth;
    const double top = top_of(c, layers.front());
    for (std::size_t i = 0; i < correction.places.size(); ++i) {
        fe::Field field{.parameter = {},
                        .is_power = true,
                        .size = std::log(correction.factors[i]),
                        .weight = is_depth ? hat_of_depth : hat_of_distance,
                        .shape = shape_of(correction.places, i)};
        if (is_depth) {
            field.shape[0] += top;
        } else {
            field.shape[3] = c.loads[static_cast<std::size_t>(load)].footprint().centre;
        }
        for (const std::size_t l : layers) {
            c.layers[l].fields.push_back(field);
        }
    }
}

void correct_law(Case& c, const Correction& correction) {
    const bool of_shear = correction.channel == Channel::tau;
    for (const std::size_t l : layers_named(c, correction.layer)) {
        Layer& layer = c.layers[l];
        const material::Law& law = *material::find_law(layer.law->name());
        if (layer.law == &law) { // not corrected yet
            layer.law = &material::corrected(law);
            for (std::size_t i = layer.parameters.size(); i < layer.law->parameters().size(); ++i) {
                layer.parameters.push_back(*layer.law->parameters()[i].default_value);
            }
        }
        for (std::size_t i = 0; i < correction.places.size(); ++i) {
            layer.parameters[material::place_index(law, of_shear, i)] = correction.places[i];
            layer.parameters[material::value_index(law, of_shear, i)] = std::log(correction.factors[i]);
        }
    }
}

void correct_readings(Case& c, const Correction& correction) {
    for (Sensor& sensor : c.sensors) {
        const bool is_on_surface = !is_buried(sensor);
        if (!sensor.measured || is_on_surface != (correction.channel == Channel::offset)) {
            continue;
        }
        const double at = is_on_surface ? std::hypot(sensor.x, sensor.y) : sensor.depth;
        double g = 0.0;
        for (std::size_t i = 0; i < correction.places.size(); ++i) {
            g += hat(shape_of(correction.places, i), at) * std::log(correction.factors[i]);
        }
        sensor.gain *= std::exp(g);
    }
}

} // namespace

void apply(Case& c, const Correction& correction, int load) {
    if (info(correction.channel).of_stress) {
        correct_law(c, correction);
    } else if (info(correction.channel).of_layer) {
        add_fields(c, correction, load);
    } else {
        correct_readings(c, correction);
    }
}

std::string why_impossible(const Case& c, const Correction& correction) {
    const ChannelInfo& channel = info(correction.channel);
    if (!channel.of_layer) {
        const auto is_read = [&](const Sensor& sensor) {
            return sensor.measured && !is_buried(sensor) == (correction.channel == Channel::offset);
        };
        return std::any_of(c.sensors.begin(), c.sensors.end(), is_read) ? "" : "no reading of that kind";
    }
    const auto layers = layers_named(c, correction.layer);
    if (layers.empty()) {
        return "the section has no such layer";
    }
    if (channel.of_stress && c.layers[layers.front()].law->relaxes()) {
        return "the layer relaxes";
    }
    if (channel.of_stress && c.layers[layers.front()].law->energy() != nullptr) {
        return "the strain of the layer derives from an energy, which leaves no room for a factor on its modulus";
    }
    const bool on_gear =
        std::any_of(c.loads.begin(), c.loads.end(), [](const Load& l) { return l.type == LoadType::gear; });
    return on_gear ? "a gear stands on uncorrected linear layers only" : "";
}

} // namespace pave::pavement
