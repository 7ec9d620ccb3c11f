#include "pavement/tie.h"

#include "base/text.h"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace pave::pavement {

std::vector<double> values_at(const Case& c, const std::vector<std::string>& paths) {
    std::vector<double> values;
    values.reserve(paths.size());
    for (const std::string& path : paths) {
        values.push_back(find_parameter(c, path, {}).get(c));
    }
    return values;
}

void add_tie(Case& c, const std::string& path, const std::string& expression, const Place& place) {
    find_parameter(c, path, place);
    const auto paths = parameter_paths(c);
    std::optional<Expression> read;
    try {
        read.emplace(expression, paths);
    } catch (const std::invalid_argument& error) {
        throw Error(place, std::string("this expression cannot be read: ") + error.what(), "\"" + expression + "\"",
                    "arithmetic of numbers and " + join(paths));
    }
    // References that the expression reads, through the ties that there are.
    std::vector<std::string> reached = read->reads();
    for (std::size_t i = 0; i < reached.size(); ++i) {
        for (const Tie& tie : c.ties) {
            if (tie.path == reached[i]) {
                reached.insert(reached.end(), tie.expression.reads().begin(), tie.expression.reads().end());
            }
        }
        if (reached[i] == path) {
            throw Error(place, "this expression reads the number it sets", fmt::format("\"{} = {}\"", path, expression),
                        "an expression of other numbers");
        }
    }
    std::vector<Tie> left = std::move(c.ties);
    left.push_back({path, std::move(*read)});
    c.ties.clear();
    while (!left.empty()) { // one after the other, each after those it reads; there is no circle
        const auto next = std::find_if(left.begin(), left.end(), [&](const Tie& tie) {
            const auto& reads = tie.expression.reads();
            return std::none_of(left.begin(), left.end(), [&](const Tie& other) {
                return std::find(reads.begin(), reads.end(), other.path) != reads.end();
            });
        });
        c.ties.push_back(std::move(*next));
        left.erase(next);
    }
}

std::string apply_ties(Case& c) {
    std::string wrong;
    for (const Tie& tie : c.ties) {
        const Parameter p = find_parameter(c, tie.path, {});
        const double value = tie.expression.value(values_at(c, tie.expression.reads()));
        if (wrong.empty() && !((p.low_is_open ? value > p.low : value >= p.low) && value <= p.high)) {
            wrong = fmt::format("{} = {} = {:g} is out of its range: {:g} {} value <= {:g}", tie.path,
                                tie.expression.text(), value, p.low, p.low_is_open ? "<" : "<=", p.high);
        }
        p.in(c) = value * p.to_si;
    }
    return wrong;
}

} // namespace pave::pavement
