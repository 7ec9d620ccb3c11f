#include "study/corrections.h"

#include "base/units.h"
#include "material/corrected.h"
#include "pavement/effects/effect.h"
#include "study/readings.h"
#include "study/table_reader.h"

#include <algorithm>
#include <cmath>

namespace explore::study {

using namespace pave::pavement;
namespace unit = pave::unit;

void read_correction(const toml::table& table, Study& study) {
    TableReader reader(table, study.file, "[[corrections]]");
    std::vector<std::string> names;
    for (const ChannelInfo& channel : channels()) {
        names.emplace_back(channel.name);
    }
    const ChannelInfo& channel = channels()[reader.choice(keys::correction_channel, names)];
    Correction correction{.channel = channel.channel, .layer = {}, .places = {}, .factors = {}};
    if (channel.of_layer) {
        correction.layer = reader.text(keys::correction_layer);
        const auto layers = names_of(study.model.layers);
        if (std::find(layers.begin(), layers.end(), correction.layer) == layers.end()) {
            throw pave::Error(reader.place(keys::correction_layer), "this layer is not in the study",
                              "\"" + correction.layer + "\"", pave::join(layers));
        }
    }
    reader.rename("correction \"" + correction.name() + "\"");
    const Key& at = channel.of_stress ? keys::correction_at_kPa : keys::correction_at_mm;
    correction.places = reader.numbers(at);
    correction.factors = reader.numbers(keys::correction_factor);
    reader.done();
    if (correction.places.size() != correction.factors.size()) {
        throw pave::Error(reader.place(keys::correction_factor), "every place needs one factor",
                          fmt::format("{} places, {} factors", correction.places.size(), correction.factors.size()),
                          "as many factors as places");
    }
    for (std::size_t i = 0; i + 1 < correction.places.size(); ++i) {
        if (!(correction.places[i] < correction.places[i + 1])) {
            throw pave::Error(reader.place(at), "the places of a correction rise",
                              fmt::format("{}, {}", correction.places[i], correction.places[i + 1]), "rising places");
        }
    }
    if (channel.of_stress && correction.places.size() > pave::material::most_places) {
        throw pave::Error(reader.place(at), "too many places", fmt::format("{}", correction.places.size()),
                          fmt::format("at most {}", pave::material::most_places));
    }
    if (channel.channel == Channel::theta && !(correction.places.front() > 0.0)) {
        throw pave::Error(reader.place(at), "a correction by theta goes by its logarithm",
                          fmt::format("{}", correction.places.front()), "places above 0");
    }
    for (double& place : correction.places) {
        place *= channel.to_si;
    }
    for (const Correction& other : study.model.corrections) {
        if (other.name() == correction.name()) {
            throw pave::Error(reader.place(keys::correction_channel), "this correction is given twice",
                              "\"" + correction.name() + "\"", "each once");
        }
    }
    if (const std::string why = why_impossible(study.model, correction); !why.empty()) {
        throw pave::Error(reader.place(""), "the study cannot have this correction: " + why, {},
                          "another channel or layer");
    }
    study.model.corrections.push_back(std::move(correction));
}

namespace {

// From the top of a layer to its bottom evenly; in a thick one ever farther apart, and as at the last place below it.
std::vector<double> depths(double thickness) {
    constexpr double thin = 0.06;
    constexpr double thick = 0.45;
    if (thickness < thin) {
        return {};
    }
    if (thickness < thick) {
        return {0.0, thickness / 4.0, thickness / 2.0, 3.0 * thickness / 4.0, thickness};
    }
    std::vector<double> places{0.0};
    for (const double place : {0.1, 0.2, 0.3, 0.45, 0.7, 1.2}) {
        if (1.2 * place < thickness) {
            places.push_back(place);
        }
    }
    return places;
}

// Where the readings of a kind are: at most five of their places, spread over them.
std::vector<double> spread(std::vector<double> places) {
    std::sort(places.begin(), places.end());
    constexpr double same = 0.01;
    places.erase(std::unique(places.begin(), places.end(), [](double a, double b) { return b - a < same; }),
                 places.end());
    constexpr std::size_t most = 5;
    if (places.size() <= most) {
        return places;
    }
    std::vector<double> taken;
    for (std::size_t i = 0; i < most; ++i) {
        taken.push_back(places[i * (places.size() - 1) / (most - 1)]);
    }
    return taken;
}

} // namespace

std::vector<Correction> correction_channels(const Study& study) {
    std::vector<Correction> list;
    if (study.has_own_model) { // what it says at which place is not known
        return list;
    }
    const auto add = [&](Channel channel, const std::string& layer, std::vector<double> places) {
        constexpr std::size_t least = 3; // less is a factor, or an effect of the catalogue
        Correction correction{.channel = channel, .layer = layer, .places = std::move(places), .factors = {}};
        correction.factors.assign(correction.places.size(), 1.0);
        const auto same = [&](const Correction& other) { return other.name() == correction.name(); };
        const auto& stated = study.model.corrections;
        if (correction.places.size() >= least && why_impossible(study.model, correction).empty() &&
            std::none_of(stated.begin(), stated.end(), same)) {
            list.push_back(std::move(correction));
        }
    };
    for (const Layer& layer : study.model.layers) {
        add(Channel::depth, layer.name, depths(layer.thickness));
        add(Channel::distance, layer.name, {0.0, 0.15, 0.3, 0.6, 1.2});
        const bool is_asphalt = layer_of_role(study.model, LayerRole::asphalt) == &layer - study.model.layers.data();
        if (!is_asphalt) {
            add(Channel::theta, layer.name, {20e3, 60e3, 180e3, 540e3});
            add(Channel::tau, layer.name, {0.0, 15e3, 45e3, 135e3});
        }
    }
    std::vector<double> offsets;
    std::vector<double> levels;
    for (const Group& group : study.groups) {
        if (group.held_out) {
            continue;
        }
        for (const std::size_t row : group.rows) {
            const Sensor& sensor = study.model.sensors[row];
            if (sensor.quantity == Quantity::deflection) {
                offsets.push_back(std::hypot(sensor.x, sensor.y));
            } else {
                levels.push_back(sensor.depth);
            }
        }
    }
    add(Channel::offset, "", spread(std::move(offsets)));
    add(Channel::level, "", spread(std::move(levels)));
    return list;
}

Study with_free_corrections(Study study, const std::vector<Correction>& corrections) {
    constexpr double reach = 20.0;
    for (const Correction& correction : corrections) {
        study.model.corrections.push_back(correction);
        study.model.corrections.back().present = true;
        for (std::size_t i = 0; i < correction.factors.size(); ++i) {
            study.space.axes.push_back({.name = fmt::format("{}.factor_{}", correction.name(), i + 1),
                                        .low = 1.0 / reach,
                                        .high = reach,
                                        .scale = problem::Scale::log,
                                        .start = correction.factors[i]});
            study.parameters.push_back(find_parameter(study.model, study.space.axes.back().name, {.file = study.file}));
        }
        study.hash += fmt::format("+{}", correction.name());
    }
    return study;
}

std::string correction_text(const Correction& correction, std::optional<double> strength,
                            double neighbour_correlation) {
    const ChannelInfo& channel = info(correction.channel);
    std::vector<std::string> places;
    std::vector<std::string> factors;
    for (std::size_t i = 0; i < correction.places.size(); ++i) {
        places.push_back(fmt::format("{:.6g}", correction.places[i] / channel.to_si));
        factors.push_back(fmt::format("{}", correction.factors[i]));
    }
    std::string text = fmt::format("\n[[corrections]]\nchannel = \"{}\"\n", channel.name);
    if (channel.of_layer) {
        std::ostringstream name;
        name << toml::value<std::string>(correction.layer);
        text += fmt::format("layer = {}\n", name.str());
    }
    text += fmt::format("at_{} = [{}]\nfactor = [{}]\n", channel.unit, pave::join(places), pave::join(factors));
    if (!strength) {
        return text;
    }
    const std::size_t count = correction.factors.size();
    const auto factor_name = [&](std::size_t i) {
        std::ostringstream name;
        name << toml::value<std::string>(fmt::format("{}.factor_{}", correction.name(), i + 1));
        return name.str();
    };
    for (std::size_t i = 0; i < count; ++i) {
        text += fmt::format("\n[[parameters]]\nname = {}\nmin = 0.05\nmax = 20\nscale = \"log\"\n"
                            "prior = {{ mean = 1, sd = {} }}\n",
                            factor_name(i), *strength);
    }
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = i + 1; j < count; ++j) {
            text += fmt::format("\n[[prior_correlations]]\nbetween = [{}, {}]\nvalue = {}\n", factor_name(i),
                                factor_name(j), std::pow(neighbour_correlation, static_cast<double>(j - i)));
        }
    }
    return text;
}

} // namespace explore::study
