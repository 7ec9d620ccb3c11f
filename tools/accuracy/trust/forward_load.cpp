// The forward model at random points of a box twice as wide as any real pavement needs: how the runs end, what the
// slowest costs, whether what converged is in equilibrium and its energy balances, whether the answer is smooth in the
// parameters.
//
// Balances are worked out from the fields alone. With a virtual displacement that is 1 above a row of elements, 0 below
// and linear in it, the vertical stress over the row carries the load; with the displacement itself, the work of the
// load is that of the stress on the strain. Both hold exactly for a discrete equilibrium.
// usage: forward_load [--points 20000] [--solid 500] [--lines 100] [--seed 1]
// exit status 1: a bound is not kept
#include "base/random.h"
#include "pavement/fields.h"
#include "pavement/forward.h"
#include "run/blas.h"
#include "run/parallel.h"
#include "run/progress.h"
#include "study/study.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <numbers>
#include <oneapi/tbb.h>

namespace {

using namespace pave::pavement;

// Twice as wide, by the logarithm where log says so, as: k1 300 to 12000, k2 0 to 1, k3 -2 to 0, n 0.1 to 1, asphalt
// 300 to 15000 MPa, subgrade 20 to 300 MPa.
struct Range {
    const char* path;
    double low, high;
    bool log;
};
constexpr Range realistic[] = {{"base.k1", 300, 12000, true},
                               {"base.k2", 0, 1, false},
                               {"base.k3", -2, 0, false},
                               {"base.n", 0.1, 1.0, true},
                               {"asphalt.modulus_MPa", 300, 15000, true},
                               {"subgrade.modulus_MPa", 20, 300, true}};

// The value at u of [0, 1] of the range made `times` as wide about its middle.
double at(const Range& range, double u, double times) {
    const double low = range.log ? std::log(range.low) : range.low;
    const double high = range.log ? std::log(range.high) : range.high;
    const double value = (low + high) / 2 + (u - 0.5) * times * (high - low);
    return range.log ? std::exp(value) : value;
}

// Point i of the box of unit length.
std::vector<double> drawn(std::uint64_t seed, std::size_t i) {
    const pave::RandomStream random(seed, i);
    std::vector<double> unit;
    for (std::size_t k = 0; k < std::size(realistic); ++k) {
        unit.push_back(random.uniform(k));
    }
    return unit;
}

struct Setting {
    explicit Setting(const std::string& file) : study(explore::study::load_study(file)), model(study.model) {
        for (const Range& range : realistic) {
            parameters.push_back(find_parameter(study.model, range.path, {}));
        }
    }
    Case values(const std::vector<double>& unit, double times) const {
        Case c = study.model;
        for (std::size_t k = 0; k < parameters.size(); ++k) {
            parameters[k].in(c) = parameters[k].to_si * at(realistic[k], unit[k], times);
        }
        return c;
    }
    explore::study::Study study;
    ForwardModel model;
    std::vector<Parameter> parameters;
};

double cpu_seconds() {
    return 1e-9 * static_cast<double>(explore::run::thread_cpu_ns());
}

// An element as a box: its corners among its nodes, and values inside by their linear interpolation.
class Box {
public:
    Box(const Fields& f, int element) : first_(static_cast<Eigen::Index>(element) * f.nodes) {
        const auto nodes = f.position.middleCols(first_, f.nodes);
        low = nodes.rowwise().minCoeff();
        high = nodes.rowwise().maxCoeff();
        flat_ = f.nodes == 8; // no extent in y
        for (int corner = 0; corner < corners(); ++corner) {
            Eigen::Index nearest = 0;
            (nodes.colwise() - point(corner & 1, (corner >> 1) & 1, corner >> 2))
                .colwise()
                .squaredNorm()
                .minCoeff(&nearest);
            node_[corner] = first_ + nearest;
        }
    }
    // s, t, v in [0, 1] along x, z, y.
    Eigen::Vector3d point(double s, double t, double v) const {
        return {low[0] + s * (high[0] - low[0]), low[1] + v * (high[1] - low[1]), low[2] + t * (high[2] - low[2])};
    }
    auto value(const auto& columns, double s, double t, double v) const {
        Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
        for (int c = 0; c < corners(); ++c) {
            const double weight = ((c & 1) != 0 ? s : 1 - s) * ((c >> 1 & 1) != 0 ? t : 1 - t) *
                                  (flat_           ? 1.0
                                   : (c >> 2) != 0 ? v
                                                   : 1 - v);
            sum += weight * columns.col(node_[c]);
        }
        return sum;
    }
    // Volume, or its share of the full circle.
    double measure(double s) const {
        const double area = (high[0] - low[0]) * (high[2] - low[2]);
        return flat_ ? area * 2.0 * std::numbers::pi * point(s, 0, 0)[0] : area * (high[1] - low[1]);
    }
    bool flat() const { return flat_; }
    Eigen::Index first() const { return first_; }

