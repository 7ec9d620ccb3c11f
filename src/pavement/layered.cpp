#include "pavement/layered.h"

#include "base/error.h"
#include "layered/response.h"
#include "pavement/device.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pave::pavement {
namespace {

using Kind = fe::Variation::Kind;

layered::Circles circles_of(const Load& load) {
    layered::Circles circles{.circles = {}, .shape = load.pressure_shape};
    for (const Load::Circle& circle : load.circles()) {
        circles.circles.push_back({circle.x, circle.y, circle.radius});
    }
    return circles;
}

layered::Section section_of(const Case& values, const std::vector<fe::LayerMaterial>& layers) {
    layered::Section section{.layers = {}, .half_space = values.half_space};
    for (std::size_t l = 0; l < layers.size(); ++l) {
        const auto& p = layers[l].parameters;
        section.layers.push_back({layers[l].law->modulus(p, {}).value * layers[l].law->unit_stiffness(p, {}),
                                  values.layers[l].thickness, values.layers[l].compliance.value_or(0.0)});
    }
    return section;
}

std::vector<layered::Layer> no_rate(std::size_t layers) {
    return {layers, {.stiffness = mechanics::Stiffness<6>::Zero()}};
}

mechanics::Stiffness<6> stiffness_rate(const fe::LayerMaterial& layer, std::size_t parameter) {
    const auto& p = layer.parameters;
    const material::Modulus modulus = layer.law->modulus(p, {});
    return modulus.value * layer.law->unit_stiffness_derivative(p, {}, parameter) +
           layer.law->modulus_derivative(p, {}, modulus, parameter) * layer.law->unit_stiffness(p, {});
}

double value_of(const layered::Field& f, Quantity quantity) { // signs of Quantity
    switch (quantity) {
    case Quantity::deflection: return f.uz;
    case Quantity::strain_zz: return -f.strain_zz;
    case Quantity::strain_xx: return -f.strain_xx;
    case Quantity::strain_yy: return -f.strain_yy;
    case Quantity::stress_zz: return -f.stress_zz;
    case Quantity::stress_xx: return -f.stress_xx;
    default: return -f.stress_yy;
    }
}

// Where the sensors of one load read.
class Layout {
public:
    Layout(const std::vector<Sensor>& sensors, int load) {
        for (std::size_t i = 0; i < sensors.size(); ++i) {
            const Sensor& sensor = sensors[i];
            if (sensor.load != load) {
                continue;
            }
            for (const auto& [plain, weight] : plain_readings(sensor)) {
                const double z = plain.depth;
                if (plain.quantity == Quantity::strain_zz && plain.gauge > 0.0) {
                    const double half = plain.gauge / 2.0;
                    add(i, {plain.x, plain.y, false}, z - half, Quantity::deflection, weight / plain.gauge);
                    add(i, {plain.x, plain.y, false}, z + half, Quantity::deflection, -weight / plain.gauge);
                } else {
                    add(i, {plain.x, plain.y, plain.quantity != Quantity::deflection}, z, plain.quantity, weight);
                }
            }
        }
    }

    const std::vector<layered::Place>& places() const { return places_; }
    const std::vector<layered::Point>& points() const { return points_; }
    std::vector<double> depths() const {
        std::vector<double> depths;
        for (const layered::Point& point : points_) {
            depths.push_back(point.depth);
        }
        return depths;
    }

    // Calls f(sensor, reading) for every part of every reading; fields: at the points.
    template <class F>
    void read(const std::vector<layered::Field>& fields, F f) const {
        for (std::size_t n = 0; n < parts_.size(); ++n) {
            f(parts_[n].sensor, parts_[n].weight * value_of(fields[n], parts_[n].quantity));
        }
    }

private:
    struct Part { // of a reading, at the point of the same number
        std::size_t sensor;
        Quantity quantity;
        double weight;
    };
    void add(std::size_t sensor, const layered::Place& place, double depth, Quantity quantity, double weight) {
        auto known = std::find(places_.begin(), places_.end(), place);
        if (known == places_.end()) {
            known = places_.insert(places_.end(), place);
        }
        points_.push_back({static_cast<std::size_t>(known - places_.begin()), std::max(depth, 0.0)});
        parts_.push_back({sensor, quantity, weight});
    }
    std::vector<layered::Place> places_;
    std::vector<layered::Point> points_;
    std::vector<Part> parts_;
};

class LayeredLoad final : public LoadModel {
public:
    LayeredLoad(const Case& nominal, int load) : nominal_(nominal), load_(load) {}

    std::unique_ptr<Workspace> make_workspace(Lent&) const override { return std::make_unique<Own>(); }
    int unknowns() const override { return 0; }
    double reach(const Case& values) const override {
        return values.half_space ? std::numeric_limits<double>::infinity() : values.depth();
    }

