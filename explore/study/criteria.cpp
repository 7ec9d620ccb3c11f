#include "study/criteria.h"

#include "pavement/parameter.h"
#include "study/readings.h"
#include "study/table_reader.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace explore::study {
namespace {

using namespace pave::pavement;

constexpr std::string_view of_expression = "expression";

const CriterionLaw* find_law(TableReader& reader) {
    std::vector<std::string> names;
    for (const CriterionLaw& law : criterion_laws()) {
        names.emplace_back(law.name);
    }
    names.emplace_back(of_expression);
    const std::size_t choice = reader.choice(keys::criterion_law, names);
    return choice < criterion_laws().size() ? &criterion_laws()[choice] : nullptr;
}

void read_expression(TableReader& reader, Criterion& criterion) {
    criterion.place = static_cast<CriticalPlace>(reader.choice(keys::criterion_place));
    const std::string text = reader.text(keys::criterion_life);
    try {
        criterion.life = pave::Expression(text, {"strain", "modulus"});
    } catch (const std::invalid_argument& error) {
        throw pave::Error(reader.place(keys::criterion_life),
                          std::string("this expression cannot be read: ") + error.what(), "\"" + text + "\"",
                          "arithmetic of numbers, strain (microstrain) and modulus (MPa)");
    }
    constexpr double usual = 500.0; // microstrain
    if (!std::isfinite(criterion.log_repetitions({.strain = usual, .modulus_MPa = 3000.0}))) {
        throw pave::Error(reader.place(keys::criterion_life),
                          "this expression has no positive value at 500 microstrain", "\"" + text + "\"",
                          "repetitions");
    }
}

std::size_t layer_of(TableReader& reader, const Study& study, const Criterion& criterion) {
    const auto& layers = study.model.layers;
    const bool at_bottom = criterion.place == CriticalPlace::asphalt_bottom;
    std::size_t layer = at_bottom ? 0 : layers.size() - 1;
    if (reader.has(keys::criterion_layer)) {
        const std::vector<std::string> names = names_of(layers);
        layer = reader.choice(keys::criterion_layer, names);
    }
    const auto place = reader.place(reader.has(keys::criterion_layer) ? std::string_view(keys::criterion_layer) : "");
    if (at_bottom && (layers[layer].law->stress_dependent() || layer + 1 == layers.size())) {
        throw pave::Error(place, "fatigue is of a bound layer, which this is not", "\"" + layers[layer].name + "\"",
                          "a layer of linear or viscoelastic asphalt above others");
    }
    if (!at_bottom && layer == 0) {
        throw pave::Error(place, "deformation is of a layer below others, which this is not",
                          "\"" + layers[layer].name + "\"", "a layer that others cover");
    }
    return layer;
}

// A place that moves while thicknesses are fitted would need a sensor that moves.
void check_depth(const TableReader& reader, const Study& study, const Criterion& criterion) {
    const auto last = criterion.layer + (criterion.place == CriticalPlace::asphalt_bottom ? 1 : 0);
    for (const Parameter& p : study.parameters) {
        if (p.changes_geometry() && !p.in_load && static_cast<std::size_t>(p.owner) < last) {
            throw pave::Error(reader.place(keys::criterion_name),
                              "the depth of this criterion's strain is not known while a thickness is fitted",
                              "\"" + p.path + "\" among the parameters", "thicknesses that are given");
        }
    }
}

Criterion read_criterion(const toml::table& table, const Study& study) {
    TableReader reader(table, study.file, "[[criteria]]");
    Criterion criterion;
    criterion.name = reader.text(keys::criterion_name);
    reader.rename("criterion \"" + criterion.name + "\"");
    criterion.line = reader.place(keys::criterion_name).line;
    criterion.guide = find_law(reader);
    criterion.law = criterion.guide != nullptr ? criterion.guide->name : of_expression;
    if (criterion.guide != nullptr) {
        criterion.place = criterion.guide->place;
        reader.expect(criterion.guide->options);
        for (const CriterionOption& option : criterion.guide->options) {
            criterion.options.push_back(
                reader.number(option.key, option.low, option.high, false, option.default_value));
        }
    } else {
        read_expression(reader, criterion);
    }
    criterion.load = static_cast<std::size_t>(
        find_load(study.model, reader.text(keys::criterion_axle), reader.place(keys::criterion_axle)));
    const Load& load = study.model.loads[criterion.load];
    if (criterion.place == CriticalPlace::plate && load.type != LoadType::plate) {
        throw pave::Error(reader.place(keys::criterion_axle), "this law is of deflections under a plate",
                          "\"" + load.name + "\"", "a load of type plate");
    }
    if (load.is_pulse()) {
        throw pave::Error(reader.place(keys::criterion_axle), "an axle has no history", "\"" + load.name + "\"",
                          "a load without one");
    }
    criterion.layer = layer_of(reader, study, criterion);
    if (reader.has(keys::criterion_modulus)) {
        criterion.modulus_MPa = reader.number(keys::criterion_modulus);
    }
    const Layer& layer = study.model.layers[criterion.layer];
    const auto law_keys = layer.law->parameters();
    const bool has_modulus =
        std::any_of(law_keys.begin(), law_keys.end(), [](const auto& info) { return info.key == "modulus_MPa"; });
    if (criterion.reads_modulus() && !criterion.modulus_MPa && !has_modulus) {
        throw pave::Error(reader.place(keys::criterion_modulus), "this law needs the modulus of the asphalt",
                          "layer \"" + layer.name + "\" of law " + std::string(layer.law->name()),
                          "modulus_MPa in the criterion");
    }
    criterion.traffic_per_year = reader.number(keys::criterion_traffic);
    criterion.growth = reader.number(keys::criterion_growth);
    criterion.passed = reader.number(keys::criterion_passed);
    if (reader.has(keys::criterion_design)) {
        criterion.design_traffic = reader.number(keys::criterion_design);
    }
    reader.done();
    check_depth(reader, study, criterion);
    return criterion;
}

} // namespace

