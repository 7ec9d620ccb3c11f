#include "analysis/diagnose/located.h"

#include "base/text.h"
#include "base/units.h"
#include "inference/quantiles.h"
#include "pavement/effects/effect.h"
#include "pavement/fields.h"
#include "pavement/forward.h"
#include "study/pavement_function.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

using pave::pavement::Case;
using pave::pavement::Channel;
using pave::pavement::Correction;
using pave::pavement::Fields;
using pave::pavement::Layer;

std::vector<std::size_t> channels_of(const std::vector<diagnose::Channel>& channels, const diagnose::Members& members) {
    std::vector<std::size_t> list;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        if (std::binary_search(members.begin(), members.end(), channels[c].first)) {
            list.push_back(c);
        }
    }
    return list;
}

namespace {

// The stress that acts at a place of a channel in a layer: at the node of the load's mesh that is nearest to it.
pave::mechanics::Invariants state_at(const Case& c, const Fields& fields, int load, const Correction& correction,
                                     double place) {
    const auto layers = layers_named(c, correction.layer);
    const double top = top_of(c, layers.front());
    const double middle = top + c.layers[layers.front()].thickness / 2.0;
    const double axis = c.loads[static_cast<std::size_t>(load)].footprint().centre;
    pave::mechanics::Invariants nearest;
    double least = INFINITY;
    for (Eigen::Index n = 0; n < fields.position.cols(); ++n) {
        const auto own = static_cast<std::size_t>(fields.layer[static_cast<std::size_t>(n / fields.nodes)]);
        if (std::find(layers.begin(), layers.end(), own) == layers.end()) {
            continue;
        }
        const double aside = std::hypot(fields.position(0, n) - axis, fields.position(1, n));
        double away = 0.0;
        switch (correction.channel) {
        case Channel::depth: away = std::hypot(fields.position(2, n) - top - place, aside); break;
        case Channel::distance: away = std::hypot(fields.position(2, n) - middle, aside - place); break;
        case Channel::theta: away = std::abs(fields.theta[n] - place); break;
        case Channel::tau: away = std::abs(fields.tau[n] - place); break;
        case Channel::offset:
        case Channel::level: break;
        }
        if (away < least) {
            least = away;
            nearest = {.theta = fields.theta[n], .tau = fields.tau[n]};
        }
    }
    if (correction.channel == Channel::theta) {
        nearest.theta = place;
    } else if (correction.channel == Channel::tau) {
        nearest.tau = place;
    }
    return nearest;
}

// slopes: of the logarithms, by what has the covariance.
std::optional<LocatedContrast> clearest_contrast(const std::vector<double>& logarithms,
                                                 const std::vector<Eigen::VectorXd>& slopes,
                                                 const Eigen::MatrixXd& covariance) {
    double most = 3.0; // standard deviations: chance makes one of some twenty pairs differ by two
    std::optional<LocatedContrast> clearest;
    for (std::size_t i = 0; i < logarithms.size(); ++i) {
        for (std::size_t j = 0; j < logarithms.size(); ++j) {
            const double difference = logarithms[i] - logarithms[j];
            const Eigen::VectorXd slope = slopes[i] - slopes[j];
            const double deviation = std::sqrt(slope.dot(covariance * slope));
            if (difference < 0.0 && -difference > most * deviation) {
                most = -difference / deviation;
                clearest = {.place = i,
                            .beside = j,
                            .value = std::exp(difference),
                            .low = std::exp(difference - inference::two_sided_95 * deviation),
                            .high = std::exp(difference + inference::two_sided_95 * deviation)};
            }
        }
    }
    return clearest;
}

double modulus_at(const Layer& layer, pave::mechanics::Invariants state) {
    return layer.law->modulus(layer.parameters, state).value;
}

} // namespace

