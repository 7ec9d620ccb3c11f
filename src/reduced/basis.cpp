#include "reduced/basis.h"

#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace pave::reduced {

using namespace pavement;

std::string why_not(const Case& c, int load) {
    const Case own = with_effects(c, load);
    if (own.settings.integration != Integration::incremental) {
        return "the law is integrated as a secant";
    }
    const bool is_pulse = own.loads[static_cast<std::size_t>(load)].is_pulse();
    if (own.relaxes() && !is_pulse) {
        return "a layer relaxes";
    }
    if (own.turns()) {
        return "the anisotropy of a layer follows the stress";
    }
    if (own.has_energy()) {
        return own.is_hyperelastic() && !is_pulse
                   ? "the hyperelastic layers need no load path: the full model solves it at once"
                   : "a layer is hyperelastic";
    }
    if (std::none_of(own.layers.begin(), own.layers.end(), [](const Layer& l) { return l.law->stress_dependent(); })) {
        return "no layer depends on stress: the full model is as fast";
    }
    for (const Layer& layer : own.layers) {
        if (layer.compliance) {
            return "a layer may slip";
        }
        if (!layer.fields.empty()) {
            return "the stiffness varies within layer \"" + layer.name + "\"";
        }
    }
    if (own.loads[static_cast<std::size_t>(load)].plate_stiffness) {
        return "the plate is stiff";
    }
    if (own.loads[static_cast<std::size_t>(load)].inertia) {
        return "inertia is modelled";
    }
    return {};
}

bool reads_the_same(const std::vector<Sensor>& one, const std::vector<Sensor>& other) {
    return std::equal(one.begin(), one.end(), other.begin(), other.end(), [](Sensor a, const Sensor& b) {
        a.gain = b.gain;
        return a == b;
    });
}

Failure does_not_cover() {
    return {Status::failed, "the reduced model does not cover a change of geometry or of places that are read"};
}

namespace {

// A twentieth of the other readings; of what an instrument reads at other times, a quarter.
constexpr double share_of_others = 0.05;
constexpr double share_of_course = 0.25;

bool alike(const Case& c, int load, std::size_t i, std::size_t j) {
    return c.sensors[i].load == load && c.sensors[j].load == load && c.sensors[i].quantity == c.sensors[j].quantity;
}

bool is_of_one_place(const Sensor& one, const Sensor& other) {
    return one.x == other.x && one.y == other.y && one.depth == other.depth;
}

} // namespace

std::vector<double> scales(const Case& c, int load, const std::vector<double>& values) {
    std::vector<double> scale(values.size(), 1.0);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (c.sensors[i].load != load) {
            continue;
        }
        double largest = 0.0;
        double in_time = 0.0; // at its place
        for (std::size_t j = 0; j < values.size(); ++j) {
            if (alike(c, load, i, j)) {
                largest = std::max(largest, std::abs(values[j]));
                if (c.sensors[i].time && is_of_one_place(c.sensors[i], c.sensors[j])) {
                    in_time = std::max(in_time, std::abs(values[j]));
                }
            }
        }
        scale[i] = std::max({std::abs(values[i]), share_of_others * largest, share_of_course * in_time});
    }
    return scale;
}

namespace {

double quantity(const Basis::Coordinate& of, const std::vector<fe::LayerMaterial>& layers, const Load& load) {
    const auto& layer = layers[static_cast<std::size_t>(of.layer)];
    switch (of.kind) {
    case fe::Variation::Kind::law_parameter: return layer.parameters[of.index];
    case fe::Variation::Kind::unit_weight: return layer.unit_weight;
    case fe::Variation::Kind::k0: return layer.k0;
    case fe::Variation::Kind::residual_stress: return layer.residual_stress;
    default: return load.factor;
    }
}

} // namespace

double Basis::Coordinate::at(const std::vector<fe::LayerMaterial>& layers, const Load& load) const {
    const double value = quantity(*this, layers, load);
    return (2.0 * (logarithmic ? std::log(value) : value) - low - high) / (high - low);
}

double Basis::Coordinate::rate(const std::vector<fe::LayerMaterial>& layers, const Load& load) const {
    return 2.0 / (high - low) / (logarithmic ? quantity(*this, layers, load) : 1.0);
}

