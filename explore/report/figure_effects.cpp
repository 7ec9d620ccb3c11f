// Bars and bands: candidates and corrections of a diagnosis, indices of sensitivity.
#include "report/figures.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

constexpr double row = 0.45; // cm

// A panel of rows with names at its left, the first at the top. longest: letters of a name.
Panel rows_panel(double bottom, std::size_t count, std::size_t longest) {
    Panel panel;
    panel.left = 0.6 + 0.165 * static_cast<double>(longest);
    panel.bottom = bottom;
    panel.width = 8.0;
    panel.height = row * static_cast<double>(count);
    panel.grid = true;
    panel.y.low = -0.5;
    panel.y.high = static_cast<double>(count) - 0.5;
    panel.y.reversed = true;
    return panel;
}

std::string text_at(const Json& json, const std::string& key) {
    return json.value(key, std::string());
}

// The fall of chi2 by a candidate alone: of its fit, or the square of its score.
double fall_of(const Json& candidate) {
    const double fitted = -number_or_none(candidate.value("delta_chi2", Json()));
    const double score = number_or_none(candidate.value("score_z", Json()));
    return std::isnan(fitted) ? score * score : fitted;
}

// The fall that one of so many candidates reaches by chance in 5 % of cases: between those on either side of that
// probability; not a number: all are on one side.
double fall_by_chance(const Json& candidates) {
    std::vector<std::pair<double, double>> all; // the square of the score, ln(p / 5 %)
    for (const Json& candidate : candidates) {
        const double score = number_or_none(candidate.value("score_z", Json()));
        const double p = number_or_none(candidate.value("p_familywise", Json()));
        if (std::isfinite(score) && p > 0.0) {
            all.emplace_back(score * score, std::log(p / 0.05));
        }
    }
    std::sort(all.begin(), all.end());
    for (std::size_t i = 1; i < all.size(); ++i) {
        const auto& [low, above] = all[i - 1];
        const auto& [high, below] = all[i];
        if (above > 0.0 && below <= 0.0) {
            return low + (high - low) * above / (above - below);
        }
    }
    return none;
}

} // namespace

Figure candidates_figure(const Json& diagnose) {
    std::vector<Json> candidates(diagnose.at("candidates").begin(), diagnose.at("candidates").end());
    const auto known_fall = [](const Json& candidate) {
        return std::isnan(fall_of(candidate)) ? -1.0 : fall_of(candidate);
    };
    std::stable_sort(candidates.begin(), candidates.end(),
                     [&](const Json& a, const Json& b) { return known_fall(a) > known_fall(b); });
    const double by_chance = fall_by_chance(diagnose.at("candidates"));
    const Json causes = diagnose.value("causes", Json::array());
    constexpr std::size_t most = 20;
    const std::size_t count = std::min(most, candidates.size());
    Figure figure{.name = "candidates", .height = row * static_cast<double>(count) + 2.3};
    DataTable table{"candidates", {"effect", "on", "fall_of_chi2", "by", "named"}, {}};
    const auto name_of = [](const Json& candidate) {
        const std::string on = text_at(candidate, "on");
        return candidate.at("effect").get<std::string>() + (on.empty() ? "" : ", " + on);
    };
    std::size_t longest = 0;
    for (std::size_t c = 0; c < count; ++c) {
        longest = std::max(longest, name_of(candidates[c]).size());
    }
    Panel panel = rows_panel(1.8, count, longest);
    figure.width = panel.left + panel.width + 0.5;
    Boxes bars;
    double highest = 1.0;
    for (std::size_t c = 0; c < count; ++c) {
        const Json& candidate = candidates[c];
        const auto effect = candidate.at("effect").get<std::string>();
        const bool is_fitted = candidate.value("delta_chi2", Json()).is_number();
        const double fall = fall_of(candidate);
        const bool named = std::find(causes.begin(), causes.end(), effect) != causes.end();
        table.rows.push_back(
            {effect, text_at(candidate, "on"), cell(fall), is_fitted ? "fit" : "score", named ? "yes" : "no"});
        const auto at = static_cast<double>(c);
        panel.y.ticks.push_back({at, name_of(candidate)});
        if (std::isfinite(fall)) {
            bars.left.push_back(0.0);
            bars.right.push_back(std::max(0.0, fall));
            bars.bottom.push_back(at - 0.35);
            bars.top.push_back(at + 0.35);
            bars.colours.push_back(named ? okabe_ito[1] : okabe_ito[5]);
            highest = std::max(highest, fall);
        }
    }
    panel.layers.emplace_back(std::move(bars));
    if (std::isfinite(by_chance)) {
        highest = std::max(highest, by_chance);
        panel.layers.emplace_back(Line{.x = {by_chance, by_chance},
                                       .y = {panel.y.low, panel.y.high},
                                       .colour = black,
                                       .width = 1.0,
                                       .dashed = true});
    }
    panel.x.high = 1.05 * highest;
    panel.x.ticks = round_ticks(0.0, panel.x.high, false, 6);
    panel.x.label = "fall of χ² by each effect alone" + std::string(causes.empty() ? "" : "; dark: named as cause") +
                    (std::isfinite(by_chance) ? "\ndashed: by chance in 5 % of cases" : "");
    figure.panels.push_back(std::move(panel));
    figure.tables = {std::move(table)};
    return figure;
}

