// A model as the explorer sees it: a function from a vector of parameters to a vector of responses, with its
// derivatives and its status. It does not know that finite elements exist.
#pragma once

#include "base/outcome.h"

#include <Eigen/Dense>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace explore::problem {

struct Prediction {
    std::vector<double> responses;
    Eigen::MatrixXd jacobian; // responses x parameters, empty unless requested
    std::vector<std::string> warnings;
    bool in_place_of_reduced = false; // by the full model, where a reduced one could not answer
};

// Must be pure: the same parameters give the same bits on any thread, whatever was computed before.
class ForwardFunction {
public:
    virtual ~ForwardFunction() = default;

    // The memory of a thread between calls.
    class Workspace {
    public:
        virtual ~Workspace() = default;
    };
    virtual std::unique_ptr<Workspace> make_workspace() const = 0;

    // parameters: physical values in the order of the parameter space. Throws nothing but std::bad_alloc.
    virtual pave::Outcome<Prediction> evaluate(std::span<const double> parameters, bool with_jacobian,
                                               Workspace& workspace) const = 0;

    // Bytes that another process of the same build makes the same function from; empty: it cannot travel.
    virtual std::string description() const { return {}; }

    // evaluate() at several points, in their order. The bits of an answer depend on its own point alone, not on those
    // beside it, but need not be those of evaluate(): what computes many points at once rounds in another order.
    // Whoever keeps evaluations makes each of them in one way, always.
    virtual std::vector<pave::Outcome<Prediction>> evaluate_many(std::span<const std::vector<double>> points,
                                                                 bool with_jacobian, Workspace& workspace) const {
        std::vector<pave::Outcome<Prediction>> answers;
        for (const auto& point : points) {
            answers.push_back(evaluate(point, with_jacobian, workspace));
        }
        return answers;
    }
    // How many points evaluate_many() computes for about the price of one.
    virtual std::size_t lanes() const { return 1; }
};

} // namespace explore::problem
