// A smooth function between points where it is known, with an estimate of its error.
#pragma once

#include <Eigen/Dense>
#include <span>
#include <vector>

namespace explore::inference {

struct KnownPoint {
    std::vector<double> unit; // in the unit cube
    Eigen::VectorXd values;
    Eigen::MatrixXd slopes{}; // values x coordinates, by unit coordinates; empty: not known
};

// A polynomial of second degree (of first, or a constant, where there are few points) by least squares, and Gaussian
// processes that make it go through all values and slopes: Rasmussen and Williams 2006, Gaussian Processes for Machine
// Learning, sections 2.2 and 9.4 (slopes). The correlation is exp(-sum (h_j / l_j)^2 / 2), with lengths l that all
// values share, from a grid, by their likelihood.
class Kriging {
public:
    // All of one number of coordinates and values; at least one.
    explicit Kriging(std::vector<KnownPoint> known);

    struct Answer {
        Eigen::VectorXd values;
        Eigen::VectorXd deviations; // standard deviations of the values, by the process
        Eigen::MatrixXd slopes;     // values x coordinates, by unit coordinates; empty unless requested
    };
    Answer at(std::span<const double> unit, bool with_slopes) const;

    const std::vector<KnownPoint>& known() const { return known_; }
    // The largest less the smallest of the known values.
    Eigen::VectorXd ranges() const;
    // The squared distance of two points in units of the lengths.
    double squared_distance(std::span<const double> a, std::span<const double> b) const;

private:
    Eigen::MatrixXd correlations(std::size_t points) const;
    bool factorise(std::size_t points, const Eigen::MatrixXd& rest);
    void choose_lengths();

    std::vector<KnownPoint> known_;
    Eigen::Index rows_of_point_ = 1; // its value, and its slopes where they are known
    int degree_ = 0;
    Eigen::MatrixXd trend_; // terms x values
    Eigen::MatrixXd rest_;  // rows x values: what the trend leaves
    Eigen::VectorXd lengths_;
    Eigen::LLT<Eigen::MatrixXd> factor_;
    Eigen::MatrixXd weights_; // rows x values
    Eigen::VectorXd scales_;  // standard deviations of the processes
    double likelihood_ = 0.0;
};

} // namespace explore::inference
