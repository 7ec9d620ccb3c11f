// The box that is explored: named axes with bounds and a scale, and the map between it and the unit cube.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace explore::problem {

enum class Scale { linear, log };

// Prior knowledge of a parameter: normal on its scale.
struct Prior {
    double mean = 0.0; // physical; of a logarithmic axis the median
    double sd = 1.0;   // physical; of a logarithmic axis that of the natural logarithm
};

// Of many problems that are one, the stations of a road: what has one value of a parameter.
enum class Level { station, section, shared };

struct Axis {
    std::string name; // with its unit, as in the study
    double low = 0.0;
    double high = 1.0;
    Scale scale = Scale::linear;
    int points = 0;     // of a full grid; 0 = not stated, 1 = held at `start`
    double start = 0.0; // the study's own value
    std::optional<Prior> prior{};
    Level level = Level::station;

    double physical(double unit) const; // unit in [0, 1]; the ends are exact
    double unit(double physical) const;
    double d_physical(double unit) const; // d(physical)/d(unit)
    // How many standard deviations above the prior's mean; only with a prior.
    double pull(double physical) const;
    double d_pull() const; // d(pull)/d(unit)
};

// That the errors of two priors are correlated, each on the scale of its axis.
struct PriorCorrelation {
    std::string a, b; // names of axes
    double value = 0.0;
};

struct ParameterSpace {
    std::vector<Axis> axes;
    std::vector<PriorCorrelation> prior_correlations{}; // of the pairs that have one; positive definite

    int dimension() const { return static_cast<int>(axes.size()); }
    std::vector<double> physical(std::span<const double> unit) const;
    std::vector<double> unit(std::span<const double> physical) const;
};

} // namespace explore::problem
