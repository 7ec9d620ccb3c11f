// Corrections of a model where it is wrong without saying why: a smooth factor on the modulus of a layer, or on
// readings, of one variable.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pave::pavement {

struct Case;

// depth: below the top of the layer. distance: horizontal, to the axis of the nearest patch of the load. theta, tau: of
// the total stress. offset: of a deflection sensor from the middle of the load. level: depth of any other sensor.
enum class Channel { depth, distance, theta, tau, offset, level };

struct ChannelInfo {
    Channel channel;
    std::string_view name;
    bool of_layer = true; // else of readings
    bool of_stress = false;
    double to_si = 1.0;
    std::string_view unit; // of a place in a study file
    std::string_view meaning;
};
std::span<const ChannelInfo> channels();
const ChannelInfo& info(Channel channel);

inline constexpr double largest_factor = 1e3;

// Modulus (or reading) times exp(g), g through ln(factors) at the places: straight between them (of stresses
// material/corrected.h) and constant beyond the outermost.
struct Correction {
    Channel channel = Channel::depth;
    std::string layer;           // of a channel that is of a layer
    std::vector<double> places;  // SI, rising
    std::vector<double> factors; // at each; above 0
    bool present = false;        // modelled where all factors are 1 too

    // "subgrade-depth", "readings-offset": of two corrections of a case no two are the same.
    std::string name() const;
};

// Where all factors are 1 and it is not `present`, a correction changes no bit.
bool is_active(const Correction& correction);

// Changes c, a case without corrections as load number `load` sees it. Depths count from where the layer's top is then.
void apply(Case& c, const Correction& correction, int load);

// Why the case cannot have the correction, or "".
std::string why_impossible(const Case& c, const Correction& correction);

} // namespace pave::pavement