    Eigen::Vector3d low, high;

private:
    int corners() const { return flat_ ? 4 : 8; }
    Eigen::Index first_;
    bool flat_ = false;
    Eigen::Index node_[8] = {};
};

constexpr double gauss_2[] = {0.21132486540518713, 0.7886751345948129};
constexpr double gauss_3[] = {0.1127016653792583, 0.5, 0.8872983346207417};
constexpr double weight_3[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};

// The downward displacement on the top face of an element, by its quadratic shape functions.
double settlement(const Fields& f, const Box& box, double s, double v) {
    // One-dimensional Lagrange functions for the half plane; the serendipity face of eight nodes in three dimensions.
    double sum = 0.0;
    for (int i = 0; i < f.nodes; ++i) {
        const Eigen::Index node = box.first() + i;
        if (f.position(2, node) > box.low[2] + 1e-9) {
            continue;
        }
        const double a = 2 * (f.position(0, node) - box.low[0]) / (box.high[0] - box.low[0]) - 1;
        const double x = 2 * s - 1;
        double shape = 0.0;
        if (box.flat()) {
            shape = std::abs(a) < 0.5 ? 1 - x * x : x * (x + a) / 2;
        } else {
            const double b = 2 * (f.position(1, node) - box.low[1]) / (box.high[1] - box.low[1]) - 1;
            const double y = 2 * v - 1;
            shape = std::abs(a) < 0.5   ? (1 - x * x) * (1 + b * y) / 2
                    : std::abs(b) < 0.5 ? (1 + a * x) * (1 - y * y) / 2
                                        : (1 + a * x) * (1 + b * y) * (a * x + b * y - 1) / 4;
        }
        sum += shape * f.displacement(2, node);
    }
    return sum;
}

struct Balance {
    double force = 0.0;  // largest over the rows: |carried / load - 1|
    double energy = 0.0; // |work of stress on strain / work of the load - 1|
};

Balance balance_of(const Fields& f, const Load& load) {
    const bool flat = f.nodes == 8;
    const double total =
        load.type == LoadType::plate ? load.pressure * std::numbers::pi * load.radius * load.radius : load.force;
    const double share = flat ? 1.0 : 0.25; // what is modelled of it
    // The patch of the positive quarter, where the load is not a circle about the axis.
    const double wheels = load.type == LoadType::dual_wheel ? 2.0 : 1.0;
    const double width = load.patch_width;
    const double length = flat ? 0.0 : load.force / wheels / load.pressure / width;
    const double centre = load.type == LoadType::dual_wheel ? load.spacing / 2 : 0.0;
    const double edge = load.radius;
    std::map<double, double> rows; // by top
    double of_stress = 0.0;
    double of_load = 0.0;
    for (int e = 0; e < static_cast<int>(f.layer.size()); ++e) {
        const Box box(f, e);
        for (const double s : gauss_2) {
            for (const double t : gauss_2) {
                for (const double v : gauss_2) {
                    const double dv = box.measure(s) / 8; // of the flat ones every point appears twice
                    const auto stress = box.value(f.stress, s, t, v);
                    rows[std::round(box.low[2] * 1e9)] -= stress[2] * dv / (box.high[2] - box.low[2]);
                    of_stress += stress.dot(box.value(f.strain, s, t, v)) * dv;
                }
            }
        }
        if (box.low[2] > 1e-9) {
            continue;
        }
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                const Eigen::Vector3d p = box.point(gauss_3[i], 0, gauss_3[j]);
                const bool loaded = flat ? p[0] < edge : std::abs(p[0] - centre) < width / 2 && p[1] < length / 2;
                const double da =
                    (box.high[0] - box.low[0]) * (flat ? 2 * std::numbers::pi * p[0] : box.high[1] - box.low[1]);
                of_load +=
                    loaded ? load.pressure * settlement(f, box, gauss_3[i], gauss_3[j]) * weight_3[i] * weight_3[j] * da
                           : 0.0;
            }
        }
    }
    Balance b;
    for (const auto& [top, force] : rows) {
        b.force = std::max(b.force, std::abs(force / (share * total) - 1));
    }
    b.energy = std::abs(of_stress / of_load - 1);
    return b;
}

