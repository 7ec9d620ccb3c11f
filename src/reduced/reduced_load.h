// The reduced model of one load: the finite element model projected on few displacement fields.
//
// Unknowns are the factors of modes that were taken from load paths of the full model. Linear layers enter exactly: the
// projection of their stiffness is linear in the entries of D. Stress-dependent layers are integrated at few of their
// Gauss points with non-negative weights (empirical cubature: Farhat et al. 2014, doi 10.1002/nme.4668), and each of
// them keeps its own stress along the path. The path, its steps and its derivatives are those of the full model
// (fe/load_path.h).
#pragma once

#include "fe/load_path.h"
#include "pavement/load_model.h"
#include "reduced/kriging.h"

#include <functional>
#include <span>
#include <string>

namespace pave::reduced {

// Why this case has no reduced model under this load, or "": it holds for the incremental law on a mesh that stays,
// without springs, fields within layers and inertia.
std::string why_not(const pavement::Case& c, int load);

// What fixes a reduced model besides the case; plain numbers that can be written to a file.
struct Basis {
    Eigen::MatrixXd modes; // free unknowns x modes
    int coarse = 0;        // the first so many make the model that errors are estimated against
    struct Point {
        int gauss = 0; // number in the full model
        double weight = 0.0;
    };
    std::vector<Point> points; // of the cubature
    // What the readings lack relative to smooth_scales(), learnt from full runs, by what the samples of the build vary.
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
    // the coarse model misses and the correction adds, plus floor. Empty: 1 and 0.
    std::vector<double> factor, floor;
};

struct BuildSettings {
    double tolerance = 2e-3; // of readings, at the samples of the build
    int most_runs = 280;     // of the full model, in all
    int calibration = 90;    // of them, to learn what the estimates are worth
    std::uint64_t seed = 1;
};

struct BuildReport {
    int full_runs = 0;
    int modes = 0;
    int points = 0;
    double error_95 = 0.0; // at the calibration samples
};

// Calls body(i) for i in [0, n), in any order or at once.
using ForEach = std::function<void(std::size_t n, const std::function<void(std::size_t)>& body)>;

// samples: cases of the box in random order. The first serve to build, the last to calibrate. Failure: too few of them
// have an answer.
Outcome<Basis> build(const pavement::Case& nominal, int load, std::span<const pavement::Case> samples,
                     const BuildSettings& settings, const ForEach& for_each, BuildReport* report = nullptr);

// The model of a basis. Its readings carry errors. A case that differs from the nominal one in more than it covers
// ends in a failure that says so.
std::unique_ptr<const pavement::LoadModel> make_load_model(const pavement::Case& nominal, int load, Basis basis);

// The quantities by which samples differ, with the ranges that they have there.
std::vector<Basis::Coordinate> coordinates_of(const std::vector<std::vector<fe::LayerMaterial>>& layers,
                                              const std::vector<pavement::Load>& loads);

// As scales(), but smooth: the root of the sum of squares of a value and of a twentieth of all of the same quantity.
std::vector<double> smooth_scales(const pavement::Case& c, int load, const std::vector<double>& values);

// What errors are relative to: |value|, but at least a twentieth of the largest reading of the same quantity.
std::vector<double> scales(const pavement::Case& c, int load, const std::vector<double>& values);

} // namespace pave::reduced
