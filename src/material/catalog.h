// The material laws that a study may name.
#pragma once

#include "material/law.h"

#include <span>

namespace pave::material {

std::span<const Law* const> laws();

// The law of that name, or nullptr.
const Law* find_law(std::string_view name);

} // namespace pave::material