Figure corrections_figure(const Json& diagnose) {
    Figure figure{.name = "corrections", .width = 0.0, .height = 8.0};
    DataTable table{"corrections", {"channel", "layer", "at", "unit", "factor", "low", "high", "seen"}, {}};
    for (const Json& c : diagnose.at("corrections")) {
        const auto channel = c.at("channel").get<std::string>();
        const std::string layer = text_at(c, "layer");
        const bool down = channel == "depth" || channel == "level";
        Panel panel;
        panel.left = figure.width + 1.9;
        panel.bottom = 1.3;
        panel.width = 5.5;
        panel.height = 5.9;
        panel.grid = true;
        figure.width = panel.left + panel.width + 0.5;
        Line line{.colour = okabe_ito[0], .width = 1.5, .marker = Marker::circle};
        Line band{.colour = grey, .width = 0.8, .dashed = true};
        std::vector<double> all;
        const auto add = [&](Line& to, double at, double factor) {
            to.x.push_back(down ? factor : at);
            to.y.push_back(down ? at : factor);
        };
        const std::size_t count = c.at("at").size();
        for (std::size_t i = 0; i < count; ++i) {
            const double at = number_or_none(c.at("at")[i]);
            const double factor = number_or_none(c.at("values")[i]);
            const double low = number_or_none(c.at("low")[i]);
            const double high = number_or_none(c.at("high")[i]);
            add(line, at, factor);
            all.insert(all.end(), {low, factor, high});
            table.rows.push_back({channel, layer, cell(at), text_at(c, "unit"), cell(factor), cell(low), cell(high),
                                  c.at("seen")[i].get<bool>() ? "yes" : "no"});
        }
        for (const std::string side : {"low", "high"}) {
            for (std::size_t i = 0; i < count; ++i) {
                add(band, number_or_none(c.at("at")[i]), number_or_none(c.at(side)[i]));
            }
            band.x.push_back(none);
            band.y.push_back(none);
        }
        std::erase_if(all, [](double v) { return !std::isfinite(v) || v <= 0.0; });
        all.push_back(1.0);
        const auto [lowest, highest] = std::minmax_element(all.begin(), all.end());
        PlotAxis& factor = down ? panel.x : panel.y;
        PlotAxis& place = down ? panel.y : panel.x;
        factor.low = *lowest / 1.1;
        factor.high = *highest * 1.1;
        factor.log = true;
        factor.ticks = round_ticks(factor.low, factor.high, factor.high > 3.0 * factor.low, 5);
        factor.label = layer.empty() ? "factor on the readings" : "factor on the modulus";
        const auto [first, last] =
            std::minmax_element((down ? line.y : line.x).begin(), (down ? line.y : line.x).end());
        const double margin = *last > *first ? 0.06 * (*last - *first) : std::max(1.0, 0.1 * std::abs(*first));
        place.low = *first - margin;
        place.high = *last + margin;
        place.ticks = round_ticks(place.low, place.high, false, 6);
        place.label = fmt::format("{} ({})", channel, unit_words(text_at(c, "unit")));
        place.reversed = down;
        Line none_needed{.colour = black, .width = 0.8};
        add(none_needed, place.low, 1.0);
        add(none_needed, place.high, 1.0);
        panel.layers.emplace_back(std::move(none_needed));
        panel.layers.emplace_back(std::move(band));
        panel.layers.emplace_back(std::move(line));
        panel.title = (layer.empty() ? "readings" : layer) + ", with its 95 % band";
        figure.panels.push_back(std::move(panel));
    }
    figure.tables = {std::move(table)};
    return figure;
}

