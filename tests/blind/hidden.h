// Effects and other physics that the generator of blind cases hides: of the catalogue, of another form than there, or
// outside it.
#pragma once

#include "blind/sections.h"
#include "pavement/effects/effect.h"

namespace blind {

// Physics that no effect of the catalogue has. Its size is of the logarithm of a modulus, but for the last three.
struct Outside {
    std::string_view name;
    std::string_view channel, layer;                                            // where it acts; layer "": on readings
    double most;                                                                // size
    double (*weight)(const fe::Field::Shape& shape, const Eigen::Vector3d& at); // of a modulus; none: see apply_outside
};

struct Hidden {
    const Effect* effect = nullptr;
    AppliedEffect options; // what it acts on
    std::string form;      // empty: the catalogue's own
    double size = 0.0;
    const Outside* outside = nullptr; // in place of an effect
    double place = 0.0, width = 0.0;  // m, of that

    std::string name() const { return std::string(outside != nullptr ? outside->name : effect->name); }
};

Hidden draw_hidden(Draw& draw, const Case& c, const std::string& kind);
// Responses with what is hidden; other forms are applied load by load, so each load is run alone.
VectorXd responses_with(const Case& plain, const std::vector<Hidden>& hidden);
Json words(const Case& c, const Hidden& hidden);

} // namespace blind
