#include "study/constraints.h"

#include "base/error.h"
#include "base/random.h"
#include "pavement/tie.h"
#include "study/values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace explore::study {
namespace {

using namespace pave::pavement;

// The references of a side of a condition, found once.
struct Reads {
    struct Output {
        std::size_t reading = 0;
        double to_si = 1.0;
    };
    std::vector<std::optional<Parameter>> numbers; // none: an output
    std::vector<Output> outputs;

    Reads(const Study& study, const pave::Expression& side) {
        for (const std::string& name : side.reads()) {
            const auto all = study.outputs();
            const auto output =
                std::find_if(all.begin(), all.end(), [&](std::size_t i) { return study.readings[i].output == name; });
            numbers.push_back(output == all.end() ? std::optional(number_named(study, name, {})) : std::nullopt);
            outputs.push_back(output == all.end() ? Output{} : Output{*output, study.readings[*output].unit.to_si});
        }
    }
    std::vector<double> values(const Case& c, std::span<const double> responses) const {
        std::vector<double> list;
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const std::size_t r = outputs[i].reading;
            list.push_back(numbers[i]             ? numbers[i]->get(c)
                           : r < responses.size() ? responses[r] / outputs[i].to_si
                                                  : std::numeric_limits<double>::quiet_NaN());
        }
        return list;
    }
};

// The case at physical values of its parameters, in range or not.
Case case_of(const Case& nominal, const std::vector<Parameter>& parameters, std::span<const double> values) {
    Case c = nominal;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
        parameters[k].in(c) = values[k] * parameters[k].to_si;
    }
    apply_ties(c);
    return c;
}

// LEFT - RIGHT, the other way round for >=.
class Condition final : public problem::Limit {
public:
    Condition(const Study& study, const Constraint& constraint)
        : constraint_(constraint),
          left_(study, constraint.left),
          right_(study, constraint.right),
          nominal_(study.model),
          parameters_(study.parameters) {}

    std::string text() const override { return constraint_.text; }
    bool is_equality() const override { return constraint_.relation == Constraint::Relation::equal; }

    double value(std::span<const double> parameters, std::span<const double> responses) const override {
        return difference(at(parameters), responses) / constraint_.tolerance;
    }

    Eigen::RowVectorXd gradient(std::span<const double> parameters, std::span<const double> responses,
                                const Eigen::MatrixXd& jacobian) const override {
        Eigen::RowVectorXd result = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(parameters.size()));
        constexpr double share = 1e-5; // of a value: fourth-order differences of closed forms, to some 1e-11
        const auto slope = [](const auto& f, double step) {
            return (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step);
        };
        std::vector<double> moved(parameters.begin(), parameters.end());
        for (std::size_t k = 0; k < moved.size(); ++k) {
            const double value = moved[k];
            const auto by_parameter = [&](double offset) {
                moved[k] = value + offset;
                return difference(at(moved), responses);
            };
            result[static_cast<Eigen::Index>(k)] = slope(by_parameter, share * std::max(std::abs(value), 1e-3));
            moved[k] = value;
        }
        const Case here = at(parameters);
        std::vector<double> changed(responses.begin(), responses.end());
        for (const Reads* side : {&left_, &right_}) {
            for (std::size_t i = 0; i < side->numbers.size(); ++i) {
                const std::size_t r = side->outputs[i].reading;
                const bool is_first = side == &left_ || !reads_output(left_, r);
                if (side->numbers[i] || !is_first || r >= responses.size()) {
                    continue;
                }
                const auto by_response = [&](double offset) {
                    changed[r] = responses[r] + offset;
                    return difference(here, changed);
                };
                const double rate = slope(by_response, share * std::max(std::abs(responses[r]), 1e-9));
                changed[r] = responses[r];
                result += rate * jacobian.row(static_cast<Eigen::Index>(r));
            }
        }
        return result / constraint_.tolerance;
    }

private:
    static bool reads_output(const Reads& side, std::size_t reading) {
        for (std::size_t i = 0; i < side.numbers.size(); ++i) {
            if (!side.numbers[i] && side.outputs[i].reading == reading) {
                return true;
            }
        }
        return false;
    }
    Case at(std::span<const double> parameters) const { return case_of(nominal_, parameters_, parameters); }
    double difference(const Case& c, std::span<const double> responses) const {
        const double d =
            constraint_.left.value(left_.values(c, responses)) - constraint_.right.value(right_.values(c, responses));
        return constraint_.relation == Constraint::Relation::at_least ? -d : d;
    }

    Constraint constraint_;
    Reads left_, right_;
    Case nominal_;
    std::vector<Parameter> parameters_;
};

} // namespace

