#include "study/seasons.h"

#include "data/asphalt_temperature.h"
#include "study/table_reader.h"

#include <algorithm>
#include <cmath>

namespace explore::study {
namespace {

using namespace pave::pavement;

// A stiffness that follows others, or that others follow, would not change alone.
void check_ties(const Study& study, std::size_t layer, const pave::Place& place) {
    const Layer& changed = study.model.layers[layer];
    const std::string path = changed.name + "." + std::string(changed.law->parameters()[*stiffness_of(changed)].key);
    for (const Tie& tie : study.model.ties) {
        const auto& reads = tie.expression.reads();
        if (tie.path == path || std::find(reads.begin(), reads.end(), path) != reads.end()) {
            throw pave::Error(place, "the stiffness of this layer is tied to another number", "\"" + tie.path + "\"",
                              "seasons of layers that are not tied");
        }
    }
}

void set_factor(const Study& study, Season& season, std::size_t layer, double factor, const pave::Place& place) {
    const Layer& changed = study.model.layers[layer];
    if (!stiffness_of(changed)) {
        throw pave::Error(place, "no single number says how stiff a layer of this law is",
                          "layer \"" + changed.name + "\" of law " + std::string(changed.law->name()),
                          "linear, viscoelastic, k-theta, uzan, uzan-deviator, hyperelastic");
    }
    check_ties(study, layer, place);
    season.factors[layer] = factor;
}

Season read_season(const toml::table& table, const Study& study) {
    TableReader reader(table, study.file, "[[seasons]]");
    Season season;
    season.name = reader.text(keys::season_name);
    reader.rename("season \"" + season.name + "\"");
    season.share = reader.number(keys::season_share);
    season.factors.assign(study.model.layers.size(), 1.0);
    const toml::table* factors = reader.table(keys::season_factors);
    if (factors != nullptr) {
        TableReader own(*factors, study.file, "season \"" + season.name + "\" factors");
        for (std::size_t i = 0; i < study.model.layers.size(); ++i) {
            const std::string& layer = study.model.layers[i].name;
            if (own.has(layer)) {
                constexpr double most = 100.0;
                set_factor(study, season, i, own.number(layer, 0.0, most, true), own.place(layer));
            }
        }
        own.done();
    }
    if (reader.has(keys::season_asphalt)) {
        if (study.model.layers.empty()) {
            throw pave::Error(reader.place(keys::season_asphalt), "this study has no layers", "a model of its own",
                              "seasons of a section");
        }
        const double warm = reader.number(keys::season_asphalt);
        const double tested = reader.number(keys::season_tested);
        const std::string& top = study.model.layers[0].name;
        if (factors != nullptr && factors->contains(top)) {
            throw pave::Error(reader.place(keys::season_asphalt), "the top layer has a factor, too",
                              fmt::format("{:g}", warm), "one of the two");
        }
        set_factor(study, season, 0, data::modulus_factor(tested, warm), reader.place(keys::season_asphalt));
    }
    reader.done();
    return season;
}

} // namespace

std::vector<Season> seasons_of(const Study& study) {
    std::vector<Season> list;
    if (study.text.empty()) {
        return list;
    }
    const toml::table table = toml::parse(study.text, study.file);
    TableReader reader(table, study.file, "");
    double sum = 0.0;
    const auto tables = reader.tables("seasons");
    for (const auto* season : tables) {
        list.push_back(read_season(*season, study));
        sum += list.back().share;
        const auto same = [&](const Season& other) { return other.name == list.back().name; };
        if (std::count_if(list.begin(), list.end(), same) > 1) {
            throw pave::Error(TableReader(*season, study.file, "[[seasons]]").place(keys::season_name),
                              "this season is given twice", "\"" + list.back().name + "\"", "each name once");
        }
    }
    constexpr double rounding = 0.001;
    if (!list.empty() && !(std::abs(sum - 1.0) <= rounding)) {
        throw pave::Error(TableReader(*tables[0], study.file, "[[seasons]]").place(keys::season_share),
                          "the shares of the seasons do not add up to a year", fmt::format("{:g}", sum), "1");
    }
    for (Season& season : list) {
        season.share /= sum;
    }
    return list;
}

std::optional<std::size_t> stiffness_of(const Layer& layer) {
    const std::string_view law = layer.law->name();
    const bool by_modulus = law == "linear" || law == "viscoelastic";
    if (!by_modulus && law != "k-theta" && law != "uzan" && law != "uzan-deviator" && law != "hyperelastic") {
        return std::nullopt;
    }
    const auto keys = layer.law->parameters();
    const auto found = std::find_if(keys.begin(), keys.end(), [&](const auto& info) {
        return info.key == (by_modulus ? std::string_view("modulus_MPa") : std::string_view("k1"));
    });
    return static_cast<std::size_t>(found - keys.begin());
}

void soften(Case& c, const Season& season) {
    for (std::size_t i = 0; i < c.layers.size(); ++i) {
        if (season.factors[i] != 1.0) {
            c.layers[i].parameters[*stiffness_of(c.layers[i])] *= season.factors[i];
        }
    }
}

std::vector<double> parameter_factors(const Study& study, const Season& season) {
    std::vector<double> factors;
    for (const Parameter& p : study.parameters) {
        const auto layer = static_cast<std::size_t>(p.owner);
        const bool is_stiffness = p.law_index && !p.in_load && !p.in_effect && !p.in_correction &&
                                  season.factors[layer] != 1.0 &&
                                  p.law_index == stiffness_of(study.model.layers[layer]);
        factors.push_back(is_stiffness ? season.factors[layer] : 1.0);
    }
    return factors;
}

} // namespace explore::study
