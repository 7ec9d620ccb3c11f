// Draws a section, its parameters, a layout of sensors, noise and what the model will lack from a seed, and writes
// study.toml and data.csv as an engineer would bring them; the truth goes to standard output as one JSON object, where
// only the judge reads it.
//
// usage: blind_generator SEED FOLDER KIND [LEAST MOST] [correlated | few | middle | DATA]
//   KIND   none, one, two, the name of an effect, or outside: one that is neither in the catalogue nor of the form of a
//          correction; LEAST MOST: its strength, in standard deviations (8 20); correlated: errors are tied as those of
//          repeated drops are, and the study says so; independent.toml and its data say that they are not; few: 11
//          readings instead of 40 to 59, and further.csv says what instruments at other places and a heavier drop
//          would read; middle: 20 to 40 readings
//   DATA   what the data have that the study does not state: understated, overstated (errors 1.5 times as large or as
//          small as stated), heavy (errors of Student's t with four degrees of freedom, of the stated deviation), bad
//          (two or three readings wrong by 7 to 15 deviations), common (each load's readings share an error of 1 to 3
//          %), tied (errors of neighbouring readings are alike), fault (of the file: two sensors exchanged, all counted
//          from the far end, one in another unit)
//
// The data come from a mesh 2.5 times as fine and from load paths ten times as exact as the study asks for. Half of the
// effects that are fields of the section have another form here than in the catalogue. The strength of an effect is
// what it changes in the data, in standard deviations, beyond what the parameters that will be fitted can follow at the
// truth, computed here from finite differences; so is how well it could be told from every other effect.
#include "blind/strength.h"

#include "base/units.h"
#include "pavement/effects/catalog.h"
#include "pavement/forward.h"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gsl/gsl_cdf.h>
#include <iostream>

namespace {

using namespace blind;

// What the study asks for: the strain at the top of the subgrade under the wheel.
Sensor output_sensor(const Case& c) {
    Sensor sensor;
    sensor.load = 1;
    sensor.quantity = Quantity::strain_zz;
    sensor.depth = c.layers[0].thickness + c.layers[1].thickness + unit::mm;
    sensor.measured = false;
    return sensor;
}

// noise: the text of [data.noise].
std::string study_text(const Case& c, Draw& draw, bool is_log, const std::string& noise) {
    std::string text = "schema = 1\ntitle = \"A section\"\n";
    for (std::size_t l = 0; l < c.layers.size(); ++l) {
        const Layer& layer = c.layers[l];
        text += fmt::format("\n[[layers]]\nname = \"{}\"\nthickness_mm = {:g}\ndensity_kg_m3 = {:g}\nk0 = {:g}\n",
                            layer.name, layer.thickness / unit::mm, layer.density, layer.k0);
        if (layer.law->stress_dependent()) {
            const double k3 = layer.parameters[*layer.law->index_of("k3")];
            text +=
                fmt::format("law = \"uzan\"\nk1 = {:.0f}\nk2 = 0.5\nk3 = {}\nn = 0.5\npoisson_12 = 0.35\npoisson_31 = "
                            "0.35\n",
                            draw.log_uniform(800.0, 3500.0), k3);
        } else {
            text += fmt::format("law = \"linear\"\nmodulus_MPa = {}\npoisson = {:g}\n", l == 0 ? 3000 : 50,
                                layer.parameters[1]);
        }
    }
    for (const Load& load : c.loads) {
        text += fmt::format("\n[[loads]]\nname = \"{}\"\n", load.name);
        text += load.type == LoadType::plate
                    ? fmt::format("type = \"plate\"\nradius_mm = 150\npressure_kPa = {:g}\n", load.pressure / unit::kPa)
                    : fmt::format("type = \"wheel\"\npatch = \"circle\"\nforce_kN = {:g}\npressure_kPa = {:g}\n",
                                  load.force / unit::kN, load.pressure / unit::kPa);
    }
    text += fmt::format("\n[mesh]\nrefine = {}\n\n[data]\nfiles = [\"data.csv\"]\nmisfit = \"{}\"\n",
                        study_refine(!noise.empty()), is_log ? "log" : "weighted") +
            noise;
    for (const Fitted& f : fitted) {
        text += fmt::format("\n[[parameters]]\nname = \"{}\"\nmin = {:g}\nmax = {:g}\nscale = \"{}\"\n", f.path, f.low,
                            f.high, f.is_log ? "log" : "linear");
    }
    return text + fmt::format("\n[[outputs]]\nname = \"subgrade-top-strain\"\nload = \"wheel\"\nquantity = "
                              "\"strain_zz\"\ndepth_mm = {:g}\n",
                              output_sensor(c).depth / unit::mm);
}

// Of the sensors from this one on.
std::string data_text(const Case& c, const VectorXd& values, const VectorXd& sigma, std::size_t first = 0) {
    std::string text = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n";
    for (std::size_t i = first; i < c.sensors.size(); ++i) {
        const Sensor& s = c.sensors[i];
        const auto& about = info(s.quantity);
        const auto at = static_cast<Eigen::Index>(i);
        text += fmt::format("{},{},{:g},0,{:g},{:g},{},{},{}\n", c.loads[static_cast<std::size_t>(s.load)].name,
                            about.name, s.x / unit::mm, s.depth / unit::mm, s.gauge / unit::mm,
                            values[at] / about.to_si, about.unit, sigma[at] / about.to_si);
    }
    return text;
}

// Writes further.csv; false: the section has no answer under the heavier drop.
bool write_further_readings(const Case& c, const std::vector<Hidden>& hidden, Draw& draw,
                            const std::filesystem::path& folder) {
    const Case more = with_further_readings(c);
    const VectorXd exact = responses_with(finer(more), hidden);
    if (exact.size() == 0) {
        return false;
    }
    VectorXd values = exact;
    VectorXd sigma = exact;
    for (Eigen::Index i = 0; i < exact.size(); ++i) {
        sigma[i] = common_noise(more.sensors[static_cast<std::size_t>(i)].quantity, exact[i]);
        values[i] += sigma[i] * draw.normal();
    }
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "further.csv") << data_text(more, values, sigma, c.sensors.size());
    return true;
}