bool Criterion::reads_modulus() const {
    if (guide != nullptr) {
        return guide->reads_modulus;
    }
    const auto& reads = life->reads();
    return std::find(reads.begin(), reads.end(), "modulus") != reads.end();
}

double Criterion::depth(const Case& c) const {
    double sum = 0.0;
    const std::size_t above = place == CriticalPlace::asphalt_bottom ? layer + 1 : layer;
    for (std::size_t i = 0; i < above; ++i) {
        sum += c.layers[i].thickness;
    }
    return sum;
}

// A first year of T and growth g: T ((1 + g)^years - 1) / g.
double Criterion::traffic_of(double years) const {
    return growth == 0.0 ? traffic_per_year * years
                         : traffic_per_year * std::expm1(years * std::log1p(growth)) / growth;
}

double Criterion::years_of(double repetitions) const {
    if (growth == 0.0 || !std::isfinite(repetitions)) {
        return repetitions / traffic_per_year;
    }
    const double sum = growth * repetitions / traffic_per_year;
    return sum > -1.0 ? std::log1p(sum) / std::log1p(growth) : repetitions > 0.0 ? INFINITY : -INFINITY;
}

double Criterion::log_repetitions(const CriterionState& state) const {
    if (guide != nullptr) {
        CriterionState own = state;
        own.options = options;
        return guide->log_repetitions(own);
    }
    if (!(state.strain > 0.0)) {
        return INFINITY;
    }
    std::vector<double> values;
    for (const std::string& name : life->reads()) {
        values.push_back(name == "strain" ? state.strain : state.modulus_MPa);
    }
    return std::log(life->value(values));
}

std::vector<Criterion> criteria_of(const Study& study) {
    std::vector<Criterion> list;
    if (study.text.empty()) {
        return list;
    }
    const toml::table table = toml::parse(study.text, study.file);
    TableReader reader(table, study.file, "");
    std::set<std::string> names;
    for (const auto* criterion : reader.tables("criteria")) {
        list.push_back(read_criterion(*criterion, study));
        if (!names.insert(list.back().name).second) {
            throw pave::Error({.file = study.file, .line = list.back().line, .key = "[[criteria]] name"},
                              "this criterion is given twice", "\"" + list.back().name + "\"", "each name once");
        }
    }
    return list;
}

} // namespace explore::study
