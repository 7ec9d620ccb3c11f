#include "report/figures.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

// Readings of a folder and the models that were compared with them.
struct Compared {
    Json readings = Json::array();
    std::vector<ComparedModel> models;
};

Compared of_best_fit(const Json& result) {
    Compared compared;
    ComparedModel best{
        .name = "best fit", .values = {}, .residuals = {}, .curves = result.value("curves", Json::array())};
    for (const Json& r : result.at("responses")) {
        if (r.contains("measured")) {
            compared.readings.push_back(r);
            best.values.push_back(number_or_none(r.at("value")));
            best.residuals.push_back(number_or_none(r.value("residual", Json())));
        }
    }
    compared.models.push_back(std::move(best));
    return compared;
}

// The best fit of every law that has an answer.
Compared of_laws(const Json& result) {
    Compared compared;
    const bool of_studies = result.contains("studies");
    for (const Json& law : result.at(of_studies ? "studies" : "laws")) {
        if (law.at("status") != "converged") {
            continue;
        }
        ComparedModel model{
            .name = law.at(of_studies ? "study" : "law").get<std::string>(), .values = {}, .residuals = {}};
        for (const Json& r : law.at("responses")) {
            if (r.contains("measured")) {
                if (compared.models.empty()) {
                    compared.readings.push_back(r);
                }
                model.values.push_back(number_or_none(r.at("value")));
                model.residuals.push_back(number_or_none(r.value("residual", Json())));
            }
        }
        compared.models.push_back(std::move(model));
    }
    return compared;
}

Compared of_diagnosis(const Json& result) {
    Compared compared;
    compared.readings = result.at("readings");
    const Json& values = result.at("responses");
    const Json& residuals = result.at("residuals");
    for (std::size_t i = 0; i < compared.readings.size(); ++i) {
        compared.readings[i]["measured"] = values.at("measured").at(i);
        compared.readings[i]["held_out"] = residuals.at("baseline").at(i).is_null();
    }
    for (const auto& [key, name] : {std::pair{"baseline", "study's model"}, {"extended", "extended model"}}) {
        if (values.at(key).size() != compared.readings.size()) {
            continue;
        }
        ComparedModel model{.name = name, .values = {}, .residuals = {}};
        for (std::size_t i = 0; i < compared.readings.size(); ++i) {
            model.values.push_back(number_or_none(values.at(key).at(i)));
            model.residuals.push_back(number_or_none(residuals.at(key).at(i)));
        }
        compared.models.push_back(std::move(model));
    }
    return compared;
}

// The best fit where there is one, else the models of a diagnosis.
std::optional<Compared> compared_in(const Json& results) {
    for (const std::string command : {"fit", "unique"}) {
        if (results.contains(command) && results.at(command).contains("responses")) {
            return of_best_fit(results.at(command));
        }
    }
    if (results.contains("compare")) {
        return of_laws(results.at("compare"));
    }
    if (results.contains("diagnose") && results.at("diagnose").contains("readings")) {
        return of_diagnosis(results.at("diagnose"));
    }
    return std::nullopt;
}

// Of the study whose readings are compared.
Json layers_in(const Json& results) {
    for (const char* command : {"fit", "unique", "compare", "diagnose"}) {
        if (results.contains(command)) {
            const Json study = results.at(command).value("study", Json());
            return study.is_object() ? study.value("layers", Json::array()) : Json::array();
        }
    }
    return Json::array();
}

bool has_residuals(const Compared& compared) {
    return std::any_of(compared.models.begin(), compared.models.end(), [](const ComparedModel& model) {
        return std::any_of(model.residuals.begin(), model.residuals.end(), [](double r) { return std::isfinite(r); });
    });
}

