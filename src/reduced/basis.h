// The parts of a reduced model, what its errors are relative to, and the correction of its readings.
#pragma once

#include "pavement/load_model.h"
#include "reduced/kriging.h"

#include <optional>
#include <string>

namespace pave::reduced {

// Why this case has no reduced model under this load, or "": it holds for the incremental law on a mesh that stays,
// without springs, fields within layers and inertia.
std::string why_not(const pavement::Case& c, int load);

// The settings of a reduced model besides the case; plain numbers that can be written to a file.
struct Basis {
    Eigen::MatrixXd modes; // free unknowns x modes
    int coarse = 0;        // the first so many make the model that errors are estimated against
    struct Point {
        int gauss = 0; // number in the full model
        double weight = 0.0;
    };
    std::vector<Point> points; // of the cubature
    // The errors of readings relative to smooth_scales(), learnt from full runs, by what the samples of the build vary.
    struct Coordinate {
        fe::Variation::Kind kind;
        int layer;
        std::size_t index;
        bool logarithmic;
        double low, high; // of the samples, or of their logarithms

        // From -1 to 1 over the samples; its derivative by the quantity itself.
        double at(const std::vector<fe::LayerMaterial>& layers, const pavement::Load& load) const;
        double rate(const std::vector<fe::LayerMaterial>& layers, const pavement::Load& load) const;
    };
    std::vector<Coordinate> coordinates;
    std::vector<Kriging> correction; // of every sensor of the nominal case. Empty: none
    // Of every sensor of the nominal case: the error of a reading, relative to scales(), is taken as factor times what
    // the coarse model misses and the correction adds, plus floor, and both times the square of the correction's reach.
    // Empty: 1 and 0.
    std::vector<double> factor, floor;
};

// The quantities by which samples differ, with the ranges that they have there; by their logarithms where the samples
// are spread evenly in them (the middle one is then nearer to the geometric mean of the ends than to the arithmetic
// one), so that a quantity whose range begins at zero is taken as it is.
std::vector<Basis::Coordinate> coordinates_of(const std::vector<std::vector<fe::LayerMaterial>>& layers,
                                              const std::vector<pavement::Load>& loads);

// As scales(), but smooth: the root of the sum of squares of a value and of a twentieth of all of the same quantity.
std::vector<double> smooth_scales(const pavement::Case& c, int load, const std::vector<double>& values);

// The scale of errors: |value|, but at least a twentieth of the largest reading of the same quantity, and of
// what has a time a quarter of the largest at its place.
std::vector<double> scales(const pavement::Case& c, int load, const std::vector<double>& values);

// Adds to the readings of a load what they are known to lack: of each sensor smooth_scales() times its correction, with
// the derivatives; |what is added| is added to their errors. Returns the squares of the corrections' reaches.
std::vector<double> correct(const Basis& basis, const pavement::Case& values, int load,
                            const std::vector<fe::LayerMaterial>& layers, const std::vector<fe::Variation>& variations,
                            pavement::LoadModel::Reading& reading);

// Whether these sensors read the same, gains aside, which are not part of a reading; and the failure where they do not.
bool reads_the_same(const std::vector<pavement::Sensor>& one, const std::vector<pavement::Sensor>& other);
Failure does_not_cover();

// A basis as bytes of this machine's numbers, and back; nothing: they are not those of a basis.
std::string packed(const Basis& basis);
std::optional<Basis> unpacked(const std::string& bytes);

} // namespace pave::reduced