Figure sensitivity_figure(const Json& sensitivity) {
    const Json& indices = sensitivity.at("global").at("indices");
    Figure figure{.name = "sensitivity"};
    std::size_t longest = 0;
    double lowest = -0.1;
    double highest = 1.1;
    for (const Json& of : indices) {
        for (const char* order : {"first_order", "total"}) {
            for (const auto& [parameter, index] : of.at(order).items()) {
                longest = std::max(longest, parameter_words(parameter).size());
                const double low = number_or_none(index.at("low"));
                const double high = number_or_none(index.at("high"));
                lowest = std::isfinite(low) ? std::min(lowest, low) : lowest;
                highest = std::isfinite(high) ? std::max(highest, high) : highest;
            }
        }
    }
    DataTable table{"sensitivity", {"response", "parameter", "index", "value", "low", "high"}, {}};
    double bottom = 1.3;
    for (std::size_t r = indices.size(); r-- > 0;) { // from the bottom
        const Json& of = indices[r];
        const auto response = of.at("response").get<std::string>();
        Panel panel = rows_panel(bottom, of.at("total").size(), longest);
        figure.width = panel.left + panel.width + 0.5;
        double at = 0.0;
        for (const auto& [parameter, total] : of.at("total").items()) {
            panel.y.ticks.push_back({at, parameter_words(parameter)});
            for (const bool whole : {false, true}) {
                const Json& index = whole ? total : of.at("first_order").at(parameter);
                const double value = number_or_none(index.at("value"));
                const double low = number_or_none(index.at("low"));
                const double high = number_or_none(index.at("high"));
                table.rows.push_back(
                    {response, parameter, whole ? "total" : "first order", cell(value), cell(low), cell(high)});
                const double y = at + (whole ? 0.2 : -0.2);
                const Colour colour = whole ? okabe_ito[1] : okabe_ito[0];
                panel.layers.emplace_back(Line{.x = {low, high}, .y = {y, y}, .colour = colour, .width = 1.2});
                panel.layers.emplace_back(Line{.x = {value},
                                               .y = {y},
                                               .colour = colour,
                                               .width = 0.0,
                                               .marker = whole ? Marker::square : Marker::circle,
                                               .marker_size = 1.1});
            }
            at += 1.0;
        }
        panel.x.low = lowest;
        panel.x.high = highest;
        panel.x.ticks = round_ticks(lowest, highest, false, 6);
        panel.x.labelled = r + 1 == indices.size();
        panel.x.label = r + 1 == indices.size() ? "share of the variance: ● first order, ■ total" : "";
        panel.title = response;
        bottom = panel.bottom + panel.height + 0.9;
        figure.panels.push_back(std::move(panel));
    }
    figure.height = bottom;
    figure.tables = {std::move(table)};
    return figure;
}

} // namespace explore::report
