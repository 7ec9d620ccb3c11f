// Fields of a forward run as an unstructured grid of the Visualization Toolkit, which ParaView reads.
#pragma once

#include "pavement/fields.h"
#include "pavement/forward.h"
#include "study/study.h"

#include <string>
#include <vector>

namespace explore::report {

// XML text, numbers in base64. Frame: x transverse, y along the traffic, z upwards (the surface is z = 0) [m]. Signs
// as in all that is reported: strains and stresses positive in compression; displacement_m is a vector of the frame.
// Point data: displacement_m, deflection_mm, strain_microstrain and stress_kPa of the load (tensors XX YY ZZ XY YZ XZ),
// theta_kPa and tau_kPa of the total stress, horizontal_modulus_MPa, vertical_modulus_MPa and n, their ratio.
// Cell data: layer, counted from 1 at the top.
std::string vtu_text(const pave::pavement::Fields& fields);

// The fields under every load at these values: FILE for a study of one load, FILE with "-LOAD" before its ending for
// more. The files that were written. Throws std::runtime_error where there is no answer.
std::vector<std::string> write_fields(const study::Study& study, const pave::pavement::ForwardModel& model,
                                      const pave::pavement::Case& at, const std::string& file);

} // namespace explore::report