    Outcome<Reading> run(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                         const std::vector<fe::Variation>& variations, const std::vector<Neighbours>& moving,
                         Workspace& workspace) const override {
        const Load& load = values.loads[static_cast<std::size_t>(load_)];
        Own& own = static_cast<Own&>(workspace);
        const Layout layout(values.sensors, load_);
        if (load.circles_overlap()) {
            return Failure{Status::invalid_parameters, "the patches of the load overlap for this geometry"};
        }

        std::vector<std::vector<layered::Layer>> directions;
        std::vector<std::optional<std::size_t>> direction_of(variations.size());
        for (std::size_t k = 0; k < variations.size(); ++k) {
            if (auto rates = rates_of(values, layers, variations[k], moving)) {
                direction_of[k] = directions.size();
                directions.push_back(std::move(*rates));
            }
        }
        const layered::Transform transform(section_of(values, layers), directions, layout.depths());
        const auto count = values.sensors.size();
        // The readings of a load, in all directions of the section at none.
        const auto readings = [&](const Load& on, std::optional<std::size_t> direction) {
            Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(count));
            layered::Weights& weights = own.weights(circles_of(on), layout.places());
            const double pressure = on.pressure * on.factor;
            layout.read(
                direction ? transform.rates(weights, layout.points(), *direction)
                          : transform.fields(weights, layout.points()),
                [&](std::size_t sensor, double part) { sum[static_cast<Eigen::Index>(sensor)] += pressure * part; });
            return sum;
        };
        const Eigen::VectorXd values_there = readings(load, {});
        if (!values_there.allFinite()) {
            return Failure{Status::failed, "the solution is not a finite number"};
        }
        Reading reading;
        reading.values.assign(values_there.begin(), values_there.end());
        reading.derivatives.setZero(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(variations.size()));
        for (std::size_t k = 0; k < variations.size(); ++k) {
            auto column = reading.derivatives.col(static_cast<Eigen::Index>(k));
            if (direction_of[k]) {
                column = readings(load, direction_of[k]);
            }
            if (variations[k].kind == Kind::load_factor) {
                column += values_there;
            } else if (variations[k].kind == Kind::pressure_shape) { // the response is linear in it
                Load more = load;
                more.pressure_shape += 1.0;
                column += readings(more, {}) - values_there;
            } else if (variations[k].kind == Kind::motion) {
                for (const auto& [weight, there] : moving[variations[k].index]) {
                    const Load& moved = there.loads[static_cast<std::size_t>(load_)];
                    if (moved != load) {
                        column += weight * readings(moved, {});
                    }
                }
            }
        }
        return reading;
    }

    Outcome<Fields> fields(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                           Workspace&) const override {
        if (nominal_.loads[static_cast<std::size_t>(load_)].type == LoadType::gear) {
            return Failure{Status::failed, "the field under a gear is not computed"};
        }
        const auto model = make_finite_element_model(nominal_, load_);
        return model->fields(values, layers, *model->make_workspace());
    }

private:
    // Weights of layouts, those used last.
    struct Own : Workspace {
        std::vector<std::unique_ptr<layered::Weights>> kept;

        layered::Weights& weights(const layered::Circles& circles, const std::vector<layered::Place>& places) {
            constexpr std::size_t most = 32;
            auto known = std::find_if(kept.begin(), kept.end(),
                                      [&](const auto& weights) { return weights->serve(circles, places); });
            if (known == kept.end()) {
                if (kept.size() == most) {
                    kept.pop_back();
                }
                known = kept.insert(kept.begin(), std::make_unique<layered::Weights>(circles, places));
            }
            std::rotate(kept.begin(), known, known + 1);
            return *kept.front();
        }
    };

    // How the section follows a variation; nothing: it does not.
    static std::optional<std::vector<layered::Layer>> rates_of(const Case& values,
                                                               const std::vector<fe::LayerMaterial>& layers,
                                                               const fe::Variation& variation,
                                                               const std::vector<Neighbours>& moving) {
        auto rates = no_rate(layers.size());
        if (variation.kind == Kind::law_parameter) {
            const auto layer = static_cast<std::size_t>(variation.layer);
            rates[layer].stiffness = stiffness_rate(layers[layer], variation.index);
            return rates;
        }
        if (variation.kind == Kind::spring) { // by the stiffness of the spring, the inverse of the compliance
            std::size_t spring = 0;
            for (std::size_t l = 0; l < layers.size(); ++l) {
                if (const auto& compliance = values.layers[l].compliance; compliance && spring++ == variation.index) {
                    rates[l].compliance = -*compliance * *compliance;
                }
            }
            return rates;
        }
        if (variation.kind == Kind::motion) {
            bool moves = false;
            for (const auto& [weight, there] : moving[variation.index]) {
                for (std::size_t l = 0; l < layers.size(); ++l) {
                    rates[l].thickness += weight * there.layers[l].thickness;
                    moves = moves || there.layers[l].thickness != values.layers[l].thickness;
                }
            }
            if (moves) {
                return rates;
            }
        }
        return std::nullopt;
    }

    Case nominal_;
    int load_;
};

} // namespace

std::string why_not_layered(const Case& c, int number) {
    const Load& load = c.loads[static_cast<std::size_t>(number)];
    for (const Layer& layer : c.layers) {
        if (layer.law->stress_dependent() || layer.law->relaxes()) {
            return "layer \"" + layer.name + "\" is not linear elastic";
        }
        if (!layer.fields.empty()) {
            return "layer \"" + layer.name + "\" is not the same all over";
        }
    }
    if (load.patch != Patch::circle) {
        return "the load is no circle";
    }
    if (load.plate_stiffness || load.inertia || load.is_pulse()) {
        return "the plate is stiff or the load is a pulse";
    }
    return {};
}

std::unique_ptr<const LoadModel> make_layered_model(const Case& nominal, int load) {
    return std::make_unique<LayeredLoad>(nominal, load);
}

} // namespace pave::pavement
