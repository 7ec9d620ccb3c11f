// The response of a layered elastic section to circles of pressure, at points, with exact derivatives.
//
// Displacement, strain and stress at a point are integrals over the Hankel parameter k of what the column of layers
// does (column.h) times weights that know circles and places (circles.h). Accuracy: some 1e-9 of the largest value of
// the same quantity at the same depth; near the edge of a circle and near the surface too. On the surface under the
// edge of a circle, where the pressure jumps, strain and stress are the mean of both sides.
#pragma once

#include "layered/circles.h"
#include "layered/column.h"
#include "mechanics/voigt.h"

#include <span>

namespace pave::layered {

struct Layer {
    mechanics::Stiffness<6> stiffness; // Pa, cross-anisotropic with a vertical axis; tension positive
    double thickness = 0.0;            // m; of the last layer of a half-space: of no account
    double compliance = 0.0;           // m/Pa, shear compliance of the interface at its bottom; 0: bonded
};

struct Section {
    std::vector<Layer> layers; // from the top
    bool half_space = false;   // the last layer goes on for ever; else it stands on a rigid rough floor
};

// At one point, z down, tension positive.
struct Field {
    double uz = 0.0; // m
    double strain_xx = 0.0, strain_yy = 0.0, strain_zz = 0.0;
    double stress_xx = 0.0, stress_yy = 0.0, stress_zz = 0.0; // Pa
};

// A point below place number `place` of the weights. On an interface it belongs to the layer below.
struct Point {
    std::size_t place;
    double depth; // m
};

// The section's answer to any circles, at the depths of points: what is left to do for circles is to add up.
class Transform {
public:
    // rates: directions in which to differentiate, of every layer's three numbers. Depths as in points.
    Transform(const Section& section, std::span<const std::vector<Layer>> rates, const std::vector<double>& depths);

    // Of a mean pressure of 1 Pa on every circle, at every point whose depth is one of the depths given.
    std::vector<Field> fields(Weights& weights, std::span<const Point> points) const;
    // Its derivatives in direction number `direction`.
    std::vector<Field> rates(Weights& weights, std::span<const Point> points, std::size_t direction) const;

private:
    struct Numbers { // of one depth: over the nodes, what is left of the limits
        Eigen::VectorXd u, w, s;
        double u_limit = 0.0, w_limit = 0.0, s_limit = 0.0; // as k goes to infinity
    };
    struct Sums {
        double displacement, mean, difference, stress;
    };
    struct Answer {                                     // or its derivative in one direction
        std::vector<Numbers> numbers;                   // of each depth
        std::vector<mechanics::Stiffness<6>> stiffness; // there
    };
    template <class R>
    void run(const Section& section, std::span<const std::vector<Layer>> rates, std::span<Answer> answers) const;
    Sums sums(const Numbers& numbers, Weights& weights, std::size_t place) const;
    std::size_t number_of(double depth) const;

    PanelRange range_{};
    std::vector<double> depths_;     // increasing, each once
    std::vector<std::size_t> layer_; // of each depth
    Answer values_;
    std::vector<Answer> rates_; // of each direction
};

} // namespace pave::layered