constexpr const char* kinds_of_data[] = {"few", "middle", "understated", "overstated", "heavy",
                                         "bad", "common", "tied",        "fault",      "layout"};

// The numbers of the errors, in standard deviations, as the study does not state them.
void unlike_stated(const Case& c, Draw& draw, const std::string& data, VectorXd& numbers) {
    if (data == "understated") {
        numbers *= 1.5;
    } else if (data == "overstated") {
        numbers /= 1.5;
    } else if (data == "heavy") {
        constexpr double degrees = 4.0;
        for (double& number : numbers) {
            number = gsl_cdf_tdist_Pinv(gsl_cdf_ugaussian_P(number), degrees) / std::sqrt(degrees / (degrees - 2.0));
        }
    } else if (data == "tied") {
        constexpr double length = 0.3; // m
        Eigen::MatrixXd tied = Eigen::MatrixXd::Identity(numbers.size(), numbers.size());
        for (Eigen::Index i = 0; i < numbers.size(); ++i) {
            for (Eigen::Index k = 0; k < numbers.size(); ++k) {
                const Sensor& a = c.sensors[static_cast<std::size_t>(i)];
                const Sensor& b = c.sensors[static_cast<std::size_t>(k)];
                if (i != k) {
                    const double apart = std::hypot(a.x - b.x, a.y - b.y, a.depth - b.depth);
                    tied(i, k) = a.load == b.load && a.quantity == b.quantity ? std::exp(-apart / length) : 0.0;
                }
            }
        }
        const Eigen::MatrixXd root = tied.llt().matrixL();
        numbers = root * numbers;
    } else if (data == "bad") {
        const std::size_t count = 2 + draw.below(2);
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = static_cast<Eigen::Index>(draw.below(static_cast<std::size_t>(numbers.size())));
            numbers[at] = std::copysign(draw.uniform(7.0, 15.0), draw.uniform(-1.0, 1.0));
        }
    }
}

// What happens to the file: values and their stated deviations move or change their unit. What, in words.
Json spoil(const Case& c, Draw& draw, VectorXd& values, VectorXd& spread) {
    std::vector<double> places;
    for (const Sensor& sensor : c.sensors) {
        if (sensor.quantity == Quantity::deflection) {
            places.push_back(sensor.x);
        }
    }
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    const auto at = [&](int load, double x) {
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            const Sensor& sensor = c.sensors[i];
            if (sensor.load == load && sensor.quantity == Quantity::deflection && sensor.x == x) {
                return static_cast<Eigen::Index>(i);
            }
        }
        return Eigen::Index(-1);
    };
    const auto exchange = [&](double one, double other) {
        for (int load = 0; load < static_cast<int>(c.loads.size()); ++load) {
            const Eigen::Index a = at(load, one);
            const Eigen::Index b = at(load, other);
            if (a >= 0 && b >= 0) {
                std::swap(values[a], values[b]);
                std::swap(spread[a], spread[b]);
            }
        }
    };
    switch (draw.below(3)) {
    case 0: {
        const std::size_t i = draw.below(places.size() - 2);
        exchange(places[i], places[i + 1]);
        return {{"fault", "exchanged"}, {"at_mm", {1e3 * places[i], 1e3 * places[i + 1]}}};
    }
    case 1: // the line of each load's own sensors
        for (int load = 0; load < static_cast<int>(c.loads.size()); ++load) {
            std::vector<Eigen::Index> line;
            for (const double place : places) {
                if (const Eigen::Index i = at(load, place); i >= 0) {
                    line.push_back(i);
                }
            }
            for (std::size_t i = 0; i < line.size() / 2; ++i) {
                std::swap(values[line[i]], values[line[line.size() - 1 - i]]);
                std::swap(spread[line[i]], spread[line[line.size() - 1 - i]]);
            }
        }
        return {{"fault", "counted from the far end"}};
    default: {
        constexpr double factors[] = {10.0, 25.4, 1000.0, 1.0 / 25.4};
        const double factor = factors[draw.below(std::size(factors))];
        const double place = places[1 + draw.below(places.size() - 3)];
        for (int load = 0; load < static_cast<int>(c.loads.size()); ++load) {
            if (const Eigen::Index i = at(load, place); i >= 0) {
                values[i] *= factor;
                spread[i] *= factor;
            }
        }
        return {{"fault", "another unit"}, {"at_mm", {1e3 * place}}, {"factor", factor}};
    }
    }
}

