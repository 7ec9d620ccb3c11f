#include "layered/circles.h"

#include "base/gauss_legendre.h"

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

namespace pave::layered {
namespace {

using Rule = std::vector<std::pair<double, double>>;

const Rule& node_rule() {
    static const Rule rule = gauss_legendre(nodes_per_panel);
    return rule;
}

// Ends of panel `number` of a range.
std::pair<double, double> ends_of(PanelRange range, int number) {
    const double to = std::ldexp(1.0, range.first + number);
    return {number == 0 ? 0.0 : to / 2.0, to};
}

// The values at x in [-1, 1] of the polynomials that are 1 at one node and 0 at the others: sums of Legendre
// polynomials, sum over n of (2 n + 1)/2 w_j P_n(x_j) P_n(x).
std::array<double, nodes_per_panel> interpolating(double x) {
    constexpr int n = nodes_per_panel;
    const auto legendre = [](double at) {
        std::array<double, n> p{1.0, at};
        for (std::size_t i = 2; i < n; ++i) {
            const auto order = static_cast<double>(i);
            p[i] = ((2.0 * order - 1.0) * at * p[i - 1] - (order - 1.0) * p[i - 2]) / order;
        }
        return p;
    };
    static const auto coefficients = [&] {
        std::array<std::array<double, n>, n> c{};
        for (std::size_t j = 0; j < n; ++j) {
            const auto p = legendre(node_rule()[j].first);
            for (std::size_t i = 0; i < n; ++i) {
                c[j][i] = (2.0 * static_cast<double>(i) + 1.0) / 2.0 * node_rule()[j].second * p[i];
            }
        }
        return c;
    }();
    const auto p = legendre(x);
    std::array<double, n> values{};
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = 0; i < n; ++i) {
            values[j] += coefficients[j][i] * p[i];
        }
    }
    return values;
}

// J1 - shape J3
double loading(double x, double shape) {
    return ::j1(x) - (shape != 0.0 ? shape * ::jn(3, x) : 0.0);
}

// 2/pi times the complete elliptic integrals of parameter m.
struct Elliptic {
    double k, e;
};
Elliptic elliptic(double m) {
    const double modulus = std::sqrt(m);
    // K is infinite at 1, where it is only met with a factor 0.
    return {m < 1.0 ? 2.0 / std::numbers::pi * std::comp_ellint_1(modulus) : 0.0,
            2.0 / std::numbers::pi * std::comp_ellint_2(modulus)};
}

// Integrals of (J1(x) - shape J3(x)) J0(x r)/x, (...) J0(x r) and (...) J2(x r) from 0 to infinity; r over the radius.
Weights::Constant unit_circle(double r, double shape) {
    Weights::Constant c;
    const double m = r <= 1.0 ? r * r : 1.0 / (r * r);
    const auto [k, e] = elliptic(m);
    if (r <= 1.0) {
        c.displacement = e - shape * ((7.0 - 8.0 * m) * e - 4.0 * (1.0 - m) * k) / 9.0;
    } else {
        c.displacement = r * (e - (1.0 - m) * k) +
                         shape / (48.0 * std::pow(m, 1.5)) *
                             ((128.0 - 112.0 * m) / 3.0 * e - (128.0 - 176.0 * m + 48.0 * m * m) / 3.0 * k);
    }
    if (r == 1.0) { // the mean of both sides
        c.mean = (1.0 + shape) / 2.0;
        c.difference = (1.0 - shape) / 2.0;
    } else if (r < 1.0) {
        c.mean = 1.0 + shape * (2.0 * r * r - 1.0);
        c.difference = -shape * r * r;
    } else {
        c.difference = 1.0 / (r * r);
    }
    return c;
}

struct Seen { // a place from a circle
    double distance, cos2;
};
Seen seen(const Place& place, const Circle& circle) {
    const double x = place.x - circle.x;
    const double y = place.y - circle.y;
    const double square = x * x + y * y;
    return {std::sqrt(square), square > 0.0 ? (x * x - y * y) / square : 1.0};
}