std::vector<Basis::Coordinate> coordinates_of(const std::vector<std::vector<fe::LayerMaterial>>& layers,
                                              const std::vector<Load>& loads) {
    using Kind = fe::Variation::Kind;
    std::vector<Basis::Coordinate> asked{{Kind::load_factor, 0, 0, false, 0.0, 0.0}};
    for (std::size_t l = 0; l < layers.front().size(); ++l) {
        const int layer = static_cast<int>(l);
        for (std::size_t p = 0; p < layers.front()[l].parameters.size(); ++p) {
            asked.push_back({Kind::law_parameter, layer, p, false, 0.0, 0.0});
        }
        for (const Kind kind : {Kind::unit_weight, Kind::k0, Kind::residual_stress}) {
            asked.push_back({kind, layer, 0, false, 0.0, 0.0});
        }
    }
    std::vector<Basis::Coordinate> vary;
    for (Basis::Coordinate& c : asked) {
        c.low = std::numeric_limits<double>::infinity();
        c.high = -c.low;
        for (std::size_t s = 0; s < layers.size(); ++s) {
            const double value = quantity(c, layers[s], loads[s]);
            c.low = std::min(c.low, value);
            c.high = std::max(c.high, value);
        }
        std::vector<double> values;
        for (std::size_t s = 0; s < layers.size(); ++s) {
            values.push_back(quantity(c, layers[s], loads[s]));
        }
        std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
        const double middle = values[values.size() / 2];
        const double geometric = std::sqrt(std::max(c.low, 0.0) * std::max(c.high, 0.0));
        c.logarithmic = middle * middle < geometric * (c.low + c.high) / 2.0; // else zero may be a value
        if (c.logarithmic) {
            c.low = std::log(c.low);
            c.high = std::log(c.high);
        }
        if (c.high > c.low) {
            vary.push_back(c);
        }
    }
    return vary;
}

std::vector<double> smooth_scales(const Case& c, int load, const std::vector<double>& values) {
    std::vector<double> scale(values.size(), 1.0);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (c.sensors[i].load != load) {
            continue;
        }
        double others = 0.0;
        for (std::size_t j = 0; j < values.size(); ++j) {
            others += alike(c, load, i, j) ? values[j] * values[j] : 0.0;
        }
        scale[i] = std::sqrt(values[i] * values[i] + share_of_others * share_of_others * others);
    }
    return scale;
}

std::vector<double> correct(const Basis& basis, const Case& values, int load,
                            const std::vector<fe::LayerMaterial>& layers, const std::vector<fe::Variation>& variations,
                            LoadModel::Reading& reading) {
    const Load& on = values.loads[static_cast<std::size_t>(load)];
    Eigen::VectorXd x(static_cast<Eigen::Index>(basis.coordinates.size()));
    for (Eigen::Index k = 0; k < x.size(); ++k) {
        x[k] = basis.coordinates[static_cast<std::size_t>(k)].at(layers, on);
    }
    const std::vector<double> scale = smooth_scales(values, load, reading.values);
    const std::vector<double> uncorrected = reading.values;
    const Eigen::MatrixXd slopes = reading.derivatives;
    std::vector<double> reaches(scale.size(), 1.0);
    for (std::size_t i = 0; i < scale.size(); ++i) {
        if (values.sensors[i].load != load) {
            continue;
        }
        const auto row = static_cast<Eigen::Index>(i);
        Eigen::VectorXd gradient;
        const double lack = basis.correction[i].at(x, variations.empty() ? nullptr : &gradient);
        reading.values[i] += scale[i] * lack;
        reading.errors[i] += std::abs(scale[i] * lack);
        reaches[i] = std::pow(basis.correction[i].reach(x), 2);
        if (!variations.empty()) {
            Eigen::RowVectorXd scale_rate = uncorrected[i] * slopes.row(row);
            for (std::size_t j = 0; j < scale.size(); ++j) {
                if (alike(values, load, i, j)) {
                    scale_rate +=
                        share_of_others * share_of_others * uncorrected[j] * slopes.row(static_cast<Eigen::Index>(j));
                }
            }
            reading.derivatives.row(row) += lack / scale[i] * scale_rate;
        }
        for (std::size_t k = 0; k < variations.size(); ++k) {
            for (std::size_t d = 0; d < basis.coordinates.size(); ++d) {
                const auto& c = basis.coordinates[d];
                const auto& v = variations[k];
                if (c.kind == v.kind && c.layer == v.layer && c.index == v.index) {
                    reading.derivatives(row, static_cast<Eigen::Index>(k)) +=
                        scale[i] * gradient[static_cast<Eigen::Index>(d)] * c.rate(layers, on);
                }
            }
        }
    }
    return reaches;
}

