// The effects that a study may name.
#pragma once

#include "pavement/effects/effect.h"

#include <span>

namespace pave::pavement {

std::span<const Effect* const> effects();

// The effect of that name, or nullptr.
const Effect* find_effect(std::string_view name);

} // namespace pave::pavement