// The integrand over a panel, of one place at one node of a fine rule, times the rule's weight.
struct Sample {
    double mean = 0.0, difference = 0.0;
};

Weights::Panel empty_panel(Eigen::Index places) {
    Weights::Panel panel;
    for (Eigen::MatrixXd* weights : {&panel.displacement, &panel.mean, &panel.difference}) {
        weights->setZero(nodes_per_panel, places);
    }
    return panel;
}

void add(Weights::Panel& panel, Eigen::Index place, bool strains, double k,
         const std::array<double, nodes_per_panel>& polynomials, const Sample& sample) {
    const auto at_nodes = Eigen::Map<const Eigen::Matrix<double, nodes_per_panel, 1>>(polynomials.data());
    panel.displacement.col(place) += (sample.mean / k) * at_nodes;
    if (strains) {
        panel.mean.col(place) += sample.mean * at_nodes;
        panel.difference.col(place) += sample.difference * at_nodes;
    }
}

// Few oscillations: Gauss's rule in pieces.
Weights::Panel by_pieces(const Circles& circles, const std::vector<Place>& places, double from, double to, int pieces) {
    Weights::Panel panel = empty_panel(static_cast<Eigen::Index>(places.size()));
    static const Rule fine = gauss_legendre(24);
    const double half = (to - from) / (2.0 * pieces);
    for (int piece = 0; piece < pieces; ++piece) {
        for (const auto& [x, weight] : fine) {
            const double k = from + half * (2.0 * piece + 1.0 + x);
            const auto polynomials = interpolating((2.0 * piece + 1.0 + x) / pieces - 1.0);
            std::vector<Sample> samples(places.size());
            double radius = 0.0;
            double load = 0.0;
            for (const Circle& circle : circles.circles) {
                if (circle.radius != radius) {
                    radius = circle.radius;
                    load = half * weight * radius * loading(k * radius, circles.shape);
                }
                for (std::size_t i = 0; i < places.size(); ++i) {
                    const auto [distance, cos2] = seen(places[i], circle);
                    const double kr = k * distance;
                    const double j0 = ::j0(kr);
                    samples[i].mean += load * j0;
                    if (places[i].strains && kr > 0.0) {
                        samples[i].difference += load * cos2 * (2.0 * ::j1(kr) / kr - j0);
                    }
                }
            }
            for (std::size_t i = 0; i < places.size(); ++i) {
                add(panel, static_cast<Eigen::Index>(i), places[i].strains, k, polynomials, samples[i]);
            }
        }
    }
    return panel;
}

using Complex = std::complex<double>;

// h(t) of the Bessel function J(t) = Re(h(t) exp(i t)) of an order, by Hankel's expansion: to rounding from t = 25.
constexpr double hankel_from = 25.0;
Complex hankel(int order, double t) {
    Complex term = 1.0;
    Complex sum = 1.0;
    for (int n = 1; n < 30 && std::abs(term) > 1e-17; ++n) {
        term *= Complex(0.0, (4.0 * order * order - (2.0 * n - 1.0) * (2.0 * n - 1.0)) / (8.0 * n * t));
        sum += term;
    }
    return std::sqrt(2.0 / (std::numbers::pi * t)) * std::polar(1.0, -(order / 2.0 + 0.25) * std::numbers::pi) * sum;
}

constexpr int filon_nodes = 64;