struct Point {
    pave::Status status = pave::Status::failed;
    std::string reason;
    double seconds = 0.0;
    int steps = 0;
    Balance balance;
    bool finite = true;
};

double median(std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
}

int complaints = 0;

void bound(const char* what, double found, double allowed) {
    const bool kept = found <= allowed;
    complaints += kept ? 0 : 1;
    fmt::print("  {:<58} {:>10.3g}   allowed {:g}{}\n", what, found, allowed, kept ? "" : "   NOT KEPT");
}

void random_points(const Setting& setting, int count, std::uint64_t seed, const char* title) {
    std::vector<Point> points(static_cast<std::size_t>(count));
    tbb::enumerable_thread_specific<ForwardModel::WorkspacePointer> workspaces(
        [&] { return setting.model.make_workspace(); });
    explore::run::Progress progress(title, count);
    tbb::task_arena arena(explore::run::usable_threads(0));
    explore::run::for_each_index(arena, points.size(), [&](std::size_t i) {
        const Case values = setting.values(drawn(seed, i), 2.0);
        Point& p = points[i];
        const double begin = cpu_seconds();
        const auto response = setting.model.run(values, {}, *workspaces.local());
        p.seconds = cpu_seconds() - begin;
        if (!response) {
            p.status = response.failure().status;
            p.reason = response.failure().reason;
        } else {
            p.status = pave::Status::converged;
            p.steps = response->statistics.factorizations;
            p.finite = std::all_of(response->values.begin(), response->values.end(),
                                   [](double v) { return std::isfinite(v); });
            if (const auto fields = setting.model.fields(values, 0)) {
                p.balance = balance_of(*fields, values.loads[0]);
            } else {
                p.balance = {INFINITY, INFINITY};
            }
        }
        progress.add(1, true);
    });
    std::map<std::string_view, int> statuses;
    std::map<std::string, std::vector<std::size_t>> reasons; // and the points
    std::vector<double> seconds;
    std::vector<double> steps;
    double slowest = 0.0, most = 0.0, force = 0.0, energy = 0.0;
    int without_reason = 0, not_finite = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& p = points[i];
        ++statuses[to_string(p.status)];
        without_reason += p.status != pave::Status::converged && p.reason.empty() ? 1 : 0;
        not_finite += p.finite ? 0 : 1;
        seconds.push_back(p.seconds);
        slowest = std::max(slowest, p.seconds);
        if (p.status == pave::Status::converged) {
            steps.push_back(p.steps);
            most = std::max<double>(most, p.steps);
            force = std::max(force, p.balance.force);
            energy = std::max(energy, p.balance.energy);
        } else {
            reasons[p.reason.substr(0, p.reason.find_first_of("0123456789"))].push_back(i);
        }
    }
    fmt::print("{}: {} points,", title, count);
    for (const auto& [status, n] : statuses) {
        fmt::print(" {} {}", n, status);
    }
    fmt::print("\n");
    for (const auto& [reason, of] : reasons) {
        fmt::print("  {} x {}...\n    as at", of.size(), reason);
        const std::vector<double> unit = drawn(seed, of.front());
        for (std::size_t k = 0; k < unit.size(); ++k) {
            fmt::print(" {} = {:.6g}", realistic[k].path, at(realistic[k], unit[k], 2.0));
        }
        fmt::print("\n");
    }
    fmt::print("  CPU seconds of a run: median {:.3g}, slowest {:.3g}, {:.1f} times the median\n", median(seconds),
               slowest, slowest / median(seconds));
    bound("most over median number of matrices", most / median(steps), 10);
    bound("runs that failed: a possible material has an answer", statuses[to_string(pave::Status::failed)], 0);
    bound("runs without an answer that do not say why", without_reason, 0);
    bound("answers that are not numbers", not_finite, 0);
    bound("load carried through every row of elements, relative", force, 1e-5);
    bound("work of stress on strain against work of the load", energy, 1e-5);
}

