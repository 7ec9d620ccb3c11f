#include "layered/response.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace pave::layered {
namespace {

template <class R>
struct Lift { // numbers of a section with their derivatives in some directions
    std::span<const std::vector<Layer>> rates;

    template <class Get>
    R operator()(std::size_t layer, const Layer& own, Get get) const {
        R number(get(own));
        if constexpr (!std::is_same_v<R, double>) {
            for (std::size_t i = 0; i < rates.size(); ++i) {
                number.d[static_cast<Eigen::Index>(i)] = get(rates[i][layer]);
            }
        }
        return number;
    }
};

template <class R>
std::vector<ColumnLayer<R>> column_layers(const Section& section, std::span<const std::vector<Layer>> rates) {
    const Lift<R> lift{rates};
    std::vector<ColumnLayer<R>> layers;
    for (std::size_t l = 0; l < section.layers.size(); ++l) {
        const auto stiffness = [&](int i, int j) {
            return lift(l, section.layers[l], [&](const Layer& layer) { return layer.stiffness(i, j); });
        };
        layers.push_back({{stiffness(0, 0), stiffness(0, 1), stiffness(0, 2), stiffness(2, 2), stiffness(3, 3)},
                          lift(l, section.layers[l], [](const Layer& layer) { return layer.thickness; }),
                          lift(l, section.layers[l], [](const Layer& layer) { return layer.compliance; })});
    }
    return layers;
}

// The panels that hold all of k that counts.
PanelRange range_of(const Column<double>& column, const std::vector<Level<double>>& levels) {
    constexpr double fallen = 27.0; // where exp(-fallen) times a square of it is 1e-9
    const auto& layers = column.layers();
    const std::size_t finite = layers.size() - (column.half_space() ? 1 : 0);
    double depth = 0.0;
    double stiffest = 0.0;
    double longest = 0.1; // over which the layers spread a load [m]
    for (std::size_t i = 0; i < finite; ++i) {
        depth += layers[i].thickness;
        stiffest = std::max(stiffest, layers[i].stiffness.c11);
        const double below = i + 1 < layers.size() ? layers[i + 1].stiffness.c44 : stiffest;
        longest = std::max(longest, depth * std::cbrt(std::max(1.0, stiffest / below)));
    }
    double shortest = 1e300; // over which exp(-1) is lost [m]
    double top = 0.0;
    double way = 0.0; // of decay down to the top of the layer
    std::size_t layer = 0;
    for (const Level<double>& level : levels) {
        for (; layer < static_cast<std::size_t>(level.layer); ++layer) {
            way += column.medium(static_cast<int>(layer)).slowest() * layers[layer].thickness;
            top += layers[layer].thickness;
        }
        longest = std::max(longest, top + level.below);
        const double slowest = column.medium(level.layer).slowest();
        if (!level.surface) {
            shortest = std::min(shortest, way + slowest * level.below);
        } else if (finite > 0) {
            shortest = std::min(shortest, 2.0 * slowest * layers.front().thickness);
        }
    }
    const double low = 0.5 / longest;
    const double high = std::max(shortest < 1e300 ? fallen / shortest : 0.0, 2.0 * low);
    return {static_cast<int>(std::floor(std::log2(low))), static_cast<int>(std::ceil(std::log2(high)))};
}

// The layer that holds a depth: on an interface the one below.
std::size_t layer_at(const Section& section, double depth) {
    double bottom = 0.0;
    std::size_t layer = 0;
    while (layer + 1 < section.layers.size() && depth >= (bottom += section.layers[layer].thickness) * (1.0 - 1e-12)) {
        ++layer;
    }
    return layer;
}

template <class R>
std::vector<Level<R>> levels_of(const std::vector<ColumnLayer<R>>& layers, const std::vector<double>& depths,
                                const std::vector<std::size_t>& layer) {
    std::vector<Level<R>> levels;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        R below(depths[i]);
        for (std::size_t l = 0; l < layer[i]; ++l) {
            below = below - layers[l].thickness;
        }
        if (value_of(below) < 0.0) { // by rounding
            below = below - value_of(below);
        }
        levels.push_back({static_cast<int>(layer[i]), below, depths[i] == 0.0});
    }
    return levels;
}

// The part of a number that answer number `a` holds: the value, or the derivative in direction a.
template <class R>
double part(const R& number, std::size_t a) {
    if constexpr (std::is_same_v<R, double>) {
        return number;
    } else {
        return number.d[static_cast<Eigen::Index>(a)];
    }
}

} // namespace

Transform::Transform(const Section& section, std::span<const std::vector<Layer>> rates,
                     const std::vector<double>& depths)
    : depths_(depths),
      rates_(rates.size()) {
    std::sort(depths_.begin(), depths_.end());
    depths_.erase(std::unique(depths_.begin(), depths_.end()), depths_.end());
    for (const double depth : depths_) {
        layer_.push_back(layer_at(section, depth));
        values_.stiffness.push_back(section.layers[layer_.back()].stiffness);
        for (std::size_t i = 0; i < rates.size(); ++i) {
            rates_[i].stiffness.push_back(rates[i][layer_.back()].stiffness);
        }
    }
    const auto layers = column_layers<double>(section, {});
    range_ = range_of(Column<double>(layers, section.half_space), levels_of(layers, depths_, layer_));
    run<double>(section, {}, {&values_, 1});
    constexpr std::size_t at_once = 4;
    for (std::size_t first = 0; first < rates.size(); first += at_once) {
        const std::size_t count = std::min(at_once, rates.size() - first);
        run<Dual<at_once>>(section, rates.subspan(first, count), std::span(rates_).subspan(first, count));
    }
}