// Spherical Bessel functions of orders below filon_nodes.
std::array<double, filon_nodes> spherical_bessel(double x) {
    constexpr int n = filon_nodes;
    std::array<double, n> j{};
    x = std::abs(x);
    if (x < 1e-8) {
        j[0] = 1.0;
        return j;
    }
    const double first = std::sin(x) / x;
    if (x > n) { // upwards
        j[0] = first;
        j[1] = (first - std::cos(x)) / x;
        for (std::size_t i = 2; i < n; ++i) {
            j[i] = (2.0 * static_cast<double>(i) - 1.0) / x * j[i - 1] - j[i - 2];
        }
        return j;
    }
    double above = 0.0; // downwards, scaled as it goes
    double here = 1e-290;
    for (int i = 2 * n + 40; i-- > 0;) {
        const double below = (2.0 * i + 3.0) / x * here - above;
        above = here;
        here = below;
        if (i < n) {
            j[static_cast<std::size_t>(i)] = here;
        }
        if (std::abs(here) > 1e200) {
            for (double& value : j) {
                value *= 1e-250;
            }
            here *= 1e-250;
            above *= 1e-250;
        }
    }
    // Scaled by the larger of the first two, which are never small together.
    const double second = (first - std::cos(x)) / x;
    const double scale = std::abs(first) > std::abs(second) ? first / j[0] : second / j[1];
    for (double& value : j) {
        value *= scale;
    }
    return j;
}

struct FilonRule {
    Rule gauss = gauss_legendre(filon_nodes);
    Eigen::MatrixXd legendre{filon_nodes, filon_nodes}; // (node, order): weight times (2 order + 1) P(node)
    std::vector<std::array<double, nodes_per_panel>> polynomials;

    FilonRule() {
        for (Eigen::Index f = 0; f < filon_nodes; ++f) {
            const auto [x, weight] = gauss[static_cast<std::size_t>(f)];
            double before = 0.0;
            double p = 1.0;
            for (Eigen::Index n = 0; n < filon_nodes; ++n) {
                const auto order = static_cast<double>(n);
                legendre(f, n) = weight * (2.0 * order + 1.0) * p;
                const double next = ((2.0 * order + 1.0) * x * p - order * before) / (order + 1.0);
                before = p;
                p = next;
            }
            polynomials.push_back(interpolating(x));
        }
    }

    // Weights that integrate a smooth function times exp(i frequency x) over [-1, 1].
    Eigen::VectorXcd weights(double frequency) const {
        const auto j = spherical_bessel(frequency);
        Eigen::VectorXd even = Eigen::VectorXd::Zero(filon_nodes);
        Eigen::VectorXd odd = Eigen::VectorXd::Zero(filon_nodes);
        for (std::size_t n = 0; n < filon_nodes; ++n) { // i^n
            const double sign = n % 4 < 2 ? 1.0 : -1.0;
            const bool turns = n % 2 == 1;
            (turns ? odd : even)[static_cast<Eigen::Index>(n)] = sign * (turns && frequency < 0.0 ? -j[n] : j[n]);
        }
        Eigen::VectorXcd result(filon_nodes);
        result.real() = legendre * even;
        result.imag() = legendre * odd;
        return result;
    }
};

// A factor of the integrand over a panel: Re(amplitude exp(i k frequency)), the amplitude smooth.
struct Wave {
    double frequency = 0.0;
    Eigen::VectorXcd amplitude;
    bool oscillates() const { return frequency > 0.0; }
};

// Bessel functions of `length` k at the nodes k, summed with these factors.
Wave wave_of(const Eigen::VectorXd& k, double length, std::initializer_list<std::pair<int, double>> orders) {
    Wave wave;
    wave.frequency = k.minCoeff() * length > hankel_from ? length : 0.0;
    wave.amplitude.setZero(k.size());
    for (Eigen::Index f = 0; f < k.size(); ++f) {
        for (const auto& [order, factor] : orders) {
            const double t = k[f] * length;
            wave.amplitude[f] += factor * (wave.oscillates() ? hankel(order, t) : Complex(::jn(order, t)));
        }
    }
    return wave;
}

