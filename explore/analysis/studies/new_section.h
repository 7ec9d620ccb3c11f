// The layers of a new study, as text: from a line such as "asphalt 120, base 300, subgrade".
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace explore::analysis {

// By its name and place: asphalt (asphalt, ac, hma, bituminous, binder, wearing, surfacing) and what a binder of cement
// holds together (cement, concrete, lean, stabilised) are linear, the last layer is the subgrade, the others are
// granular.
enum class NewMaterial { asphalt, bound, granular, subgrade };

struct NewLayer {
    std::string name;
    NewMaterial material = NewMaterial::granular;
    std::optional<double> thickness_mm{}; // nothing: the last, which goes on for ever
};

// "NAME MM, NAME MM, ..., NAME", top down. Throws pave::Error at --layers for anything else: fewer than two layers, a
// name twice or with other signs than letters, digits, _ and -, a thickness that is none or not from 1 to 20000 mm.
std::vector<NewLayer> new_layers(const std::string& words);

// Rounded to two significant digits.
double two_digits(double value);

// Asphalt of 120 mm, a base of 300 mm, a subgrade.
const std::vector<NewLayer>& example_layers();

struct NewSection {
    std::vector<NewLayer> layers = example_layers();
    bool is_linear = false;            // granular layers too
    bool has_energy = false;           // granular layers are hyperelastic: for whole pulses
    std::optional<double> asphalt_C{}; // nothing: 20 degrees
    double subgrade_MPa = 60.0, subgrade_low_MPa = 15.0, subgrade_high_MPa = 300.0;

    // [[layers]] of a study. Asphalt has 3000 MPa at 20 degrees and what that is at asphalt_C
    // (data/asphalt_temperature.h).
    std::string layers_text() const;
    // [[parameters]]: the modulus, or k1, of every layer, from a sixth of its value to six times that.
    std::string parameters_text() const;
    // [[outputs]] under a load: the strain at the bottom of the asphalt, where there is one, and at the top of the
    // subgrade.
    std::string outputs_text(const std::string& load) const;
    double depth_of_subgrade_mm() const;
};

} // namespace explore::analysis
