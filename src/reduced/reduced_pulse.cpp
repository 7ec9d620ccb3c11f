#include "reduced/reduced_pulse.h"

#include "pavement/effects/effect.h"

#include <algorithm>
#include <functional>

namespace pave::reduced {

using namespace pavement;

namespace {

// A whole pulse in the subspace of a basis. The error of its readings is known of each sensor.
class ReducedPulse final : public LoadModel {
public:
    ReducedPulse(const Case& nominal, int load, Basis basis)
        : load_(load),
          sensors_(nominal.sensors),
          floor_(std::move(basis.floor)) {
        const Case own = with_effects(nominal, load);
        fe::Subspace subspace{std::move(basis.modes), {}};
        const auto add_points = [&](const auto& model) {
            for (const auto& p : basis.points) {
                subspace.points.push_back({p.gauss, p.weight / model.points[static_cast<std::size_t>(p.gauss)].weight});
            }
        };
        if (own.loads[static_cast<std::size_t>(load)].is_axisymmetric()) {
            add_points(parts_of<Axisymmetric>(own, load).model);
        } else {
            add_points(parts_of<Solid>(own, load).model);
        }
        model_ = make_pulse_model(own, load, std::move(subspace));
    }

    std::unique_ptr<Workspace> make_workspace(Lent& lent) const override { return model_->make_workspace(lent); }
    int unknowns() const override { return model_->unknowns(); }

    Outcome<Reading> run(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                         const std::vector<fe::Variation>& variations, const std::vector<Neighbours>& moving,
                         Workspace& workspace) const override {
        if (!reads_the_same(values.sensors, sensors_)) {
            return does_not_cover();
        }
        auto outcome = model_->run(values, layers, variations, moving, workspace);
        if (!outcome) {
            return outcome.failure();
        }
        Reading reading = std::move(outcome).value();
        reading.errors.assign(sensors_.size(), 0.0);
        if (!floor_.empty()) {
            const auto scale = scales(values, load_, reading.values);
            std::transform(floor_.begin(), floor_.end(), scale.begin(), reading.errors.begin(), std::multiplies<>());
        }
        return reading;
    }
    Outcome<Fields> fields(const Case& values, const std::vector<fe::LayerMaterial>& layers,
                           Workspace& workspace) const override {
        return model_->fields(values, layers, workspace);
    }

private:
    int load_;
    std::vector<Sensor> sensors_;
    std::vector<double> floor_;
    std::unique_ptr<const LoadModel> model_;
};

} // namespace

std::unique_ptr<const LoadModel> make_pulse(const Case& nominal, int load, Basis basis) {
    return std::make_unique<ReducedPulse>(nominal, load, std::move(basis));
}

} // namespace pave::reduced