// Many oscillations: the rule of L. N. G. Filon (1928), with Gauss's nodes.
Weights::Panel by_filon(const Circles& circles, const std::vector<Place>& places, double from, double to) {
    static const FilonRule rule;
    const double middle = (from + to) / 2.0;
    const double half = (to - from) / 2.0;
    Eigen::VectorXd k(filon_nodes);
    for (Eigen::Index f = 0; f < filon_nodes; ++f) {
        k[f] = middle + half * rule.gauss[static_cast<std::size_t>(f)].first;
    }
    // The weights of the rule for the product of two waves at each node.
    const auto product = [&](const Wave& a, const Wave& b) {
        const auto one = [&](double frequency, const Eigen::VectorXcd& amplitude) {
            const Complex phase = half * std::polar(1.0, middle * frequency);
            return Eigen::VectorXd((phase * rule.weights(half * frequency).cwiseProduct(amplitude)).real());
        };
        const Eigen::VectorXcd together = a.amplitude.cwiseProduct(b.amplitude);
        if (a.oscillates() && b.oscillates()) {
            return Eigen::VectorXd(0.5 *
                                   (one(a.frequency + b.frequency, together) +
                                    one(a.frequency - b.frequency, a.amplitude.cwiseProduct(b.amplitude.conjugate()))));
        }
        return one(a.frequency + b.frequency, together);
    };
    Weights::Panel panel = empty_panel(static_cast<Eigen::Index>(places.size()));
    for (const Circle& circle : circles.circles) {
        Wave load = wave_of(k, circle.radius, {{1, 1.0}, {3, -circles.shape}});
        load.amplitude *= circle.radius;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const auto [distance, cos2] = seen(places[i], circle);
            const Eigen::VectorXd mean = product(load, wave_of(k, distance, {{0, 1.0}}));
            const Eigen::VectorXd difference = places[i].strains
                                                   ? Eigen::VectorXd(product(load, wave_of(k, distance, {{2, cos2}})))
                                                   : Eigen::VectorXd::Zero(filon_nodes);
            for (Eigen::Index f = 0; f < filon_nodes; ++f) {
                add(panel, static_cast<Eigen::Index>(i), places[i].strains, k[f],
                    rule.polynomials[static_cast<std::size_t>(f)], {mean[f], difference[f]});
            }
        }
    }
    return panel;
}

} // namespace

std::vector<double> nodes_of(PanelRange range) {
    std::vector<double> nodes;
    for (int p = 0; p < range.panels(); ++p) {
        const auto [from, to] = ends_of(range, p);
        for (const auto& [x, weight] : node_rule()) {
            nodes.push_back(from + (to - from) / 2.0 * (1.0 + x));
        }
    }
    return nodes;
}

const Weights::Panel& Weights::panel(PanelRange range, int number) {
    const auto [from, to] = ends_of(range, number);
    const std::pair<bool, int> key{number == 0, range.first + number};
    auto found = panels_.find(key);
    if (found == panels_.end()) {
        found = panels_.emplace(key, make_panel(from, to)).first;
    }
    return found->second;
}

Weights::Panel Weights::make_panel(double from, double to) const {
    constexpr double phase = 20.0; // of the Bessel functions over one piece
    constexpr int most_pieces = 10;
    double farthest = 0.0;
    for (const Circle& circle : circles_.circles) {
        for (const Place& place : places_) {
            farthest = std::max(farthest, seen(place, circle).distance + circle.radius);
        }
    }
    const int pieces = static_cast<int>(std::min(1e6, 1.0 + (to - from) * farthest / phase));
    return pieces <= most_pieces || from == 0.0 ? by_pieces(circles_, places_, from, to, pieces)
                                                : by_filon(circles_, places_, from, to);
}

const std::vector<Weights::Constant>& Weights::constants() {
    if (constants_.empty()) {
        for (const Place& place : places_) {
            Constant sum;
            for (const Circle& circle : circles_.circles) {
                const auto [distance, cos2] = seen(place, circle);
                const Constant one = unit_circle(distance / circle.radius, circles_.shape);
                sum.displacement += circle.radius * one.displacement;
                sum.mean += one.mean;
                sum.difference += cos2 * one.difference;
            }
            constants_.push_back(sum);
        }
    }
    return constants_;
}

} // namespace pave::layered
