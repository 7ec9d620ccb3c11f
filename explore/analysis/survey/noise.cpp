#include "analysis/survey/noise.h"

#include "base/error.h"
#include "base/text.h"
#include "data/deflection_bowl.h"
#include "data/resolution.h"
#include "inference/quantiles.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace explore::analysis {
namespace {

using data::RepeatedDrops;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int parts = NoiseModel::parts;
using NoiseParts = std::array<double, parts>; // 0: not there

// The covariance of a drop of such a group, and its derivatives by the logarithms of the parts that are there.
struct Covariance {
    MatrixXd c;
    std::array<MatrixXd, parts> by;

    Covariance(const RepeatedDrops& group, const NoiseParts& p) {
        const auto n = static_cast<Index>(group.offsets_mm.size());
        VectorXd own(n);
        VectorXd by_relative(n);
        VectorXd by_absolute(n);
        MatrixXd r = MatrixXd::Identity(n, n);
        MatrixXd by_length = MatrixXd::Zero(n, n);
        for (Index i = 0; i < n; ++i) {
            const double absolute = p[NoiseModel::absolute] / group.deflections_um[static_cast<std::size_t>(i)];
            own[i] = std::hypot(p[NoiseModel::relative], absolute);
            by_relative[i] = p[NoiseModel::relative] * p[NoiseModel::relative] / own[i];
            by_absolute[i] = absolute * absolute / own[i];
            for (Index j = 0; j < n && p[NoiseModel::correlation] > 0.0; ++j) {
                const double apart = std::abs(group.offsets_mm[static_cast<std::size_t>(i)] -
                                              group.offsets_mm[static_cast<std::size_t>(j)]) /
                                     p[NoiseModel::correlation];
                r(i, j) = std::exp(-apart);
                by_length(i, j) = apart * r(i, j);
            }
        }
        const auto product = [&](const VectorXd& a, const VectorXd& b, const MatrixXd& m) -> MatrixXd {
            return a.asDiagonal() * m * b.asDiagonal();
        };
        const double common = p[NoiseModel::common] * p[NoiseModel::common];
        c = product(own, own, r).array() + common;
        by[NoiseModel::relative] = product(by_relative, own, r) + product(own, by_relative, r);
        by[NoiseModel::common] = MatrixXd::Constant(n, n, 2.0 * common);
        by[NoiseModel::absolute] = product(by_absolute, own, r) + product(own, by_absolute, r);
        by[NoiseModel::correlation] = product(own, own, by_length);
    }
};

// Bounds of the parts.
constexpr NoiseParts lowest = {1e-5, 1e-5, 1e-3, 1.0};
constexpr NoiseParts highest = {0.5, 0.5, 100.0, 1e5};

struct Fit {
    NoiseParts p{};
    double score = INFINITY; // -2 ln likelihood, but for a constant
    MatrixXd information{};  // on the logarithms of the parts that are there
    std::vector<int> there{};
};

// Nothing where the covariance of a group is not positive definite.
std::optional<double> score_of(const std::vector<RepeatedDrops>& groups, const NoiseParts& p) {
    double sum = 0.0;
    for (const RepeatedDrops& group : groups) {
        const Eigen::LLT<MatrixXd> c(Covariance(group, p).c);
        if (c.info() != Eigen::Success) {
            return std::nullopt;
        }
        sum += 2.0 * (group.drops - 1) * c.matrixLLT().diagonal().array().log().sum() + c.solve(group.scatter).trace();
    }
    return sum;
}

Fit fit(const std::vector<RepeatedDrops>& groups, const NoiseParts& start) {
    Fit f{.p = start};
    for (int k = 0; k < parts; ++k) {
        if (start[static_cast<std::size_t>(k)] > 0.0) {
            f.there.push_back(k);
        }
    }
    const auto count = static_cast<Index>(f.there.size());
    f.score = score_of(groups, f.p).value_or(INFINITY);
    constexpr int most_rounds = 200;
    double damping = 1e-3;
    for (int round = 0; round < most_rounds; ++round) {
        VectorXd slope = VectorXd::Zero(count); // of half the score, downwards
        f.information = MatrixXd::Zero(count, count);
        for (const RepeatedDrops& group : groups) {
            const Covariance model(group, f.p);
            const Eigen::LLT<MatrixXd> c(model.c);
            const MatrixXd excess =
                c.solve(group.scatter) - (group.drops - 1) * MatrixXd::Identity(model.c.rows(), model.c.cols());
            std::vector<MatrixXd> by;
            for (const int k : f.there) {
                by.emplace_back(c.solve(model.by[static_cast<std::size_t>(k)]));
            }
            for (Index a = 0; a < count; ++a) {
                const MatrixXd& own = by[static_cast<std::size_t>(a)];
                slope[a] += 0.5 * own.cwiseProduct(excess.transpose()).sum();
                for (Index b = 0; b < count; ++b) {
                    f.information(a, b) +=
                        0.5 * (group.drops - 1) * own.cwiseProduct(by[static_cast<std::size_t>(b)].transpose()).sum();
                }
            }
        }
        bool moved = false;
        double gain = 0.0;
        for (; damping < 1e6 && !moved; damping *= 10.0) {
            MatrixXd damped = f.information;
            damped.diagonal() *= 1.0 + damping;
            damped.diagonal().array() += 1e-9;
            const VectorXd step = damped.ldlt().solve(slope);
            NoiseParts there = f.p;
            for (Index a = 0; a < count; ++a) {
                const auto k = static_cast<std::size_t>(f.there[static_cast<std::size_t>(a)]);
                there[k] = std::clamp(f.p[k] * std::exp(std::clamp(step[a], -1.0, 1.0)), lowest[k], highest[k]);
            }
            if (const auto score = score_of(groups, there); score && *score < f.score) {
                gain = f.score - *score;
                f.p = there;
                f.score = *score;
                moved = true;
            }
        }
        damping = std::max(1e-6, damping / 100.0);
        if (!moved || gain < 1e-8) {
            break;
        }
    }
    return f;
}

// The best of several starts; the parts that are 0 in `there` stay away.
Fit best_fit(const std::vector<RepeatedDrops>& groups, const std::array<bool, parts>& there) {
    Fit best;
    for (const double length_mm : {100.0, 400.0, 1500.0}) {
        NoiseParts start = {0.01, 0.005, 1.0, length_mm};
        for (std::size_t k = 0; k < parts; ++k) {
            start[k] = there[k] ? start[k] : 0.0;
        }
        if (Fit f = fit(groups, start); f.score < best.score) {
            best = std::move(f);
        }
        if (!there[NoiseModel::correlation]) {
            break; // all starts are one
        }
    }
    return best;
}

NoiseModel model_of(const std::vector<RepeatedDrops>& groups) {
    constexpr double telling = 2.71;
    std::array<bool, parts> there = {true, true, true, true};
    Fit best = best_fit(groups, there);
    for (;;) {
        std::optional<Fit> simpler;
        std::size_t without = 0;
        for (std::size_t k = 0; k < parts; ++k) {
            const bool is_last = k != NoiseModel::absolute && k != NoiseModel::relative
                                     ? false
                                     : !(there[NoiseModel::absolute] && there[NoiseModel::relative]);
            if (!there[k] || is_last) {
                continue;
            }
            auto fewer = there;
            fewer[k] = false;
            if (Fit f = best_fit(groups, fewer);
                f.score - best.score < telling && (!simpler || f.score < simpler->score)) {
                simpler = std::move(f);
                without = k;
            }
        }
        if (!simpler) {
            break;
        }
        there[without] = false;
        best = std::move(*simpler);
    }
    NoiseModel model;
    MatrixXd information = best.information;
    information.diagonal().array() += 1e-9;
    const MatrixXd covariance = information.inverse();
    for (std::size_t a = 0; a < best.there.size(); ++a) {
        const auto k = static_cast<std::size_t>(best.there[a]);
        const double width =
            inference::two_sided_95 * std::sqrt(covariance(static_cast<Index>(a), static_cast<Index>(a)));
        model.value[k] = best.p[k];
        model.low[k] = best.p[k] * std::exp(-width);
        model.high[k] = best.p[k] * std::exp(width);
    }
    return model;
}

// Sums over the groups that have both sensors.
struct Pair {
    double drops = 0.0, model = 0.0;
    int degrees = 0;
};

std::vector<SensorNoise> sensors_of(const std::vector<RepeatedDrops>& groups, const NoiseModel& model) {
    NoiseParts p{};
    std::copy(std::begin(model.value), std::end(model.value), p.begin());
    std::map<std::pair<double, double>, Pair> pairs;
    std::map<double, std::vector<double>> deflections;
    for (const RepeatedDrops& group : groups) {
        const MatrixXd c = Covariance(group, p).c;
        for (std::size_t i = 0; i < group.offsets_mm.size(); ++i) {
            deflections[group.offsets_mm[i]].push_back(group.deflections_um[i]);
            for (std::size_t j = 0; j < group.offsets_mm.size(); ++j) {
                Pair& pair = pairs[{group.offsets_mm[i], group.offsets_mm[j]}];
                pair.drops += group.scatter(static_cast<Index>(i), static_cast<Index>(j));
                pair.model += (group.drops - 1) * c(static_cast<Index>(i), static_cast<Index>(j));
                pair.degrees += group.drops - 1;
            }
        }
    }
    std::vector<SensorNoise> sensors;
    for (const auto& [offset, all] : deflections) {
        const Pair& own = pairs.at({offset, offset});
        sensors.push_back({.offset_mm = offset,
                           .deflection_um = data::median(all),
                           .degrees = own.degrees,
                           .scatter = std::sqrt(own.drops / own.degrees),
                           .scatter_of_model = std::sqrt(own.model / own.degrees)});
    }
    const auto correlate = [&](double a, double b, std::optional<double>& drops, std::optional<double>& of_model) {
        const auto both = pairs.find({a, b});
        const Pair& first = pairs.at({a, a});
        const Pair& second = pairs.at({b, b});
        if (both != pairs.end() && first.drops > 0.0 && second.drops > 0.0) {
            const auto root = [](double x, double y) { return std::sqrt(x * y); };
            const double degrees = root(first.degrees, second.degrees) / both->second.degrees;
            drops = degrees * both->second.drops / root(first.drops, second.drops);
            of_model = degrees * both->second.model / root(first.model, second.model);
        }
    };
    for (std::size_t i = 0; i < sensors.size(); ++i) {
        SensorNoise& s = sensors[i];
        if (i + 1 < sensors.size()) {
            correlate(s.offset_mm, sensors[i + 1].offset_mm, s.with_next, s.with_next_of_model);
        }
        if (i > 0) {
            correlate(sensors[0].offset_mm, s.offset_mm, s.with_first, s.with_first_of_model);
        }
    }
    return sensors;
}

} // namespace

