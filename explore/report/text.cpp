#include "report/text.h"

#include "base/text.h"
#include "base/units.h"
#include "pavement/effects/effect.h"
#include "report/json.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {

using pave::figure;

std::string study_summary(const study::Study& study) {
    std::string text = pave::printable(study.title) + "\n  ";
    for (const auto& layer : study.model.layers) {
        text += fmt::format("{} {:g} mm ({}) / ", layer.name, layer.thickness / pave::unit::mm, layer.law->name());
    }
    text += study.has_own_model ? "a model of its own\n" : study.model.half_space ? "half-space\n" : "rigid floor\n";
    for (const auto& applied : study.model.effects) {
        text += fmt::format("  with {} = {:g} [{}]\n", applied.effect->name, applied.size, applied.effect->unit);
    }
    if (study.noise_assumed > 0) {
        text += fmt::format("  {} of {} state no standard deviation and take the median share of those that do\n",
                            study.noise_assumed, pave::counted(study.measured().size(), "reading", "readings"));
    }
    return text;
}

std::string readings_summary(const study::Study& study) {
    using pave::counted;
    std::string text = study_summary(study);
    if (study.measured().empty()) {
        text += "  no readings: nothing can be fitted\n";
    } else {
        text += fmt::format("  {}, noise {}:\n", counted(study.measured().size(), "reading", "readings"),
                            study.noise == study::NoiseSource::stated ? study.noise_name()
                                                                      : "to be estimated from the fit");
        for (const auto& group : study.groups) {
            text += fmt::format("    {}: {}{}\n", group.name, group.rows.size(),
                                group.held_out        ? ", held out"
                                : group.weight != 1.0 ? fmt::format(", weight {:g}", group.weight)
                                                      : "");
        }
    }
    return text + fmt::format("  {}\n", counted(study.outputs().size(), "output", "outputs"));
}

std::string response_table(const study::Study& study, const std::vector<double>& responses,
                           const std::map<std::size_t, double>& weights) {
    std::vector<std::string> header{"load",     study.has_own_model ? "reading" : "quantity",
                                    "x mm",     "y mm",
                                    "depth mm", "gauge mm",
                                    "measured", "model",
                                    "unit",     "difference"};
    const bool has_times = data::has_times(study.readings);
    if (has_times) {
        header.insert(header.begin() + 6, "ms");
    }
    if (!weights.empty()) {
        header.push_back("weight");
    }
    std::vector<std::vector<std::string>> rows;
    for (std::size_t i = 0; i < responses.size(); ++i) {
        const data::Reading& r = study.readings[i];
        const double model = r.in_unit(responses[i]);
        const auto plain = [](double value) { return fmt::format("{:g}", value); };
        std::vector<std::string> row{
            r.load,
            !r.is_measured() ? r.output
            : r.name.empty() ? r.quantity
                             : r.name,
            plain(r.x_mm),
            plain(r.y_mm),
            plain(r.depth_mm),
            plain(r.gauge_mm),
            r.is_measured() ? fmt::format("{}{}", data::sign_of(r.censored), r.value) : "",
            figure(model),
            std::string(r.unit.name),
            r.is_measured() && r.value != 0.0 ? fmt::format("{:+.1f} %", 100.0 * (model / r.value - 1.0)) : ""};
        if (has_times) {
            row.insert(row.begin() + 6, r.time_ms ? plain(*r.time_ms) : "");
        }
        if (!weights.empty()) {
            const auto weight = weights.find(i);
            row.push_back(weight == weights.end() ? "" : fmt::format("{:.2f}", weight->second));
        }
        rows.push_back(std::move(row));
    }
    // Readings of a user's own model may be told apart by their names alone.
    for (std::size_t c = has_times ? 7 : 6; study.has_own_model && c-- > 0;) {
        const auto says_nothing = [&](const auto& row) { return row[c] == (c == 0 ? rows[0][0] : "0"); };
        if (c != 1 && std::all_of(rows.begin(), rows.end(), says_nothing)) {
            header.erase(header.begin() + static_cast<std::ptrdiff_t>(c));
            for (auto& row : rows) {
                row.erase(row.begin() + static_cast<std::ptrdiff_t>(c));
            }
        }
    }
    Table table(header);
    for (auto& row : rows) {
        table.add(std::move(row));
    }
    return fmt::format("  {}\n{}", signs(study), table.text());
}

std::string_view signs(const study::Study& study) {
    return study.has_own_model ? "readings as the study's own model gives them" : sign_convention;
}

std::string reduced_words(const analysis::ReducedProblem& reduced) {
    std::string text;
    for (const auto& load : reduced.loads) {
        const auto& r = load.report;
        if (r.modes == 0) {
            text +=
                fmt::format("  stand-in for the model: from {} runs of it{}; errors at new points below {:.2g} % of "
                            "the range of a reading in 95 of 100\n",
                            r.full_runs, reduced.built ? "" : " before", 100.0 * r.error_95);
            continue;
        }
        text +=
            fmt::format("  reduced model of load {}: {} modes, {} points, from {} full runs{}; errors at "
                        "new points below {:.2g} % in 95 of 100\n",
                        load.name, r.modes, r.points, r.full_runs, reduced.built ? "" : " before", 100.0 * r.error_95);
    }
    return text;
}

std::string millimetres(const std::optional<double>& mm, double most) {
    return mm ? fmt::format("{:.0f}", std::ceil(*mm)) : fmt::format("> {:g}", most);
}

std::string sentences(const std::vector<std::string>& text) {
    std::string lines;
    for (const std::string& sentence : text) {
        lines += "  " + sentence + "\n";
    }
    return lines;
}

std::string warning_lines(const problem::Evaluation& evaluation) {
    std::string lines;
    for (const auto& warning : warnings_json(evaluation)) {
        lines += "  warning: " + warning.get<std::string>() + "\n";
    }
    return lines;
}

std::vector<std::string> with_axes(std::vector<std::string> before, const problem::ParameterSpace& space,
                                   const std::vector<std::string>& after) {
    for (const auto& axis : space.axes) {
        before.push_back(axis.name);
    }
    before.insert(before.end(), after.begin(), after.end());
    return before;
}

} // namespace explore::report