// Parameters with their ranges and minima of the command that the evaluations are of.
struct Sampled {
    Json parameters, minima;
};
std::optional<Sampled> sampled_in(const FolderContents& contents) {
    if (contents.evaluations.is_null() || contents.evaluations.at("rows").empty()) {
        return std::nullopt;
    }
    const std::string command = contents.evaluations.at("command").get<std::string>();
    if (!contents.results.contains(command) || !contents.results.at(command).contains("parameters")) {
        return std::nullopt;
    }
    const Json& result = contents.results.at(command);
    Json minima = result.value("minima", Json::array());
    if (command == "map" && !result.at("lowest").empty()) {
        minima.push_back(result.at("lowest").at(0));
    }
    return Sampled{result.at("parameters"), std::move(minima)};
}

// A walk, its values rising, as a smooth line.
std::vector<std::pair<double, double>> smoothed(const std::vector<std::pair<double, double>>& walk, bool log) {
    std::vector<double> at, rise;
    for (const auto& [value, r] : walk) {
        at.push_back(log ? std::log(value) : value);
        rise.push_back(r);
    }
    const auto [places, rises] = smooth_rise(at, rise);
    std::vector<std::pair<double, double>> line;
    for (std::size_t i = 0; i < places.size(); ++i) {
        line.emplace_back(log ? std::exp(places[i]) : places[i], rises[i]);
    }
    return line;
}

bool has_profiled(const Json& results) {
    return results.contains("unique") && results.at("unique").contains("landscape") &&
           !results.at("unique").at("landscape").at("profiles").empty();
}

bool has_profiles(const Json& results) {
    return results.contains("unique") && results.at("unique").contains("acceptance") &&
           !results.at("unique").at("profiles").empty();
}

// Stations along a road; null: none.
const Json* road_in(const Json& results) {
    for (const char* command : {"survey", "road"}) {
        if (results.contains(command)) {
            return &results.at(command);
        }
    }
    return nullptr;
}

} // namespace

double number_or_none(const Json& value) {
    return value.is_number() ? value.get<double>() : none;
}

std::vector<std::string> figures_of(const FolderContents& contents) {
    std::vector<std::string> names;
    if (has_profiled(contents.results) || sampled_in(contents)) {
        names.emplace_back("landscape");
    }
    if (has_profiled(contents.results) && has_profiles(contents.results) &&
        has_close_landscape(contents.results.at("unique"))) {
        names.emplace_back("landscape-close");
    }
    if (has_profiles(contents.results)) {
        names.emplace_back("profiles");
    }
    if (const auto compared = compared_in(contents.results); compared && !compared->readings.empty()) {
        names.emplace_back("fit");
        if (has_residuals(*compared)) {
            names.emplace_back("residuals");
        }
    }
    const Json& results = contents.results;
    if (results.contains("diagnose") && !results.at("diagnose").value("candidates", Json::array()).empty()) {
        names.emplace_back("candidates");
    }
    if (results.contains("diagnose") && !results.at("diagnose").value("corrections", Json::array()).empty()) {
        names.emplace_back("corrections");
    }
    if (results.contains("sensitivity") && results.at("sensitivity").contains("global")) {
        names.emplace_back("sensitivity");
    }
    if (results.contains("sample") && !results.at("sample").value("draws", Json::array()).empty()) {
        names.emplace_back("posterior");
        if (results.at("sample").contains("predictive")) {
            names.emplace_back("predictive");
        }
    }
    if (results.contains("design") && results.at("design").contains("overlay_mm")) {
        const Json& criteria = results.at("design").at("criteria");
        if (std::any_of(criteria.begin(), criteria.end(),
                        [](const Json& c) { return !c.value("distribution", Json::array()).empty(); })) {
            names.insert(names.end(), {"life", "overlay"});
        }
    }
    if (results.contains("sample-prior") && !results.at("sample-prior").value("readings", Json::array()).empty()) {
        names.emplace_back("prior-predictive");
    }
    if (const Json* road = road_in(results)) {
        const auto any = [&](const char* key) {
            return std::any_of(road->at("stations").begin(), road->at("stations").end(),
                               [&](const Json& s) { return s.contains(key); });
        };
        if (any("D0_um")) {
            names.emplace_back("deflections");
        }
        if (any("fit")) {
            names.emplace_back("back-calculation");
        }
    }
    return names;
}