template <class R>
void Transform::run(const Section& section, std::span<const std::vector<Layer>> rates,
                    std::span<Answer> answers) const {
    auto layers = column_layers<R>(section, rates);
    const auto levels = levels_of(layers, depths_, layer_);
    Column<R> column(std::move(layers), section.half_space);
    const Vector2<R> limit = column.surface_limit();
    const std::vector<double> nodes = nodes_of(range_);
    const auto count = static_cast<Eigen::Index>(nodes.size());
    for (std::size_t a = 0; a < answers.size(); ++a) {
        for (const Level<R>& level : levels) {
            Numbers& numbers = answers[a].numbers.emplace_back();
            numbers.u.resize(count);
            numbers.w.resize(count);
            numbers.s.resize(count);
            if (level.surface) {
                numbers.u_limit = part(limit.a1, a);
                numbers.w_limit = part(limit.a2, a);
                numbers.s_limit = part(R(1.0), a);
            }
        }
    }
    std::vector<State<R>> states(levels.size());
    for (Eigen::Index n = 0; n < count; ++n) {
        column.at(nodes[static_cast<std::size_t>(n)], levels, states.data());
        for (std::size_t a = 0; a < answers.size(); ++a) {
            for (std::size_t i = 0; i < levels.size(); ++i) {
                Numbers& numbers = answers[a].numbers[i];
                numbers.u[n] = part(states[i].u, a) - numbers.u_limit;
                numbers.w[n] = part(states[i].w, a) - numbers.w_limit;
                numbers.s[n] = part(states[i].s, a) - numbers.s_limit;
            }
        }
    }
}

std::size_t Transform::number_of(double depth) const {
    return static_cast<std::size_t>(std::lower_bound(depths_.begin(), depths_.end(), depth) - depths_.begin());
}

Transform::Sums Transform::sums(const Numbers& numbers, Weights& weights, std::size_t place) const {
    const Weights::Constant& constant = weights.constants()[place];
    const auto column = static_cast<Eigen::Index>(place);
    const bool strains = weights.places()[place].strains;
    Sums sums{constant.displacement * numbers.w_limit, constant.mean * numbers.u_limit,
              constant.difference * numbers.u_limit, constant.mean * numbers.s_limit};
    for (int p = 0; p < range_.panels(); ++p) {
        const Weights::Panel& panel = weights.panel(range_, p);
        const Eigen::Index first = static_cast<Eigen::Index>(p) * nodes_per_panel;
        sums.displacement += panel.displacement.col(column).dot(numbers.w.segment<nodes_per_panel>(first));
        if (strains) {
            sums.mean += panel.mean.col(column).dot(numbers.u.segment<nodes_per_panel>(first));
            sums.difference += panel.difference.col(column).dot(numbers.u.segment<nodes_per_panel>(first));
            sums.stress += panel.mean.col(column).dot(numbers.s.segment<nodes_per_panel>(first));
        }
    }
    return sums;
}

std::vector<Field> Transform::fields(Weights& weights, std::span<const Point> points) const {
    std::vector<Field> fields;
    for (const Point& point : points) {
        const std::size_t i = number_of(point.depth);
        const Sums sum = sums(values_.numbers[i], weights, point.place);
        const auto& c = values_.stiffness[i];
        Field f;
        f.uz = -sum.displacement;
        f.strain_xx = (sum.difference - sum.mean) / 2.0;
        f.strain_yy = -(sum.difference + sum.mean) / 2.0;
        f.stress_zz = -sum.stress;
        f.strain_zz = (f.stress_zz - c(0, 2) * (f.strain_xx + f.strain_yy)) / c(2, 2);
        f.stress_xx = c(0, 0) * f.strain_xx + c(0, 1) * f.strain_yy + c(0, 2) * f.strain_zz;
        f.stress_yy = c(0, 1) * f.strain_xx + c(0, 0) * f.strain_yy + c(0, 2) * f.strain_zz;
        fields.push_back(f);
    }
    return fields;
}

std::vector<Field> Transform::rates(Weights& weights, std::span<const Point> points, std::size_t direction) const {
    std::vector<Field> fields = this->fields(weights, points);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const std::size_t i = number_of(points[n].depth);
        const Answer& answer = rates_[direction];
        const Sums sum = sums(answer.numbers[i], weights, points[n].place);
        const auto& c = values_.stiffness[i];
        const auto& dc = answer.stiffness[i];
        const Field f = fields[n];
        Field& d = fields[n];
        d.uz = -sum.displacement;
        d.strain_xx = (sum.difference - sum.mean) / 2.0;
        d.strain_yy = -(sum.difference + sum.mean) / 2.0;
        d.stress_zz = -sum.stress;
        d.strain_zz = (d.stress_zz - c(0, 2) * (d.strain_xx + d.strain_yy) - dc(0, 2) * (f.strain_xx + f.strain_yy) -
                       dc(2, 2) * f.strain_zz) /
                      c(2, 2);
        const auto stress = [](const mechanics::Stiffness<6>& s, const Field& e, int own, int other) {
            return s(0, own) * e.strain_xx + s(0, other) * e.strain_yy + s(0, 2) * e.strain_zz;
        };
        d.stress_xx = stress(c, d, 0, 1) + stress(dc, f, 0, 1);
        d.stress_yy = stress(c, d, 1, 0) + stress(dc, f, 1, 0);
    }
    return fields;
}

} // namespace pave::layered
