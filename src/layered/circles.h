// Circles of pressure on a surface under the Hankel transform: quadrature over k that knows the Bessel functions.
//
// A pressure of 1 + s (2 (r/a)^2 - 1) on a circle of radius a has the transform (J1(k a) - s J3(k a)) a/k. What it does
// at a distance r is an integral over k of a smooth function of the layers, times that, times J0(k r) or J2(k r). The
// smooth function is interpolated in panels of k that double in length, at Gauss-Legendre nodes; the integrals of the
// interpolating polynomials times the Bessel functions are weights that depend on the circles and the place alone. So
// the number of nodes does not grow with the distance. At the surface the function has a limit at infinity: its
// integral is known in closed form (Weber and Schafheitlin; G. N. Watson, "A treatise on the theory of Bessel
// functions", 13.4), and the rest falls off exponentially.
#pragma once

#include <Eigen/Dense>
#include <map>
#include <vector>

namespace pave::layered {

struct Circle {
    double x, y;   // m, of its centre
    double radius; // m
    bool operator==(const Circle&) const = default;
};

// Circles under a mean pressure of 1 Pa each.
struct Circles {
    std::vector<Circle> circles;
    double shape = 0.0; // s
    bool operator==(const Circles&) const = default;
};

// Where something is read, below the point (x, y) of the surface [m].
struct Place {
    double x, y;
    bool strains; // else displacements only
    bool operator==(const Place&) const = default;
};

// Panel j reaches from k = 2^j to 2^(j+1) [1/m]; the first one from 0.
struct PanelRange {
    int first, last; // the first panel ends at 2^first, the last at 2^last
    int panels() const { return last - first + 1; }
};
inline constexpr int nodes_per_panel = 12;
// The nodes of all panels [1/m].
std::vector<double> nodes_of(PanelRange range);

// Weights of what is read at places. Three integrals over k, with the circles' transform L(k) of which each adds to
// all,
//     sum L J0(k r)/k ... f: `displacement`,  L J0(k r) f: `mean`,  L J2(k r) cos(2 angle) f: `difference`,
// the angle being that of the place seen from the circle, against the x axis.
class Weights {
public:
    Weights(Circles circles, std::vector<Place> places) : circles_(std::move(circles)), places_(std::move(places)) {}

    bool serve(const Circles& circles, const std::vector<Place>& places) const {
        return circles == circles_ && places == places_;
    }
    const std::vector<Place>& places() const { return places_; }

    // Of each place, over the nodes of the range; 0 columns of mean and difference where only displacements are read.
    // Places x (nodes of one panel) a panel; panels once made are kept.
    struct Panel {
        Eigen::MatrixXd displacement, mean, difference; // nodes x places
    };
    const Panel& panel(PanelRange range, int number);
    // Of each place: the same integrals of f = 1.
    struct Constant {
        double displacement = 0.0, mean = 0.0, difference = 0.0;
    };
    const std::vector<Constant>& constants();

private:
    Panel make_panel(double from, double to) const;
    Circles circles_;
    std::vector<Place> places_;
    std::map<std::pair<bool, int>, Panel> panels_; // whether it begins at 0; log2 of its end
    std::vector<Constant> constants_;
};

} // namespace pave::layered
