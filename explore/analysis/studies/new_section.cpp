#include "analysis/studies/new_section.h"

#include "base/error.h"
#include "data/asphalt_temperature.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <sstream>

namespace explore::analysis {
namespace {

constexpr std::string_view layers_allowed =
    "layers from the top down with their mm, the last without: \"asphalt 120, base "
    "300, subgrade\"";

bool names_any(const std::string& name, std::initializer_list<std::string_view> words) {
    std::string lower = name;
    std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
    return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
        return word.size() > 3 ? lower.find(word) != std::string::npos : lower == word;
    });
}

NewMaterial material_of(const std::string& name, bool is_last) {
    return is_last                                                                             ? NewMaterial::subgrade
           : names_any(name, {"asphalt", "ac", "hma", "bitum", "binder", "wearing", "surfac"}) ? NewMaterial::asphalt
           : names_any(name, {"cement", "concrete", "lean", "stabili"})                        ? NewMaterial::bound
                                                                                               : NewMaterial::granular;
}

bool is_plain(const std::string& name) {
    return std::all_of(name.begin(), name.end(),
                       [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
}

double asphalt_MPa(std::optional<double> celsius) {
    constexpr double reference_MPa = 3000.0, reference_C = 20.0;
    return two_digits(reference_MPa * (celsius ? data::modulus_factor(reference_C, *celsius) : 1.0));
}

constexpr double granular_MPa = 300.0;
constexpr double bound_MPa = 10000.0;

struct Bounds {
    std::string key;
    double low = 0.0, high = 0.0;
};

} // namespace

double two_digits(double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
    return std::round(value / unit) * unit;
}

std::vector<NewLayer> new_layers(const std::string& words) {
    std::vector<NewLayer> layers;
    std::istringstream list(words);
    const auto refuse = [&](const std::string& problem, const std::string& found) {
        throw pave::Error({.key = "--layers"}, problem, "\"" + found + "\"", layers_allowed);
    };
    bool has_ended = false;
    for (std::string item; std::getline(list, item, ',');) {
        std::istringstream parts(item);
        std::string name, thickness, more;
        parts >> name >> thickness >> more;
        if (has_ended) {
            refuse("only the last layer is without a thickness", layers.back().name);
        }
        if (name.empty() || !more.empty() || !is_plain(name)) {
            refuse("not a layer", item);
        }
        if (std::any_of(layers.begin(), layers.end(), [&](const NewLayer& l) { return l.name == name; })) {
            refuse("two layers have this name", name);
        }
        layers.push_back({.name = name});
        has_ended = thickness.empty();
        if (!has_ended) {
            double mm = 0.0;
            const char* end = thickness.data() + thickness.size();
            const auto read = std::from_chars(thickness.data(), end, mm);
            constexpr double least = 1.0, most = 20000.0;
            if (read.ec != std::errc() || read.ptr != end || !(mm >= least && mm <= most)) {
                refuse("not a thickness from 1 to 20000 mm", thickness);
            }
            layers.back().thickness_mm = mm;
        }
    }
    if (layers.size() < 2 || !has_ended) {
        refuse(has_ended || layers.empty() ? "fewer than two layers" : "the last layer goes on for ever: no thickness",
               words);
    }
    for (NewLayer& layer : layers) {
        layer.material = material_of(layer.name, &layer == &layers.back());
    }
    return layers;
}

const std::vector<NewLayer>& example_layers() {
    static const std::vector<NewLayer> layers = new_layers("asphalt 120, base 300, subgrade");
    return layers;
}

std::string NewSection::layers_text() const {
    std::string text;
    for (const NewLayer& layer : layers) {
        const bool is_first = &layer == layers.data();
        text += fmt::format("{}[[layers]]\nname = \"{}\"\n", is_first ? "" : "\n", layer.name);
        if (layer.thickness_mm) {
            text += fmt::format("thickness_mm = {:g}\n", *layer.thickness_mm);
        }
        const auto weight = [&](double density) {
            text += is_first
                        ? fmt::format("density_kg_m3 = {:g}          # with k0: the stress that is there before the "
                                      "load\nk0 = 0.5                      # horizontal over vertical stress at "
                                      "rest\n",
                                      density)
                        : fmt::format("density_kg_m3 = {:g}\nk0 = 0.5\n", density);
        };
        const auto linear = [&](double modulus, const std::string& remark, double poisson) {
            text += fmt::format("law = \"linear\"\nmodulus_MPa = {:g}{}\npoisson = {:.2f}\n", modulus, remark, poisson);
        };
        if (layer.material == NewMaterial::asphalt) {
            weight(2300.0);
            linear(asphalt_MPa(asphalt_C),
                   asphalt_C
                       ? fmt::format("            # 3000 MPa at 20 C, taken to the {:.1f} C of the file", *asphalt_C)
                       : std::string(),
                   0.35);
        } else if (layer.material == NewMaterial::bound) {
            weight(2300.0);
            linear(bound_MPa, "", 0.20);
        } else if (layer.material == NewMaterial::subgrade) {
            weight(1900.0);
            linear(subgrade_MPa, "", 0.40);
        } else if (is_linear) {
            weight(2200.0);
            linear(granular_MPa, "", 0.35);
        } else {
            weight(2200.0);
            text +=
                has_energy
                    ? R"(law = "hyperelastic"          # E = k1 pa (Q/pa^2)^(k/2), Q = sigma : A : sigma; gives all strain back
modulus_axis = "vertical"     # E is that of the laboratory test; "horizontal": E1
k1 = 800                      # of a secant: some 0.6 times the k1 of "uzan"
k = 0.5                       # 0.3 to 0.7: stiffens with stress
)"
                    : R"(law = "uzan"                  # E = k1 pa (theta/pa)^k2 (tau/pa + 1)^k3, pa = 100 kPa
modulus_axis = "vertical"     # E is that of the laboratory test; "horizontal": E1
k1 = 1300                     # 900 to 1700 for crushed rock
k2 = 0.65                     # 0.5 to 0.8: stiffens with confinement
k3 = -0.3                     # -0.8 to 0: softens with shear
)";
            text += "n = 0.4                       # horizontal over vertical modulus\npoisson_12 = 0.35\n"
                    "poisson_31 = 0.35\n";
        }
    }
    return text;
}