Constraint read_constraint(const Study& study, const std::string& text, const pave::Place& place) {
    constexpr std::array<std::pair<std::string_view, Constraint::Relation>, 3> relations{
        {{"<=", Constraint::Relation::at_most},
         {">=", Constraint::Relation::at_least},
         {"==", Constraint::Relation::equal}}};
    std::size_t count = 0;
    std::size_t at = 0;
    Constraint::Relation relation{};
    for (const auto& [word, means] : relations) {
        for (std::size_t i = text.find(word); i != std::string::npos; i = text.find(word, i + 1)) {
            ++count;
            at = i;
            relation = means;
        }
    }
    if (count != 1) {
        throw pave::Error(place, "a constraint compares two sides", "\"" + text + "\"",
                          "one of <=, >= and == between them");
    }
    std::vector<std::string> names = names_of_numbers(study);
    for (const std::size_t i : study.outputs()) {
        names.push_back(study.readings[i].output);
    }
    const auto side = [&](const std::string& of) {
        try {
            return pave::Expression(of, names);
        } catch (const std::invalid_argument& error) {
            throw pave::Error(place, std::string("a side of this constraint cannot be read: ") + error.what(),
                              "\"" + of + "\"", "arithmetic of numbers and " + pave::join(names));
        }
    };
    Constraint constraint{.text = text,
                          .left = side(text.substr(0, at)),
                          .right = side(text.substr(at + 2)),
                          .relation = relation,
                          .line = place.line};
    for (const auto* const own : {&constraint.left, &constraint.right}) {
        for (const std::string& name : own->reads()) {
            if (std::count(names.begin(), names.end(), name) > 1) {
                throw pave::Error(place, "this name stands for two things, an output among them", "\"" + name + "\"",
                                  "names of [[outputs]] that nothing else has");
            }
        }
    }
    // How far the sides differ over the box: where outputs are read, by the size of what has a value without them.
    constexpr std::uint64_t points = 200;
    const pave::RandomStream random(0, 0);
    double largest = 0.0;
    double side_alone = 0.0;
    std::uint64_t next = 0;
    const Reads left(study, constraint.left);
    const Reads right(study, constraint.right);
    for (std::uint64_t i = 0; i < points; ++i) {
        std::vector<double> unit(study.parameters.size());
        std::generate(unit.begin(), unit.end(), [&] { return random.uniform(next++); });
        const Case c = case_of(study.model, study.parameters, study.space.physical(unit));
        const double l = constraint.left.value(left.values(c, {}));
        const double r = constraint.right.value(right.values(c, {}));
        largest = std::isfinite(l - r) ? std::max(largest, std::abs(l - r)) : largest;
        for (const double s : {l, r}) {
            side_alone = std::isfinite(s) ? std::max(side_alone, std::abs(s)) : side_alone;
        }
    }
    const double size = largest > 0.0 ? largest : side_alone > 0.0 ? side_alone : 1.0;
    constexpr double share = 1e-4;
    constraint.tolerance = share * size;
    return constraint;
}

std::vector<std::shared_ptr<const problem::Limit>> limits_of(const Study& study) {
    std::vector<std::shared_ptr<const problem::Limit>> limits;
    for (const Constraint& constraint : study.constraints) {
        limits.push_back(std::make_shared<Condition>(study, constraint));
    }
    return limits;
}

std::vector<bool> constrained_loads(const Study& study) {
    std::vector<bool> loads(study.model.loads.size(), false);
    for (const Constraint& constraint : study.constraints) {
        for (const auto* side : {&constraint.left, &constraint.right}) {
            const Reads reads(study, *side);
            for (std::size_t i = 0; i < reads.numbers.size(); ++i) {
                if (!reads.numbers[i]) {
                    loads[static_cast<std::size_t>(study.model.sensors[reads.outputs[i].reading].load)] = true;
                }
            }
        }
    }
    return loads;
}

} // namespace explore::study
