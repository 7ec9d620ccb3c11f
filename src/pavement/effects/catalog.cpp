#include "pavement/effects/catalog.h"

// One line an effect: the function of that name in the file of that name.
#define PAVE_EFFECTS(EFFECT)                                                                                           \
    EFFECT(subgrade_stress_dependence)                                                                                 \
    EFFECT(subgrade_depth_gradient)                                                                                    \
    EFFECT(weak_subgrade_top)                                                                                          \
    EFFECT(subgrade_anisotropy)                                                                                        \
    EFFECT(anisotropy_distribution)                                                                                    \
    EFFECT(base_residual_stress)                                                                                       \
    EFFECT(base_tension)                                                                                               \
    EFFECT(base_modulus_gradient)                                                                                      \
    EFFECT(base_sublayer)                                                                                              \
    EFFECT(interface_slip_in_asphalt)                                                                                  \
    EFFECT(interface_slip_asphalt_base)                                                                                \
    EFFECT(interface_slip_base_subgrade)                                                                               \
    EFFECT(floor_depth)                                                                                                \
    EFFECT(base_thickness)                                                                                             \
    EFFECT(asphalt_modulus_rate)                                                                                       \
    EFFECT(asphalt_temperature_gradient)                                                                               \
    EFFECT(load_magnitude)                                                                                             \
    EFFECT(load_offset)                                                                                                \
    EFFECT(contact_pressure_shape)                                                                                     \
    EFFECT(plate_rigidity)                                                                                             \
    EFFECT(gauge_depth)                                                                                                \
    EFFECT(gauge_length)                                                                                               \
    EFFECT(sensor_gain)                                                                                                \
    EFFECT(sensor_position)                                                                                            \
    EFFECT(drift)                                                                                                      \
    EFFECT(outlier)                                                                                                    \
    EFFECT(inertia)                                                                                                    \
    EFFECT(damping)                                                                                                    \
    EFFECT(asphalt_relaxation)                                                                                         \
    EFFECT(density)                                                                                                    \
    EFFECT(shear_ratio)                                                                                                \
    EFFECT(wheel_wander)

namespace pave::pavement {

#define DECLARE(name) const Effect& name();
PAVE_EFFECTS(DECLARE)
#undef DECLARE

std::span<const Effect* const> effects() {
#define ADDRESS(name) &name(),
    static const Effect* const all[] = {PAVE_EFFECTS(ADDRESS)};
#undef ADDRESS
    return all;
}

const Effect* find_effect(std::string_view name) {
    for (const Effect* effect : effects()) {
        if (effect->name == name) {
            return effect;
        }
    }
    return nullptr;
}

} // namespace pave::pavement
