// The layers of a study. Private to study/.
#pragma once

#include "pavement/section.h"

#include <toml++/toml.h>

namespace explore::study {

// One of [[layers]]. meshed: of the lowest layer of a half-space, how deep it is meshed unless it says so [m]; none: of
// any other layer. Throws pave::Error.
pave::pavement::Layer read_layer(const toml::table& table, const std::string& file, std::optional<double> meshed);

} // namespace explore::study
