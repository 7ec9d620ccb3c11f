#include "study/values.h"

#include "data/csv.h"
#include "pavement/tie.h"
#include "study/readings.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace explore::study {

using pave::pavement::Parameter;

namespace {

std::vector<std::string> names_of_axes(const problem::ParameterSpace& space) {
    std::vector<std::string> names;
    std::transform(space.axes.begin(), space.axes.end(), std::back_inserter(names),
                   [](const problem::Axis& axis) { return axis.name; });
    return names;
}

} // namespace

NamedValue named_value(std::string_view text, const pave::Place& place) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string_view::npos) {
        throw pave::Error(place, "a value is given by its name", "\"" + std::string(text) + "\"",
                          "NAME=VALUE, as base.k1=900");
    }
    const std::string name(data::trimmed(text.substr(0, equals)));
    pave::Place at = place;
    at.key += (at.key.empty() ? "" : " ") + name;
    return {name, data::finite_number(data::trimmed(text.substr(equals + 1)), at)};
}

std::vector<NamedValue> named_values(std::string_view text, const pave::Place& place) {
    std::vector<NamedValue> values;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        values.push_back(named_value(data::trimmed(text.substr(begin, end - begin)), place));
        begin = end + 1;
    }
    return values;
}

std::vector<std::string> names_of_numbers(const Study& study) {
    return study.has_own_model ? names_of_axes(study.space) : parameter_paths(study.model);
}

Parameter number_named(const Study& study, const std::string& name, const pave::Place& place) {
    if (!study.has_own_model) {
        return find_parameter(study.model, name, place);
    }
    const auto found = std::find_if(study.parameters.begin(), study.parameters.end(),
                                    [&](const Parameter& parameter) { return parameter.path == name; });
    if (found == study.parameters.end()) {
        const auto names = names_of_numbers(study);
        const std::string near = pave::nearest_name(name, names);
        throw pave::Error(place, "this parameter names nothing in the study", "\"" + name + "\"",
                          (near.empty() ? "" : "did you mean \"" + near + "\"? ") + "one of " + pave::join(names));
    }
    return *found;
}

std::vector<Parameter> changeable(Study& study, const std::vector<std::string>& names, const pave::Place& place) {
    std::vector<Parameter> parameters;
    std::set<std::string> seen;
    for (const std::string& name : names) {
        const Parameter parameter = number_named(study, name, place);
        if (!seen.insert(name).second) {
            throw pave::Error(place, "this number is given twice", "\"" + name + "\"", "each once");
        }
        for (const pave::pavement::Tie& tie : study.model.ties) {
            if (tie.path == name) {
                throw pave::Error(place, "this number follows others", "\"" + name + "\" = " + tie.expression.text(),
                                  pave::join(tie.expression.reads()));
            }
        }
        if (parameter.in_effect) {
            study.model.effects[static_cast<std::size_t>(parameter.owner)].present = true;
        } else if (parameter.in_correction) {
            study.model.corrections[static_cast<std::size_t>(parameter.owner)].present = true;
        }
        parameters.push_back(parameter);
    }
    return parameters;
}

ChangedStudy with_values(Study study, const std::vector<NamedValue>& values, const pave::Place& place) {
    std::vector<std::string> names;
    std::transform(values.begin(), values.end(), std::back_inserter(names), [](const auto& v) { return v.name; });
    const std::vector<Parameter> parameters = changeable(study, names, place);
    const auto set = [&](pave::pavement::Case& c, std::size_t i) {
        const Parameter& p = parameters[i];
        const double value = values[i].value;
        if (!((p.low_is_open ? value > p.low : value >= p.low) && value <= p.high)) {
            pave::Place at = place;
            at.key += (at.key.empty() ? "" : " ") + names[i];
            throw pave::Error(at, "value out of range", fmt::format("{}", value),
                              fmt::format("{} {} value <= {}", p.low, p.low_is_open ? "<" : "<=", p.high));
        }
        p.in(c) = value * p.to_si;
    };
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto axis = std::find_if(study.space.axes.begin(), study.space.axes.end(),
                                       [&](const problem::Axis& a) { return a.name == names[i]; });
        if (axis == study.space.axes.end()) {
            set(study.model, i);
        } else {
            axis->start = values[i].value;
        }
        study.hash += fmt::format("+{}={}", names[i], values[i].value);
    }
    settle_extent(study);
    ChangedStudy changed{std::move(study), {}};
    changed.at = changed.study.model;
    for (std::size_t i = 0; i < values.size(); ++i) {
        set(changed.at, i);
    }
    for (pave::pavement::Case* c : {&changed.study.model, &changed.at}) {
        if (const std::string wrong = apply_ties(*c); !wrong.empty()) {
            throw pave::Error(place, "a tied number is out of range", wrong, "values that keep it in range");
        }
    }
    return changed;
}

} // namespace explore::study