diagnose::Says LocatedCorrection::says_where() const {
    if (std::any_of(places.begin(), places.end(), [](const LocatedPlace& p) { return p.side() != 0; })) {
        return diagnose::Says::at_places;
    }
    return contrast ? diagnose::Says::between_places : diagnose::Says::nothing;
}

std::vector<LocatedCorrection> located(const study::Study& study, const study::Study& corrected,
                                       const problem::Problem& problem, const diagnose::Diagnosis& d,
                                       const std::vector<diagnose::Channel>& channels,
                                       const std::vector<Correction>& corrections) {
    std::vector<LocatedCorrection> list;
    const diagnose::Location& location = *d.location;
    const diagnose::Model& model = location.fit.model;
    const std::vector<double> values = problem.space.physical(model.unit);
    const auto before = study::case_at(study.model, study.parameters, study.space.physical(d.baseline.model.unit));
    const auto after = study::case_at(corrected.model, corrected.parameters, values);
    if (!before || !after) { // both were computed
        return list;
    }
    const int load = study.model.sensors[study.groups.front().rows.front()].load;
    std::optional<Fields> fields;
    for (std::size_t n = 0; n < location.corrections.size(); ++n) {
        const auto& found = location.corrections[n];
        LocatedCorrection own{.correction = corrections[found.channel], .strength = found.strength, .places = {}};
        const auto& channel = info(own.correction.channel);
        const auto first = std::lower_bound(model.members.begin(), model.members.end(), channels[found.channel].first) -
                           model.members.begin() + static_cast<std::ptrdiff_t>(study.space.axes.size());
        if (channel.of_layer && !fields) {
            const auto outcome = pave::pavement::ForwardModel(corrected.model).fields(*after, load);
            if (!outcome) {
                return list;
            }
            fields = *outcome;
        }
        std::vector<double> logarithms;
        std::vector<Eigen::VectorXd> slopes;
        for (std::size_t i = 0; i < own.correction.places.size(); ++i) {
            const auto k = static_cast<std::size_t>(first) + i;
            own.correction.factors[i] = values[k];
            double value = std::log(values[k]);
            Eigen::VectorXd slope = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.unit.size()));
            slope[static_cast<Eigen::Index>(k)] = problem.space.axes[k].d_physical(model.unit[k]) / values[k];
            LocatedPlace place{.at = own.correction.places[i] / channel.to_si};
            if (channel.of_layer) {
                const auto state = state_at(*after, *fields, load, own.correction, own.correction.places[i]);
                const std::size_t l = layers_named(*after, own.correction.layer).front();
                const Layer& layer = after->layers[l];
                const auto modulus = layer.law->modulus(layer.parameters, state);
                value += std::log(modulus.value / modulus_at(before->layers[l], state));
                place.modulus = modulus.value * values[k];
                for (std::size_t p = 0; p < study.parameters.size(); ++p) {
                    const auto& parameter = study.parameters[p];
                    const bool is_its_law = parameter.law_index && !parameter.in_load && !parameter.in_effect &&
                                            parameter.owner == static_cast<int>(l);
                    if (is_its_law) {
                        slope[static_cast<Eigen::Index>(p)] =
                            layer.law->modulus_derivative(layer.parameters, state, modulus, *parameter.law_index) /
                            modulus.value * parameter.to_si * problem.space.axes[p].d_physical(model.unit[p]);
                    }
                }
            }
            const double variance = slope.dot(location.covariance * slope);
            place.value = std::exp(value);
            place.low = std::exp(value - inference::two_sided_95 * std::sqrt(variance));
            place.high = std::exp(value + inference::two_sided_95 * std::sqrt(variance));
            place.variance_left = variance / (found.strength * found.strength);
            own.places.push_back(place);
            logarithms.push_back(value);
            slopes.push_back(std::move(slope));
        }
        own.contrast = clearest_contrast(logarithms, slopes, location.covariance);
        list.push_back(std::move(own));
    }
    return list;
}