// Along lines through the box, at close points, each response against the cubic through the values and slopes beside
// it.
void random_lines(const Setting& setting, int lines, std::uint64_t seed) {
    constexpr int steps = 24;
    constexpr double length = 0.025; // of the box: at twice that curvature alone is 1e-5
    std::vector<double> worst(static_cast<std::size_t>(lines), 0.0);
    tbb::enumerable_thread_specific<ForwardModel::WorkspacePointer> workspaces(
        [&] { return setting.model.make_workspace(); });
    explore::run::Progress progress("lines", lines);
    tbb::task_arena arena(explore::run::usable_threads(0));
    explore::run::for_each_index(arena, worst.size(), [&](std::size_t l) {
        const pave::RandomStream random(seed, 1'000'000ULL + l);
        std::vector<double> from, to;
        double norm = 0.0;
        for (std::size_t k = 0; k < std::size(realistic); ++k) {
            from.push_back(random.uniform(k));
            to.push_back(random.normal(100 + k));
            norm += to[k] * to[k];
        }
        std::vector<std::vector<double>> answers;
        for (int i = 0; i <= steps; ++i) {
            std::vector<double> unit = from;
            for (std::size_t k = 0; k < unit.size(); ++k) {
                unit[k] += length * i / steps * to[k] / std::sqrt(norm);
            }
            const auto response = setting.model.run(setting.values(unit, 2.0), {}, *workspaces.local());
            answers.push_back(response ? response->values : std::vector<double>{});
        }
        // Of five points in a row the middle one against the cubic through the others.
        for (int i = 2; i + 2 <= steps; ++i) {
            const auto* a = &answers[static_cast<std::size_t>(i)];
            if (a[-2].empty() || a[-1].empty() || a[0].empty() || a[1].empty() || a[2].empty()) {
                continue;
            }
            double largest = 0.0;
            for (const double v : a[0]) {
                largest = std::max(largest, std::abs(v));
            }
            for (std::size_t r = 0; r < a[0].size(); ++r) {
                const double smooth = (4 * (a[-1][r] + a[1][r]) - (a[-2][r] + a[2][r])) / 6;
                worst[l] = std::max(worst[l], std::abs(a[0][r] - smooth) / largest);
            }
        }
        progress.add(1, true);
    });
    fmt::print("lines: {} of {} points\n", lines, steps + 1);
    fmt::print("  median jump over the largest response: {:.3g}\n", median(worst));
    bound("largest jump over the largest response", *std::max_element(worst.begin(), worst.end()), 1e-5);
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app{"The forward model at random points"};
    int points = 20000, solid = 500, lines = 100;
    std::uint64_t seed = 1;
    app.add_option("--points", points);
    app.add_option("--solid", solid);
    app.add_option("--lines", lines);
    app.add_option("--seed", seed);
    CLI11_PARSE(app, argc, argv);
    explore::run::prepare_blas();
    const Setting plane("grids/captif-p1-fwd.toml");
    if (points > 0) {
        random_points(plane, points, seed, "axisymmetric");
    }
    if (lines > 0) {
        random_lines(plane, lines, seed);
    }
    if (solid > 0) {
        random_points(Setting("grids/dual-nonlinear.toml"), solid, seed, "three dimensions");
    }
    return complaints == 0 ? 0 : 1;
}
