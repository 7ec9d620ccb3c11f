// Concrete slabs from their bowls: what the foundation carries, how stiff the slab is, joints and voids.
//
// Each bowl in the middle of a slab is fitted by least squares of relative residuals with a plate on a dense liquid or
// an elastic solid (layered/plate.h), two unknowns; and by AREA (Hoffman and Thompson 1981; Hall 1991), the area of the
// bowl over D0, which depends on the radius of relative stiffness alone. Where several levels were dropped, the line
// through load and D0 that does not start near zero points to a void (Crovetti and Darter 1985; 50 um in AASHTO 1993).
// At stations named as joints the load transfer is D300/D0, times the D0/D300 of the slabs themselves.
//
// Slabs are infinite, unless length and width are stated: then l by AREA and D0 are those of a slab dropped on in its
// middle, on a dense liquid, by the regressions of Crovetti (1994), with the L of slab_size_mm over l by AREA:
//     l shrinks to     1 - 0.89434 exp(-0.61662 (L/l)^1.04831)
//     D0 shrinks to    1 - 1.15085 exp(-0.71878 (L/l)^0.80151)
//
// Left out: edges and corners, base layers and their bond, the concrete's own compression under the plate (a few per
// cent of D0 on thick slabs), curling. k is that of a falling weight; the static value of design is about half of it
// (AASHTO 1993, supplement 1998).
#pragma once

#include "data/deflection_bowl.h"
#include "layered/plate.h"

namespace explore::analysis {

struct SlabOptions {
    double thickness_mm = 0.0;
    double poisson = 0.15; // of the concrete
    pave::layered::Foundation foundation = pave::layered::Foundation::dense_liquid;
    double soil_poisson = 0.45;             // of an elastic solid
    double length_mm = 0.0, width_mm = 0.0; // between joints; 0: infinite
    std::vector<std::string>
        joints; // stations beside a joint: the plate on one slab, the sensor at 300 mm on the other
};

struct SlabRange {
    double value = 0.0, low = 0.0, high = 0.0; // 95 %, from the residuals
};

struct SlabFit {
    SlabRange stiffness_mm; // radius of relative stiffness
    SlabRange foundation;   // k in MPa/m, or the modulus of the solid in MPa
    SlabRange slab_MPa;     // modulus of the concrete
    double rms_percent = 0.0;
};

struct SlabStation {
    std::string name;
    std::optional<double> chainage_m{};
    bool is_joint = false;
    std::string reason{}; // why there is no answer; "": there is one
    double pressure_kPa = 0.0, d0_um = 0.0;
    std::optional<SlabFit> fit{};              // of slabs
    std::optional<double> area_mm{};           // to the outermost sensor within 1.6 m
    std::optional<double> area_stiffness_mm{}; // l by it
    std::optional<double> area_foundation{};   // k or the modulus by it and D0
    std::optional<double> area_slab_MPa{};     // modulus of the concrete by both
    std::optional<double> intercept_um{};      // of the line through load and D0; nothing: one level
    std::optional<double> transfer_percent{};  // of joints
};

struct SlabResult {
    SlabOptions options;
    std::vector<SlabStation> stations;
    std::optional<double> bending; // median D0/D300 of the slabs
    std::vector<std::string> remarks;
};

inline constexpr double void_intercept_um = 50.0;
inline constexpr double poor_rms_percent = 5.0; // a plate does not describe the bowl

// Of the square slab that is as stiff as a rectangle: the root of the area, of at most two squares of its shorter side
// (AASHTO 1993, supplement 1998).
double slab_size_mm(const SlabOptions& options);

// Throws pave::Error for a station that is named as a joint and is not in the files, and for a size on an elastic solid
// or half a size.
SlabResult slabs(const std::vector<data::FwdFile>& files, const SlabOptions& options);

// In sentences, the answer first.
std::vector<std::string> findings(const SlabResult& result);

} // namespace explore::analysis