namespace {

// "between 200 and 400 mm", "around 200 mm", "beyond 600 mm": places from first to last.
std::string range_words(const LocatedCorrection& found, std::size_t first, std::size_t last) {
    const std::string unit(info(found.correction.channel).unit);
    const auto at = [&](std::size_t i) { return pave::figure(found.places[i].at, 3); };
    if (first == last) {
        return fmt::format("around {} {}", at(first), unit);
    }
    return fmt::format("between {} and {} {}", at(first), at(last), unit);
}

std::string variable_words(const Correction& correction) {
    switch (correction.channel) {
    case Channel::depth: return " below its top";
    case Channel::distance: return " beside the load";
    case Channel::theta: return " of theta";
    case Channel::tau: return " of octahedral shear";
    case Channel::offset: return " from the load";
    case Channel::level: return " depth";
    }
    return "";
}

std::string share(double factor) {
    return pave::figure(100.0 * factor, 2);
}

} // namespace

std::string channel_words(const Correction& correction) {
    const auto& channel = info(correction.channel);
    if (channel.of_layer) {
        return fmt::format("{}, by {}", correction.layer, channel.name);
    }
    return correction.channel == Channel::offset ? "deflections, by offset" : "gauges, by depth";
}

std::vector<std::string> words_of(const LocatedCorrection& found) {
    const std::string what = info(found.correction.channel).of_layer       ? "the " + found.correction.layer
                             : found.correction.channel == Channel::offset ? "the deflectometer"
                                                                           : "the gauges";
    const bool of_layer = info(found.correction.channel).of_layer;
    std::vector<std::string> text;
    const auto& places = found.places;
    for (std::size_t i = 0; i < places.size();) {
        std::size_t end = i + 1;
        while (end < places.size() && places[end].side() == places[i].side()) {
            ++end;
        }
        if (places[i].side() != 0) {
            const auto first = places.begin() + static_cast<std::ptrdiff_t>(i);
            const auto last = places.begin() + static_cast<std::ptrdiff_t>(end);
            const double low =
                std::min_element(first, last, [](const auto& a, const auto& b) { return a.low < b.low; })->low;
            const double high =
                std::max_element(first, last, [](const auto& a, const auto& b) { return a.high < b.high; })->high;
            std::string sentence =
                fmt::format("{}{} {} {} {} to {} % of {}.", range_words(found, i, end - 1),
                            variable_words(found.correction), what, of_layer ? "has" : "read", share(low), share(high),
                            of_layer ? "the modulus of the study's model" : "what there is");
            sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
            text.push_back(std::move(sentence));
        }
        i = end;
    }
    if (text.empty() && found.contrast) {
        const auto& [place, beside, value, low, high] = *found.contrast;
        text.push_back(
            fmt::format("Beside the study's model {} {} {}{} {} to {} % of {} {}; which of the two is off is "
                        "not known.",
                        what, of_layer ? "has" : "read", range_words(found, place, place),
                        variable_words(found.correction), share(low), share(high),
                        of_layer ? "the modulus that it has" : "what they do", range_words(found, beside, beside)));
    }
    const auto is_dark = [&](std::size_t i) { return !places[i].seen() && places[i].side() == 0; };
    std::vector<std::string> unseen;
    for (std::size_t i = 0; i < places.size();) {
        std::size_t end = i + 1;
        while (end < places.size() && is_dark(end) == is_dark(i)) {
            ++end;
        }
        if (is_dark(i)) {
            const std::string unit(info(found.correction.channel).unit);
            unseen.push_back(end == places.size() && i > 0
                                 ? fmt::format("from {} {} on", pave::figure(places[i].at, 3), unit)
                                 : range_words(found, i, end - 1));
        }
        i = end;
    }
    if (!unseen.empty()) {
        text.push_back(fmt::format("These readings hardly constrain it {}.", pave::join(unseen, " and ")));
    }
    return text;
}

} // namespace explore::analysis