namespace {

// members() names every number of a basis once, for both ways.
template <class Archive, class T>
void members(Archive& archive, T& basis) {
    archive(basis.modes);
    archive(basis.coarse);
    archive(basis.points, [&](auto& point) {
        archive(point.gauss);
        archive(point.weight);
    });
    archive(basis.coordinates, [&](auto& c) {
        archive(c.kind);
        archive(c.layer);
        archive(c.index);
        archive(c.logarithmic);
        archive(c.low);
        archive(c.high);
    });
    archive(basis.correction, [&](auto& c) {
        archive(c.lengths);
        archive(c.places);
        archive(c.factors);
        archive(c.mean);
        archive(c.spacing);
    });
    archive(basis.factor, archive);
    archive(basis.floor, archive);
}

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class Writer {
public:
    template <Number T>
    void operator()(const T& number) {
        bytes_.append(reinterpret_cast<const char*>(&number), sizeof(T));
    }
    template <class M>
    void operator()(const Eigen::PlainObjectBase<M>& matrix) {
        (*this)(matrix.rows());
        (*this)(matrix.cols());
        bytes_.append(reinterpret_cast<const char*>(matrix.data()),
                      sizeof(double) * static_cast<std::size_t>(matrix.size()));
    }
    template <class T, class F>
    void operator()(const std::vector<T>& list, F&& each) {
        (*this)(list.size());
        for (const T& item : list) {
            each(item);
        }
    }
    std::string bytes_;
};

class Reader {
public:
    explicit Reader(const std::string& bytes) : bytes_(bytes) {}
    template <Number T>
    void operator()(T& number) {
        take(&number, sizeof(T));
    }
    template <class M>
    void operator()(Eigen::PlainObjectBase<M>& matrix) {
        Eigen::Index rows = 0;
        Eigen::Index cols = 0;
        (*this)(rows);
        (*this)(cols);
        const auto most = static_cast<Eigen::Index>(left() / sizeof(double));
        if (rows < 0 || cols < 0 || (M::ColsAtCompileTime == 1 && cols != 1) || (rows > 0 && cols > most / rows)) {
            valid_ = false;
            return;
        }
        matrix.resize(rows, cols);
        take(matrix.data(), sizeof(double) * static_cast<std::size_t>(matrix.size()));
    }
    template <class T, class F>
    void operator()(std::vector<T>& list, F&& each) {
        std::size_t size = 0;
        (*this)(size);
        valid_ = valid_ && size <= left();
        list.clear();
        for (std::size_t i = 0; valid_ && i < size; ++i) {
            each(list.emplace_back());
        }
    }
    // All of it was of a basis.
    bool ends() const { return valid_ && next_ == bytes_.size(); }

private:
    std::size_t left() const { return bytes_.size() - next_; }
    void take(void* to, std::size_t size) {
        valid_ = valid_ && size <= left();
        if (valid_) {
            std::memcpy(to, bytes_.data() + next_, size);
            next_ += size;
        }
    }

    const std::string& bytes_;
    std::size_t next_ = 0;
    bool valid_ = true;
};

} // namespace

std::string packed(const Basis& basis) {
    Writer writer;
    members(writer, basis);
    return std::move(writer.bytes_);
}

std::optional<Basis> unpacked(const std::string& bytes) {
    Reader reader(bytes);
    Basis basis;
    members(reader, basis);
    return reader.ends() ? std::optional(std::move(basis)) : std::nullopt;
}

} // namespace pave::reduced