double NoiseResult::stated_absolute_um() const {
    if (resolution_um <= data::fine_um) {
        return model.value[NoiseModel::absolute];
    }
    // It does not fall with the number of drops, as what is said of one drop does.
    const double drops_of_group = static_cast<double>(drops) / static_cast<double>(groups);
    return std::hypot(model.value[NoiseModel::absolute], resolution_um * std::sqrt(drops_of_group / 12.0));
}

NoiseResult noise_of_drops(const std::vector<data::FwdFile>& files) {
    NoiseResult result;
    std::vector<RepeatedDrops> groups;
    std::string names;
    for (const data::FwdFile& file : files) {
        auto list = data::repeated_drops(file.stations, result.left_out);
        std::move(list.begin(), list.end(), std::back_inserter(groups));
        result.stations += file.stations.size();
        std::vector<const data::FwdStation*> stations;
        for (const data::FwdStation& station : file.stations) {
            stations.push_back(&station);
        }
        result.resolution_um = std::max(result.resolution_um, data::resolution_um(stations));
        names += (names.empty() ? "" : ", ") + file.stations[0].file;
    }
    // Repeats that agree to the last digit say nothing: a reading has been copied.
    std::erase_if(groups, [](const RepeatedDrops& g) { return g.scatter.isZero(0.0); });
    if (groups.empty()) {
        throw pave::Error({.file = names}, "no drop is repeated, so its noise cannot be estimated", {},
                          "two or more drops of one station within 10 % of one pressure");
    }
    result.groups = groups.size();
    for (const RepeatedDrops& group : groups) {
        result.drops += group.drops;
        result.degrees += group.drops - 1;
    }
    result.model = model_of(groups);
    result.sensors = sensors_of(groups, result.model);
    return result;
}

