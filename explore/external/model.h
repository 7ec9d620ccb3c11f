// The model of a study that is not ours, and functions of it for the explorer.
#pragma once

#include "external/differences.h"
#include "problem/forward_function.h"

#include <memory>
#include <mutex>

namespace explore::external {

// Shared by all functions of a study: its noise is estimated once.
class Model {
public:
    // Of all parameters of the study, then of the model's switches, which `switches` counts; to_si: of each response's
    // unit.
    Model(std::shared_ptr<const Simulator> simulator, problem::ParameterSpace space, std::vector<double> to_si,
          std::size_t switches = 0);

    const Simulator& simulator() const { return *simulator_; }
    const problem::ParameterSpace& space() const { return space_; }
    const std::vector<double>& to_si() const { return to_si_; }
    std::size_t switches() const { return switches_; }
    // Runs the model where that is not known yet; switches stand at their start.
    const Differences& differences() const;
    // How derivatives are made, in words; "" where the model offers them.
    std::string derivative_words() const;

private:
    std::shared_ptr<const Simulator> simulator_;
    problem::ParameterSpace space_;
    std::vector<double> to_si_;
    std::size_t switches_ = 0;
    mutable std::once_flag once_;
    mutable Differences differences_;
};

// Responses that are read times constant + slope size, whatever the model says: what instruments do.
struct Scaling {
    struct Row {
        std::size_t response = 0;
        double constant = 0.0, slope = 0.0;
    };
    std::vector<Row> rows;
    double size = 0.0;
};

// The responses [SI] as a function of these numbers: `which` counts the model's values first, then the sizes of the
// scalings. The others stand at `nominal` and at their own sizes.
std::shared_ptr<const problem::ForwardFunction> make_function(std::shared_ptr<const Model> model,
                                                              std::vector<double> nominal,
                                                              std::vector<Scaling> scalings,
                                                              std::vector<std::size_t> which);
// The same from its description(). Throws nlohmann::json::exception for bytes that are none.
std::shared_ptr<const problem::ForwardFunction> function_of(const std::string& description);
bool is_description(const std::string& bytes);

} // namespace explore::external