std::vector<Figure> pair_figures(const FolderContents& contents, const NamedPair& pair) {
    std::vector<std::string> known;
    if (has_profiled(contents.results)) {
        const Json& unique = contents.results.at("unique");
        for (const Json& one : unique.at("landscape").at("pairs")) {
            const auto x = one.at("x").get<std::string>();
            const auto y = one.at("y").get<std::string>();
            if (pair.is(x, y)) {
                Figure figure = profiled_landscape_figure(unique, false, pair);
                figure.name = fmt::format("landscape-{}-{}", x, y);
                return {std::move(figure), surface_figure(unique, pair)};
            }
            known.push_back(fmt::format("{},{}", x, y));
        }
    }
    throw pave::Error({}, "this run has no such figure: the landscape of a pair", pair.a + "," + pair.b,
                      known.empty() ? "a run of unique with --landscape" : pave::join(known, " "));
}

Figure make_figure(const FolderContents& contents, const std::string& name) {
    if (name == "landscape") {
        if (has_profiled(contents.results)) {
            return profiled_landscape_figure(contents.results.at("unique"), false);
        }
        const Sampled sampled = sampled_in(contents).value();
        return sampled_landscape_figure(contents.evaluations, sampled.parameters, sampled.minima);
    }
    if (name == "landscape-close") {
        return profiled_landscape_figure(contents.results.at("unique"), true);
    }
    if (name == "candidates") {
        return candidates_figure(contents.results.at("diagnose"));
    }
    if (name == "corrections") {
        return corrections_figure(contents.results.at("diagnose"));
    }
    if (name == "sensitivity") {
        return sensitivity_figure(contents.results.at("sensitivity"));
    }
    if (name == "posterior") {
        return posterior_figure(contents.results.at("sample"));
    }
    if (name == "predictive") {
        return predictive_figure(contents.results.at("sample").at("predictive").at("readings"), name);
    }
    if (name == "prior-predictive") {
        return predictive_figure(contents.results.at("sample-prior").at("readings"), name);
    }
    if (name == "life") {
        return life_figure(contents.results.at("design"));
    }
    if (name == "overlay") {
        return overlay_figure(contents.results.at("design"));
    }
    if (name == "deflections") {
        return deflections_figure(*road_in(contents.results));
    }
    if (name == "back-calculation") {
        return back_calculation_figure(*road_in(contents.results));
    }
    if (name == "profiles") {
        return profiles_figure(contents.results.at("unique"));
    }
    const Compared compared = compared_in(contents.results).value();
    return name == "fit" ? fit_figure(compared.readings, compared.models, layers_in(contents.results))
                         : residuals_figure(compared.readings, compared.models);
}

namespace {

// The span of a panel for a parameter from low to high: a little more than the accepted range where that is a small
// part.
std::pair<double, double> shown_of(double low, double high, bool log, double accepted_low, double accepted_high) {
    const auto at = [log](double value) { return log ? std::log(value) : value; };
    const auto value = [log](double x) { return log ? std::exp(x) : x; };
    const double whole = at(high) - at(low);
    const double accepted = at(accepted_high) - at(accepted_low);
    constexpr double least = 1e-3; // of the whole: where the data accept a point
    constexpr double small = 0.4;
    const double margin = 0.5 * std::max(accepted, least * whole);
    if (!(accepted + 2.0 * margin < small * whole)) {
        return {low, high};
    }
    return {std::max(low, value(at(accepted_low) - margin)), std::min(high, value(at(accepted_high) + margin))};
}

} // namespace