std::vector<std::string> findings(const NoiseResult& result) {
    std::vector<std::string> text;
    const double* value = result.model.value;
    const double largest =
        std::max_element(result.sensors.begin(), result.sensors.end(), [](const auto& a, const auto& b) {
            return a.scatter < b.scatter;
        })->scatter;
    text.push_back(fmt::format("Repeated drops agree within {:.2g} % (one standard deviation) at the worst sensor.",
                               100.0 * largest));
    if (value[NoiseModel::common] > 0.0 || value[NoiseModel::correlation] > 0.0) {
        text.push_back(fmt::format("Errors are not independent: {}. A fit that takes them so gives ranges too narrow "
                                   "for some parameters and too wide for others.",
                                   value[NoiseModel::common] == 0.0 ? "neighbouring sensors share theirs"
                                   : value[NoiseModel::correlation] == 0.0
                                       ? "all sensors of a drop share one"
                                       : "all sensors of a drop share one, neighbouring ones more"));
    } else {
        text.push_back("Nothing tells the errors of the sensors from independent ones.");
    }
    if (const double absolute = result.stated_absolute_um(); absolute > value[NoiseModel::absolute]) {
        text.push_back(fmt::format(
            "Readings are {}: rounding alone is an error of {:.2g} um (one standard deviation), which repeats that "
            "round to one digit do not show and more drops do not lessen. It is in the absolute part for the study, "
            "{:.2g} um.",
            data::resolution_words(result.resolution_um), result.resolution_um / std::sqrt(12.0), absolute));
    }
    if (!result.left_out.empty()) {
        constexpr std::size_t shown = 3;
        const std::size_t more = result.left_out.size() - std::min(shown, result.left_out.size());
        text.push_back(
            fmt::format("Left out, as repeats contradict them: {}{}.",
                        pave::join(std::vector<std::string>(result.left_out.begin(),
                                                            result.left_out.end() - static_cast<std::ptrdiff_t>(more)),
                                   "; "),
                        more > 0 ? fmt::format("; and {} more", more) : ""));
    }
    // Of the drops over that of the model; twice is beyond what so many repeats may be off by chance.
    constexpr double misses = 2.0;
    constexpr int enough = 12;
    std::vector<std::string> missed;
    for (const SensorNoise& s : result.sensors) {
        const double ratio = s.scatter_of_model / s.scatter;
        if (s.degrees >= enough && (ratio > misses || ratio < 1.0 / misses)) {
            missed.push_back(fmt::format("{:g} mm ({:.2g} % for {:.2g} %)", s.offset_mm, 100.0 * s.scatter_of_model,
                                         100.0 * s.scatter));
        }
    }
    if (!missed.empty()) {
        text.push_back(fmt::format("The model does not hold at {}: its scatter is off by more than a factor of two "
                                   "there. State sigma of that sensor's readings, or leave it out.",
                                   pave::join(missed)));
    }
    constexpr int few = 30;
    if (result.degrees < few) {
        text.push_back(fmt::format("Only {}: see how wide the ranges are; more drops at a station narrow them.",
                                   pave::counted(static_cast<std::size_t>(result.degrees), "repeat", "repeats")));
    }
    text.push_back("Repeats do not show what stays the same from drop to drop: calibration, places of sensors, the "
                   "model. of_drops = 1 says that this is the noise of one drop: `survey` and `road` then take it "
                   "for the mean of as many drops as a station has (all but correlation_mm over their root).");
    return text;
}

} // namespace explore::analysis
