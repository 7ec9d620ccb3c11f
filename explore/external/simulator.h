// A model that is not ours: whatever gives numbers for numbers.
#pragma once

#include "base/outcome.h"

#include <Eigen/Dense>
#include <span>
#include <string>
#include <vector>

namespace explore::external {

// Any number of threads may ask at once.
class Simulator {
public:
    virtual ~Simulator() = default;

    // The responses at these values of all its parameters, each in the unit of its reading.
    virtual pave::Outcome<std::vector<double>> run(std::span<const double> values) const = 0;
    // Whether it offers derivatives. Of a server that does not answer it is not known: then jacobian() says why.
    virtual bool has_jacobian() const = 0;
    // d(response)/d(value), responses x parameters, where it offers them.
    virtual pave::Outcome<Eigen::MatrixXd> jacobian(std::span<const double> values) const = 0;

    // Bytes that another process makes the same from: make_simulator().
    virtual std::string description() const = 0;
    // Where folders of runs go that are to be kept; until then they stay where they ran.
    virtual void keep_in(const std::string& folder) const = 0;
    // How many were kept, and where, in words; "": none.
    virtual std::string kept_words() const = 0;
};

} // namespace explore::external
