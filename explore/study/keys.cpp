#include "study/keys.h"

namespace explore::study {

std::span<const Key> study_keys() {
    using namespace keys;
    static constexpr Key all[] = {
        schema,
        title,
        section_bottom,
        layer_name,
        layer_law,
        load_name,
        load_type,
        load_patch,
        load_wheels,
        wheel_x,
        wheel_y,
        wheel_force,
        solver_integration,
        solver_path,
        solver_equilibrium,
        mesh_extent,
        mesh_refine,
        data_files,
        data_outside,
        data_misfit,
        data_log_floor,
        data_noise_relative,
        data_noise_floor,
        data_noise,
        noise_relative,
        noise_absolute,
        noise_common_relative,
        noise_correlation,
        data_held_out,
        data_weights,
        output_name,
        output_load,
        output_quantity,
        output_x,
        output_y,
        output_depth,
        output_gauge,
        effect_name,
        effect_size,
        effect_layer,
        effect_load,
        effect_quantity,
        effect_reading,
        effect_thickness,
        parameter_name,
        parameter_scale,
        parameter_min,
        parameter_max,
        parameter_points,
    };
    return all;
}

} // namespace explore::study