Figure profiles_figure(const Json& unique) {
    const double limit = unique.at("acceptance").at("chi2_rise_allowed").get<double>();
    struct One {
        const Json* profile;
        AxisWords label;
        bool log = false;
        const Json* whole = nullptr; // over the whole range, of the landscape
        double low = none, high = none;
    };
    std::vector<One> all;
    for (const Json& profile : unique.at("profiles")) {
        One one{&profile, axis_words(profile.at("name").get<std::string>())};
        for (const Json& p : unique.at("parameters")) {
            if (p.at("name") == profile.at("name")) {
                one.log = p.at("scale") == "log";
                one.low = p.at("min").get<double>();
                one.high = p.at("max").get<double>();
            }
        }
        if (unique.contains("landscape")) {
            for (const Json& p : unique.at("landscape").at("profiles")) {
                one.whole = p.at("name") == profile.at("name") ? &p : one.whole;
            }
        }
        all.push_back(std::move(one));
    }
    for (const Json& output : unique.at("outputs")) {
        if (output.contains("profile")) {
            all.push_back({&output, AxisWords{"", output.at("name").get<std::string>(),
                                              unit_words(output.at("unit").get<std::string>())}});
        }
    }
    const bool other_model = unique.contains("landscape") && unique.at("landscape").at("model") != unique.at("model");
    const std::size_t columns = std::min<std::size_t>(3, all.size());
    const std::size_t rows = (all.size() + columns - 1) / columns;
    constexpr double side = 4.5;
    constexpr double high = 3.4;
    constexpr double gap = 0.75;
    constexpr std::size_t widest = 24; // letters of a label that fits under its panel
    const bool two_lines =
        std::any_of(all.begin(), all.end(), [](const One& one) { return one.label.line().size() > widest; });
    const double below = two_lines ? 1.65 : 1.25;
    Figure figure{.name = "profiles"};
    figure.width = 1.4 + static_cast<double>(columns) * (side + gap);
    figure.height = static_cast<double>(rows) * (high + below) + 1.2;
    DataTable table{"profiles", {"name", "source", "value", "rise_of_chi2"}, {}};
    DataTable ranges{"ranges", {"name", "best", "low", "high", "unit"}, {}};
    const double top = 3.0 * limit;
    for (std::size_t n = 0; n < all.size(); ++n) {
        const One& one = all[n];
        const Json& profile = *one.profile;
        const std::size_t row = n / columns;
        Panel panel;
        panel.left = 1.4 + static_cast<double>(n % columns) * (side + gap);
        panel.bottom = below + 0.1 + static_cast<double>(rows - 1 - row) * (high + below);
        panel.width = side;
        panel.height = high;
        const std::string name = profile.at("name").get<std::string>();
        const double best = number_or_none(profile.at("best"));
        const double accepted_low = number_or_none(profile.at("low"));
        const double accepted_high = number_or_none(profile.at("high"));
        auto [from, to] = shown_of(one.low, one.high, one.log, accepted_low, accepted_high);
        Line walked{.colour = okabe_ito[0], .width = 1.5};
        std::vector<std::vector<std::pair<double, double>>> branches;
        for (const Json& branch : profile.at("profile")) {
            branches.emplace_back();
            for (const Json& point : branch) {
                branches.back().emplace_back(number_or_none(point.at(0)), number_or_none(point.at(1)));
                table.rows.push_back(
                    {name, "walk", cell(branches.back().back().first), cell(branches.back().back().second)});
            }
        }
        if (branches.size() == 2) { // both sides of one minimum
            branches[0].insert(branches[0].end(), branches[1].begin(), branches[1].end());
            branches[0].emplace_back(best, 0.0);
            branches.resize(1);
        }
        for (auto& branch : branches) {
            std::sort(branch.begin(), branch.end());
            for (const auto& [value, rise] : one.whole == nullptr ? smoothed(branch, one.log) : branch) {
                walked.x.push_back(value);
                walked.y.push_back(std::min(std::max(rise, 0.0), 1e3 * top));
                if (std::isnan(one.low)) {
                    from = std::isnan(from) ? value : std::min(from, value);
                    to = std::isnan(to) ? value : std::max(to, value);
                }
            }
            walked.x.push_back(none);
            walked.y.push_back(none);
        }
        if (std::isnan(one.low)) {
            from = std::isnan(from) ? accepted_low : std::min(from, accepted_low);
            to = std::isnan(to) ? accepted_high : std::max(to, accepted_high);
            const double margin = to > from ? 0.04 * (to - from) : std::max(1e-9, 0.05 * std::abs(to));
            from -= margin;
            to += margin;
        }
        panel.layers.emplace_back(Boxes{{accepted_low}, {accepted_high}, {-0.04 * top}, {top}, {0xF6EDE6}, false});
        panel.layers.emplace_back(
            Line{.x = {from, to}, .y = {limit, limit}, .colour = okabe_ito[1], .width = 1.2, .dashed = true});
        if (one.whole != nullptr) {
            Line whole{.colour = other_model ? grey : okabe_ito[0], .width = other_model ? 1.0 : 1.5};
            const Json& values = one.whole->at("values");
            const Json& rises = one.whole->at("rise");
            std::vector<std::pair<double, double>> nodes;
            for (std::size_t i = 0; i < values.size(); ++i) {
                nodes.emplace_back(number_or_none(values.at(i)), number_or_none(rises.at(i)));
                table.rows.push_back({name, "landscape", cell(nodes.back().first), cell(nodes.back().second)});
            }
            for (const auto& [value, rise] : smoothed(nodes, one.log)) {
                whole.x.push_back(value);
                whole.y.push_back(std::isnan(rise) ? none : std::min(rise, 1e3 * top));
            }
            panel.layers.emplace_back(std::move(whole));
            if (!other_model) {
                walked.width = 0.0;
                walked.marker = Marker::circle;
                walked.marker_size = 0.7;
            }
        }
        panel.layers.emplace_back(std::move(walked));
        for (const bool outer : {true, false}) {
            panel.layers.emplace_back(Line{.x = {best},
                                           .y = {0.0},
                                           .colour = outer ? black : white,
                                           .width = 0.0,
                                           .marker = Marker::circle,
                                           .marker_size = outer ? 1.5 : 0.95});
        }
        panel.x.low = from;
        panel.x.high = to;
        panel.x.log = one.log;
        panel.x.ticks = round_ticks(from, to, one.log, 5);
        panel.x.label = two_lines ? one.label.lines() : one.label.line();
        panel.y.low = -0.04 * top;
        panel.y.high = top;
        panel.y.ticks = round_ticks(0.0, top, false, 5);
        panel.y.labelled = n % columns == 0;
        panel.y.label = n % columns == 0 ? "rise of χ²" : "";
        figure.panels.push_back(std::move(panel));
        ranges.rows.push_back({name, cell(best), cell(accepted_low), cell(accepted_high),
                               profile.contains("unit") ? profile.at("unit").get<std::string>() : ""});
    }
    // One legend for all, above them.
    Panel legend;
    legend.left = 1.4;
    legend.bottom = figure.height - 0.55;
    legend.width = figure.width - 1.9;
    legend.height = 0.4;
    legend.framed = false;
    legend.x.high = legend.width;
    double at = 0.0;
    const auto entry = [&](Line line, const std::string& words, double length) {
        line.x = {at, at + 0.6};
        line.y = {0.5, 0.5};
        legend.layers.emplace_back(std::move(line));
        legend.notes.push_back({(at + 0.75) / legend.width, 0.5, words});
        at += length;
    };
    entry({.colour = okabe_ito[0], .width = 1.5}, "all others fitted", 3.4);
    entry({.colour = okabe_ito[1], .width = 1.2, .dashed = true}, fmt::format("accepted: rise up to {:.3g}", limit),
          4.4);
    if (other_model) {
        entry({.colour = grey, .width = 1.0}, "by the reduced model", 3.4);
    }
    figure.panels.push_back(std::move(legend));
    figure.tables = {std::move(table), std::move(ranges)};
    return figure;
}

} // namespace explore::report
