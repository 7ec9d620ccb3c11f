#include "study/keys.h"

#include "study/table_reader.h"

namespace explore::study {

std::span<const Key> study_keys() {
    using namespace keys;
    static constexpr Key all[] = {
        schema,
        title,
        section_bottom,
        model_type,
        model_command,
        model_inputs,
        model_files,
        model_folder,
        model_outputs,
        model_time_limit,
        model_keep,
        model_url,
        model_urls,
        model_name,
        model_config,
        model_input_template,
        model_input_file,
        model_output_file,
        model_output_reading,
        model_output_line,
        model_output_column,
        model_output_by,
        model_output_value,
        model_output_at,
        layer_name,
        layer_law,
        load_name,
        load_type,
        load_patch,
        load_history,
        load_wheels,
        wheel_x,
        wheel_y,
        wheel_force,
        solver_integration,
        solver_load_steps,
        solver_path,
        solver_equilibrium,
        solver_time_limit,
        solver_time_step,
        mesh_extent,
        mesh_refine,
        measure_possible,
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
        noise_correlation_time,
        noise_drift,
        noise_of_drops,
        noise_shared_relative,
        noise_shared_common_relative,
        noise_loss,
        noise_degrees,
        noise_scale,
        data_held_out,
        data_weights,
        output_name,
        output_load,
        output_quantity,
        output_unit,
        output_x,
        output_y,
        output_depth,
        output_gauge,
        output_time,
        effect_name,
        effect_size,
        effect_layer,
        effect_load,
        effect_quantity,
        effect_reading,
        effect_thickness,
        effect_parameter,
        effect_null,
        effect_typical,
        effect_range,
        correction_channel,
        correction_layer,
        correction_at_mm,
        correction_at_kPa,
        correction_factor,
        parameter_name,
        parameter_scale,
        parameter_min,
        parameter_max,
        parameter_points,
        parameter_level,
        parameter_prior,
        prior_mean,
        prior_sd,
        parameter_value,
        parameter_equals,
        correlation_between,
        correlation_value,
        constraint_that,
        criterion_name,
        criterion_law,
        criterion_axle,
        criterion_layer,
        criterion_modulus,
        criterion_traffic,
        criterion_growth,
        criterion_passed,
        criterion_design,
        criterion_life,
        criterion_place,
        season_name,
        season_share,
        season_factors,
        season_asphalt,
        season_tested,
    };
    return all;
}

std::vector<Key> root_keys() {
    std::vector<Key> roots;
    for (Key key : study_keys()) {
        const std::size_t begin = key.table.find_first_not_of('[');
        if (begin == 0) { // of a table within a table
            continue;
        }
        if (begin != std::string_view::npos) {
            key.key = key.table.substr(begin, key.table.find_first_of(".]") - begin);
        }
        roots.push_back(key);
    }
    return roots;
}

} // namespace explore::study