int generate(std::uint64_t seed, const std::filesystem::path& folder, const std::string& kind, const Strength& strength,
             bool correlated, const std::string& data) {
    const bool few = data == "few";
    for (std::uint64_t attempt = 0;; ++attempt) {
        Draw draw(seed, 1000 + attempt);
        Case c = draw_case(draw);
        if (few) {
            keep_few(c);
        } else if (data == "middle") {
            keep_middle(c, draw);
        }
        Json truth = {{"seed", seed}};
        const Case stated = data == "layout" ? lay_out(c, draw, truth) : c;
        const Case fine = finer(c);
        Case coarse = c;
        coarse.settings.refine = study_refine(correlated);
        const VectorXd plain = responses(fine);
        const VectorXd plain_coarse = responses(coarse);
        if (plain.size() == 0 || plain_coarse.size() == 0) {
            continue;
        }
        const double noise = draw.uniform(0.01, 0.05);
        const auto sigma_of = [&](const VectorXd& values) {
            VectorXd sigma(values.size());
            for (Eigen::Index i = 0; i < values.size(); ++i) {
                double largest = 0.0;
                for (Eigen::Index k = 0; k < values.size(); ++k) {
                    const Sensor& a = c.sensors[static_cast<std::size_t>(i)];
                    const Sensor& b = c.sensors[static_cast<std::size_t>(k)];
                    if (a.load == b.load && a.quantity == b.quantity) {
                        largest = std::max(largest, std::abs(values[k]));
                    }
                }
                sigma[i] = std::hypot(noise * values[i], 0.3 * noise * largest);
            }
            return sigma;
        };
        const auto common_of = [&](const VectorXd& values) -> VectorXd {
            return (correlated ? in_common * noise : 0.0) * values;
        };
        const Errors errors = errors_of(c, sigma_of(plain), common_of(plain));
        const Eigen::MatrixXd slopes = derivatives(coarse, errors);
        if (slopes.size() == 0) {
            continue;
        }
        const Eigen::MatrixXd base = orthonormal(slopes);
        std::vector<Hidden> hidden;
        std::vector<double> strengths;
        const std::size_t count = kind == "none" ? 0 : kind == "two" ? 2 : 1;
        for (int tried = 0; hidden.size() < count && tried < 12; ++tried) {
            Hidden drawn = draw_hidden(draw, c, kind);
            AppliedEffect applied = drawn.options;
            applied.effect = drawn.effect;
            const bool is_new =
                std::none_of(hidden.begin(), hidden.end(), [&](const Hidden& h) { return h.effect == drawn.effect; });
            if (!is_new || (drawn.effect != nullptr && !why_impossible(c, applied).empty())) {
                continue;
            }
            const double wanted = draw.uniform(strength.least, strength.most);
            if (auto found = sized(draw, coarse, drawn, plain_coarse, base, errors, wanted)) {
                hidden.push_back(*found);
                strengths.push_back(wanted);
            }
        }
        if (hidden.size() < count) {
            continue;
        }
        const VectorXd exact = count == 0 ? plain : responses_with(fine, hidden);
        if (exact.size() == 0) {
            continue;
        }
        truth["noise"] = noise;
        truth["readings"] = c.sensors.size();
        truth["hidden"] = Json::array();
        std::vector<VectorXd> changes;
        double weakest = std::numeric_limits<double>::infinity();
        for (const Hidden& h : hidden) {
            const VectorXd change = errors.in_units(responses_with(fine, {h}) - plain);
            changes.push_back(beyond(base, change));
            const double left = remaining(coarse, plain_coarse, change, errors);
            weakest = std::min(weakest, left);
            Json one = words(c, h);
            one["strength"] = left;
            truth["hidden"].push_back(one);
        }
        if (weakest < strength.least) {
            continue;
        }
        if (count == 2) { // each beyond what the other can mimic
            const double cosine = changes[0].dot(changes[1]) / (changes[0].norm() * changes[1].norm());
            const double left = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
            if (std::min(changes[0].norm(), changes[1].norm()) * left < strength.least) {
                continue;
            }
        }
        if (count == 1) {
            add_ceiling(truth, coarse, hidden[0], changes[0], weakest, base, errors);
        }
        VectorXd spread = sigma_of(exact);
        VectorXd numbers(exact.size());
        for (double& number : numbers) {
            number = draw.normal();
        }
        const VectorXd as_drawn = numbers;
        unlike_stated(c, draw, data, numbers);
        VectorXd values = exact + errors_of(c, spread, common_of(exact)).root * numbers;
        if (data == "bad") {
            truth["bad"] = Json::array();
            for (Eigen::Index i = 0; i < numbers.size(); ++i) {
                if (numbers[i] != as_drawn[i]) {
                    truth["bad"].push_back(i + 1);
                }
            }
        }
        if (data == "common") {
            const double common = draw.uniform(0.01, 0.03);
            for (std::size_t load = 0; load < c.loads.size(); ++load) {
                const double error = common * draw.normal();
                for (Eigen::Index i = 0; i < values.size(); ++i) {
                    const bool is_of_load =
                        static_cast<std::size_t>(c.sensors[static_cast<std::size_t>(i)].load) == load;
                    values[i] += is_of_load ? error * exact[i] : 0.0;
                }
            }
        }
        if (data == "fault") {
            truth["spoilt"] = spoil(c, draw, values, spread);
        }
        if (few && !write_further_readings(c, hidden, draw, folder)) {
            continue;
        }
        std::filesystem::create_directories(folder);
        const bool is_log = draw.chance(0.3) && !correlated; // correlations need residuals in units of the noise
        const std::string said = fmt::format("\n[data.noise]\ncommon_relative = {}\ncorrelation_mm = {}\n",
                                             in_common * noise, correlated_mm);
        const std::string text = study_text(c, draw, is_log, correlated ? said : "");
        std::ofstream(folder / "study.toml") << text;
        std::ofstream(folder / "data.csv") << data_text(stated, values, spread);
        if (correlated) {
            std::string independent = text;
            independent.erase(independent.find(said), said.size());
            const std::string file = "data.csv";
            independent.replace(independent.find(file), file.size(), "independent.csv");
            std::ofstream(folder / "independent.toml") << independent;
            const VectorXd whole = (spread.cwiseAbs2() + common_of(exact).cwiseAbs2()).cwiseSqrt();
            std::ofstream(folder / "independent.csv") << data_text(c, values, whole);
        }
        Json parameters = Json::object();
        for (const Fitted& f : fitted) {
            parameters[f.path] = find_parameter(c, f.path, {}).get(c);
        }
        truth["parameters"] = parameters;
        // What the output is on the road: errors of readings and of where a load stands do not change it; that of a
        // load's size does, for it is asked under that load.
        std::vector<Hidden> of_road;
        for (const Hidden& h : hidden) {
            const std::string name = h.name();
            const auto is = [&](const char* part) { return name.find(part) != std::string::npos; };
            const bool of_readings = h.outside != nullptr && h.outside->layer.empty();
            if (!of_readings && !is("gauge") && !is("sensor") && !is("load-offset") && !is("outlier") && !is("drift") &&
                !is("wander") && !is("inertia")) {
                of_road.push_back(h);
            }
        }
        Case asked = fine;
        asked.sensors = {output_sensor(c)};
        const VectorXd there = of_road.empty() ? responses(asked) : responses_with(asked, of_road);
        truth["output"] = there.size() > 0 ? Json(1e6 * there[0]) : Json(nullptr);
        std::cout << truth.dump() << "\n";
        return 0;
    }
}

} // namespace

int main(int argc, char** argv) {
    std::vector<std::string> words(argv + 1, argv + argc);
    const bool correlated = !words.empty() && words.back() == "correlated";
    const bool is_data = !words.empty() && std::find(std::begin(kinds_of_data), std::end(kinds_of_data),
                                                     words.back()) != std::end(kinds_of_data);
    const std::string data = is_data ? words.back() : "";
    if (correlated || is_data) {
        words.pop_back();
    }
    if (words.size() != 3 && words.size() != 5) {
        std::cerr << "usage: blind_generator SEED FOLDER KIND [LEAST MOST] [correlated | few | middle | DATA]\n";
        return 2;
    }
    Strength strength;
    if (words.size() == 5) {
        strength = {std::stod(words[3]), std::stod(words[4])};
    }
    return generate(std::stoull(words[0]), words[1], words[2], strength, correlated, data);
}