std::string NewSection::parameters_text() const {
    constexpr double times = 6.0;
    std::string text;
    for (const NewLayer& layer : layers) {
        const auto about = [&](double modulus) {
            return Bounds{"modulus_MPa", two_digits(modulus / times), two_digits(modulus * times)};
        };
        const Bounds bounds = layer.material == NewMaterial::asphalt ? about(asphalt_MPa(asphalt_C))
                              : layer.material == NewMaterial::bound ? about(bound_MPa)
                              : layer.material == NewMaterial::subgrade
                                  ? Bounds{"modulus_MPa", subgrade_low_MPa, subgrade_high_MPa}
                              : is_linear ? about(granular_MPa)
                                          : Bounds{"k1", 200.0, 8000.0};
        text += fmt::format("{}[[parameters]]\nname = \"{}.{}\"\nmin = {:g}\nmax = {:g}\nscale = \"log\"\n",
                            text.empty() ? "" : "\n", layer.name, bounds.key, bounds.low, bounds.high);
    }
    return text;
}

double NewSection::depth_of_subgrade_mm() const {
    double depth = 0.0;
    for (const NewLayer& layer : layers) {
        depth += layer.thickness_mm.value_or(0.0);
    }
    return depth;
}

std::string NewSection::outputs_text(const std::string& load) const {
    std::string text = fmt::format(
        "[[outputs]]\nname = \"subgrade-top strain\"\nload = \"{}\"\nquantity = \"strain_zz\"\ndepth_mm = {:g}\n", load,
        depth_of_subgrade_mm() + 1.0);
    double bottom = 0.0; // of the asphalt at the surface
    for (const NewLayer& layer : layers) {
        if (layer.material != NewMaterial::asphalt) {
            break;
        }
        bottom += *layer.thickness_mm;
    }
    if (bottom > 0.0) {
        text += fmt::format("\n[[outputs]]\nname = \"asphalt-bottom strain\"\nload = \"{}\"\nquantity = "
                            "\"strain_xx\"\ndepth_mm = {:g}\n",
                            load, bottom - 0.1);
    }
    return text;
}

} // namespace explore::analysis
