// pavescape survey: a road of FWD stations; deflection ratios, and the parameters of a study at every station.
#include "base/units.h"
#include "analysis/build.h"
#include "cli/commands.h"
#include "data/csv.h"
#include "landscape/batch.h"
#include "landscape/multistart.h"
#include "base/text.h"
#include "report/text.h"
#include "run/files.h"
#include "run/progress.h"
#include "study/problems.h"
#include "study/station.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <mutex>
#include <tuple>

namespace explore::cli {
namespace {

using pave::counted;
using pave::figure;

struct SurveyOptions {
    CommonOptions common;
    std::vector<std::string> files;
};

constexpr int explored_points = 256; // once for the road
constexpr int searches = 4;          // at each station: one bowl tells few parameters, and a road has many stations

constexpr const char* ratio_words =
    "deflection ratio: D250/D0, the deflection 250 mm from the load centre over the one "
    "at the centre (as cited from the Austroads Guide to Pavement Technology Part 5)";
constexpr const char* interpolation_words = "interpolated linearly in ln(deflection) between the nearest sensors";

enum class State { ok, rejected, failed };
constexpr std::string_view state_words[] = {"ok", "rejected", "failed"};

// The best set of parameters of a station.
struct StationFit {
    landscape::Minimum best;
    std::size_t minima = 0;
    std::size_t starts = 0;
    double rms_percent = 0.0; // of the relative differences
};

struct Row {
    data::FwdStation station;
    pave::Outcome<data::DeflectionBowl> bowl;
    State state = State::ok;
    std::string reason{}; // when not ok
    std::optional<StationFit> fit{};

    bool rejected() const { return state == State::rejected; }
    std::optional<double> ratio() const { return rejected() ? std::nullopt : bowl->deflection_ratio(); }
    // "pass", "fail", or "" without a ratio.
    std::string verdict() const { return !ratio() ? "" : *ratio() >= data::deflection_ratio_limit ? "pass" : "fail"; }
};

struct Survey {
    std::vector<Row> rows;        // along the road, lane by lane
    double common_pressure = 0.0; // kPa: the median of the stations
    std::optional<study::Study> study;
    std::int64_t computed = 0; // model runs of this process
    int stations_computed = 0;
    double seconds = 0.0;

    double d0_at_common(const Row& row) const { return row.bowl->d0_um() * common_pressure / row.bowl->pressure_kPa; }
    std::size_t count(const std::function<bool(const Row&)>& is) const {
        return static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), is));
    }
    std::vector<std::string> parameter_names() const {
        std::vector<std::string> names;
        if (study) {
            for (const auto& axis : study->space.axes) {
                names.push_back(axis.name);
            }
        }
        return names;
    }
};

Survey read_survey(const std::vector<std::string>& files) {
    Survey survey;
    std::vector<double> pressures;
    for (const std::string& file : files) {
        for (auto& station : data::read_fwd(file)) {
            auto bowl = data::bowl_of(station);
            Row row{std::move(station), std::move(bowl)};
            if (row.bowl) {
                pressures.push_back(row.bowl->pressure_kPa);
            } else {
                row.state = State::rejected;
                row.reason = row.bowl.failure().reason;
            }
            survey.rows.push_back(std::move(row));
        }
    }
    std::stable_sort(survey.rows.begin(), survey.rows.end(), [](const Row& a, const Row& b) {
        return std::tie(a.station.lane, a.station.chainage_m) < std::tie(b.station.lane, b.station.chainage_m);
    });
    if (!pressures.empty()) {
        survey.common_pressure = data::median(pressures);
    }
    return survey;
}

double rms_percent(const problem::Problem& problem, const std::vector<double>& responses) {
    double sum = 0.0;
    for (std::size_t i = 0; i < problem.readings(); ++i) {
        sum += std::pow(responses[problem.response_of(i)] / problem.measured(i) - 1.0, 2);
    }
    return 100.0 * std::sqrt(sum / static_cast<double>(problem.readings()));
}

// What is explored once for all stations with one plate and one set of sensors: the responses at the points of a
// design, under the common pressure. Nothing: interrupted.
class Exploration {
public:
    Exploration(const Survey& survey, search::Design design, analysis::Session& session)
        : survey_(survey),
          design_(std::move(design)),
          session_(session) {}

    struct Starts {
        std::vector<std::vector<double>> points;
        std::string why_none; // when there is no point
    };

    // Points from which to search at a station: the best by the explored responses, in proportion to its pressure. That
    // is exact for a linear pavement and near enough to choose starts for another.
    std::optional<Starts> starts(const Row& row, const problem::Problem& problem,
                                 const landscape::MultistartSettings& settings) {
        auto* explored = at(row);
        if (explored == nullptr) {
            return std::nullopt;
        }
        std::vector<problem::Evaluation> scaled = *explored;
        for (auto& e : scaled) {
            for (double& response : e.responses) {
                response *= row.bowl->pressure_kPa / survey_.common_pressure;
            }
            e.misfit = e.converged() ? problem.misfit(e) : e.misfit;
        }
        Starts starts;
        for (const std::size_t i : run::distinct_starts(design_, scaled, settings.starts, settings.start_distance)) {
            starts.points.push_back(design_.points[i]);
        }
        if (starts.points.empty()) {
            starts.why_none = "not one explored point has an answer; the first says: " + explored->front().reason;
        }
        return starts;
    }

    const run::Tally& tally() const { return tally_; }

private:
    const std::vector<problem::Evaluation>* at(const Row& row) {
        std::vector<double> layout{row.bowl->radius_mm};
        for (const auto& reading : row.bowl->readings) {
            layout.push_back(reading.offset_mm);
        }
        if (const auto known = explored_.find(layout); known != explored_.end()) {
            return &known->second;
        }
        data::DeflectionBowl bowl = *row.bowl;
        bowl.pressure_kPa = survey_.common_pressure;
        const study::Study study = study::station_study(*survey_.study, row.station, bowl);
        const problem::Problem problem = study::make_problem(study);
        auto engine =
            session_.engine(problem, session_.begin(study, "survey", "explored: " + design_.run_name()));
        auto evaluations = engine.evaluate(design_);
        tally_.computed += engine.tally().computed;
        if (!evaluations) {
            return nullptr;
        }
        return &explored_.emplace(std::move(layout), std::move(*evaluations)).first->second;
    }

    const Survey& survey_;
    search::Design design_;
    analysis::Session& session_;
    std::map<std::vector<double>, std::vector<problem::Evaluation>> explored_; // by plate radius and offsets
    run::Tally tally_;
};

// Back-calculates every station that is not rejected. False: interrupted; what was computed is in the store.
bool fit_stations(Survey& survey, const CommonOptions& options, const std::string& folder) {
    landscape::MultistartSettings settings;
    settings.starts = searches;
    const auto design = search::sobol(survey.study->space, explored_points, options.seed);
    std::vector<study::Study> studies;
    std::vector<landscape::BatchItem> items;
    std::vector<Row*> rows; // of the items
    std::optional<pave::Error> complaint;
    for (Row& row : survey.rows) {
        if (row.rejected()) {
            continue;
        }
        try {
            auto study = study::station_study(*survey.study, row.station, *row.bowl);
            items.push_back({.problem = study::make_problem(study), .run = 0, .starts = {}});
            studies.push_back(std::move(study));
            rows.push_back(&row);
        } catch (const pave::Error& error) {
            row.state = State::failed;
            row.reason = error.what();
            complaint = complaint ? complaint : error;
        }
    }
    if (items.empty() && complaint) {
        throw *complaint;
    }
    const auto begin = std::chrono::steady_clock::now();
    analysis::Session session(options.run(folder));
    std::vector<std::string> why_none; // should a station end without a result
    Exploration exploration(survey, design, session);
    for (std::size_t i = 0; i < items.size(); ++i) {
        auto starts = exploration.starts(*rows[i], items[i].problem, settings);
        if (!starts) {
            return false;
        }
        items[i].starts = std::move(starts->points);
        why_none.push_back(starts->why_none.empty() ? "no start has an answer under the load of this station"
                                                    : std::move(starts->why_none));
        const auto& station = rows[i]->station;
        items[i].run = session.begin(
            studies[i], "survey",
                       fmt::format("station {} at {} m; {} at {} kPa; {} starts, distance {}; {}",
                                   pave::join(station.lane.empty() ? std::vector{station.name}
                                                                   : std::vector{station.name, station.lane}),
                                   station.chainage_m, design.name, survey.common_pressure, settings.starts,
                                   settings.start_distance, settings.method));
    }

    run::Progress progress("survey", static_cast<std::int64_t>(items.size()), {"stations/min", 60.0});
    std::mutex mutex;
    std::size_t finished = 0;
    const auto keep = [&](std::size_t i, const std::vector<run::Endpoint>& ends, const run::Tally& tally) {
        progress.add(1, tally.computed > 0);
        const auto minima = landscape::distinct_minima(ends, items[i].problem);
        const std::scoped_lock lock(mutex);
        ++finished;
        survey.computed += tally.computed;
        survey.stations_computed += tally.computed > 0 ? 1 : 0;
        Row& row = *rows[i];
        if (minima.empty()) {
            row.state = State::failed;
            row.reason = why_none[i];
            return;
        }
        row.fit = StationFit{minima[0], minima.size(), ends.size(),
                             rms_percent(items[i].problem, minima[0].evaluation.responses)};
    };
    landscape::search_batch(items, *session.store(), *optimise::find_method(settings.method), settings.search, options.threads,
                            keep);
    survey.computed += exploration.tally().computed;
    survey.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return finished == items.size();
}

// What a reader should know of a station besides its numbers.
std::string remark(const Survey& survey, const Row& row) {
    if (row.state != State::ok) {
        return std::string(state_words[static_cast<int>(row.state)]) + ": " + row.reason;
    }
    std::string text = row.fit ? pave::join(bound_words(survey.study->space, row.fit->best.on_bound)) : "";
    if (row.fit && !row.fit->best.converged) {
        text += (text.empty() ? "" : "; ") + std::string("search not converged");
    }
    return text;
}

std::string station_table(const Survey& survey) {
    const bool lanes = survey.count([](const Row& row) { return !row.station.lane.empty(); }) > 0;
    std::vector<std::string> header{"station"};
    if (lanes) {
        header.emplace_back("lane");
    }
    for (const std::string& name : {std::string("chainage m"), std::string("drops"), std::string("pressure kPa"),
                                    fmt::format("D0 um at {} kPa", figure(survey.common_pressure)),
                                    std::string("D250/D0"), std::string("ratio")}) {
        header.push_back(name);
    }
    const auto names = survey.parameter_names();
    header.insert(header.end(), names.begin(), names.end());
    if (survey.study) {
        header.insert(header.end(), {"misfit", "RMS %", "starts"});
    }
    header.emplace_back("remark");
    report::Table table(header);
    for (const Row& row : survey.rows) {
        std::vector<std::string> cells{row.station.name};
        if (lanes) {
            cells.push_back(row.station.lane);
        }
        cells.push_back(fmt::format("{:g}", row.station.chainage_m));
        if (row.rejected()) {
            cells.resize(header.size() - 1);
        } else {
            cells.push_back(fmt::format("{}", row.bowl->drops.size()));
            cells.push_back(figure(row.bowl->pressure_kPa));
            cells.push_back(figure(survey.d0_at_common(row)));
            cells.push_back(
                row.ratio() ? fmt::format("{}{:.3f}", row.bowl->d250_is_interpolated ? "~" : "", *row.ratio()) : "");
            cells.push_back(row.verdict());
            if (row.fit) {
                for (const double value : row.fit->best.evaluation.parameters) {
                    cells.push_back(figure(value));
                }
                cells.push_back(figure(row.fit->best.evaluation.misfit));
                cells.push_back(fmt::format("{:.2f}", row.fit->rms_percent));
                cells.push_back(fmt::format("{}/{}", row.fit->best.members.size(), row.fit->starts));
            }
            cells.resize(header.size() - 1);
        }
        cells.push_back(remark(survey, row));
        table.add(std::move(cells));
    }
    return table.text();
}

// One mark a station, or a few stations, along the road: the verdicts, and a line for each quantity.
std::string strip_chart(const Survey& survey) {
    constexpr std::size_t width = 100;
    const std::size_t n = survey.rows.size();
    const std::size_t group = (n + width - 1) / width;
    // The median of those of each group that have a value.
    const auto line = [&](const std::string& name, const std::string& unit, bool is_log,
                          const std::function<std::optional<double>(const Row&)>& value_of) {
        std::vector<double> marks;
        double low = INFINITY;
        double high = -INFINITY;
        for (std::size_t i = 0; i < n; i += group) {
            std::vector<double> values;
            for (std::size_t k = i; k < std::min(n, i + group); ++k) {
                if (const auto value = value_of(survey.rows[k])) {
                    values.push_back(*value);
                }
            }
            const double mark = values.empty() ? NAN : data::median(values);
            low = std::fmin(low, mark);
            high = std::fmax(high, mark);
            marks.push_back(is_log ? std::log(mark) : mark);
        }
        return std::vector<std::string>{
            name, report::sparkline(marks),
            low <= high ? fmt::format("{} to {}{}", figure(low), figure(high), unit.empty() ? "" : " " + unit) : ""};
    };
    std::string verdicts;
    for (std::size_t i = 0; i < n; i += group) {
        const auto any = [&](const auto& is) {
            return std::any_of(survey.rows.begin() + static_cast<std::ptrdiff_t>(i),
                               survey.rows.begin() + static_cast<std::ptrdiff_t>(std::min(n, i + group)), is);
        };
        verdicts += any([](const Row& row) { return row.verdict() == "fail"; })   ? 'x'
                    : any([](const Row& row) { return row.verdict() == "pass"; }) ? '.'
                                                                                  : '?';
    }
    report::Table table({"", fmt::format("one mark: {}", counted(group, "station", "stations")), "lowest to highest"});
    table.add({"ratio", verdicts, ". pass, x fail, ? none"});
    table.add(line("D250/D0", "", false, [](const Row& row) { return row.ratio(); }));
    table.add(line(fmt::format("D0 at {} kPa", figure(survey.common_pressure)), "um", false, [&](const Row& row) {
        return row.rejected() ? std::nullopt : std::optional(survey.d0_at_common(row));
    }));
    for (std::size_t k = 0; survey.study && k < survey.study->space.axes.size(); ++k) {
        const problem::Axis& axis = survey.study->space.axes[k];
        table.add(line(axis.name, "", axis.scale == problem::Scale::log, [&](const Row& row) {
            return row.fit ? std::optional(row.fit->best.evaluation.parameters[k]) : std::nullopt;
        }));
    }
    return table.text();
}

report::Json row_json(const Survey& survey, const Row& row) {
    const auto& s = row.station;
    report::Json json = {{"station", s.name},
                         {"lane", s.lane},
                         {"chainage_m", s.chainage_m},
                         {"file", s.file},
                         {"line", s.line},
                         {"air_C", report::optional_json(s.air_C)},
                         {"surface_C", report::optional_json(s.surface_C)},
                         {"drops", s.drops.size()},
                         {"status", state_words[static_cast<int>(row.state)]},
                         {"reason", row.reason}};
    if (row.rejected()) {
        return json;
    }
    const auto& bowl = *row.bowl;
    json["drops_used"] = bowl.drops;
    json["radius_mm"] = bowl.radius_mm;
    json["pressure_kPa"] = bowl.pressure_kPa;
    json["D0_um"] = bowl.d0_um();
    json["D0_um_at_common_pressure"] = survey.d0_at_common(row);
    json["D250_um"] = report::optional_json(bowl.d250_um);
    json["D250_is_interpolated"] = bowl.d250_is_interpolated;
    json["deflection_ratio"] = report::optional_json(row.ratio());
    json["pass"] = row.ratio() ? report::Json(row.verdict() == "pass") : report::Json(nullptr);
    json["readings"] = report::Json::array();
    for (std::size_t i = 0; i < bowl.readings.size(); ++i) {
        report::Json reading = {{"offset_mm", bowl.readings[i].offset_mm},
                                {"measured_um", bowl.readings[i].deflection_um}};
        if (row.fit) {
            reading["model_um"] = row.fit->best.evaluation.responses[i] / pave::unit::um;
        }
        json["readings"].push_back(std::move(reading));
    }
    if (row.fit) {
        const landscape::Minimum& best = row.fit->best;
        json["fit"] = {{"parameters", report::parameters_json(survey.study->space, best.evaluation.parameters)},
                       {"misfit", best.evaluation.misfit},
                       {"rms_percent", row.fit->rms_percent},
                       {"status", std::string(to_string(best.evaluation.status))},
                       {"converged", best.converged},
                       {"on_bound", bound_words(survey.study->space, best.on_bound)},
                       {"starts", row.fit->starts},
                       {"starts_in_best", best.members.size()},
                       {"minima", row.fit->minima},
                       {"warnings", best.evaluation.warnings}};
    }
    return json;
}

report::Json survey_json(const Survey& survey, const SurveyOptions& options, const std::string& folder) {
    report::Json json = {{"stations", report::Json::array()},
                         {"counts",
                          {{"stations", survey.rows.size()},
                           {"rejected", survey.count([](const Row& row) { return row.rejected(); })},
                           {"pass", survey.count([](const Row& row) { return row.verdict() == "pass"; })},
                           {"fail", survey.count([](const Row& row) { return row.verdict() == "fail"; })},
                           {"fitted", survey.count([](const Row& row) { return row.fit.has_value(); })},
                           {"failed", survey.count([](const Row& row) { return row.state == State::failed; })}}},
                         {"deflection_ratio",
                          {{"definition", ratio_words},
                           {"limit", data::deflection_ratio_limit},
                           {"interpolation", interpolation_words}}},
                         {"common_pressure_kPa", survey.common_pressure},
                         {"files", options.files},
                         {"version", analysis::version},
                         {"run", folder}};
    for (const Row& row : survey.rows) {
        json["stations"].push_back(row_json(survey, row));
    }
    if (survey.study) {
        const study::Study& study = *survey.study;
        json["study"] = {{"file", study.file}, {"title", study.title}, {"hash", study.hash}};
        json["misfit_kind"] = std::string(to_string(study.data.misfit));
        json["explored_points"] = explored_points;
        json["seed"] = options.common.seed;
    }
    return json;
}

// A line a station: what a spreadsheet or a map wants.
std::string survey_csv(const Survey& survey) {
    std::string text = "station,lane,chainage_m,status,reason,radius_mm,pressure_kPa,D0_um,D0_um_at_common_pressure,"
                       "D250_um,D250_is_interpolated,deflection_ratio,verdict";
    const auto names = survey.parameter_names();
    for (const std::string& name : names) {
        text += "," + data::csv_cell(name);
    }
    text += survey.study ? ",misfit,rms_percent,converged,on_bound\n" : "\n";
    for (const Row& row : survey.rows) {
        const auto& s = row.station;
        text += fmt::format("{},{},{},{},{}", data::csv_cell(s.name), data::csv_cell(s.lane), s.chainage_m,
                            state_words[static_cast<int>(row.state)], data::csv_cell(row.reason));
        if (row.rejected()) {
            text += ",,,,,,,,";
        } else {
            const auto number = [](std::optional<double> value) { return value ? fmt::format("{}", *value) : ""; };
            text += fmt::format(",{},{},{},{},{},{},{},{}", row.bowl->radius_mm, row.bowl->pressure_kPa,
                                row.bowl->d0_um(), survey.d0_at_common(row), number(row.bowl->d250_um),
                                row.bowl->d250_is_interpolated, number(row.ratio()), row.verdict());
        }
        if (row.fit) {
            const landscape::Minimum& best = row.fit->best;
            for (const double value : best.evaluation.parameters) {
                text += fmt::format(",{}", value);
            }
            text += fmt::format(",{},{},{},{}", best.evaluation.misfit, row.fit->rms_percent, best.converged,
                                data::csv_cell(pave::join(bound_words(survey.study->space, best.on_bound))));
        } else if (survey.study) {
            text += std::string(names.size() + 4, ',');
        }
        text += "\n";
    }
    return text;
}

int survey_road(const SurveyOptions& options) {
    Survey survey = read_survey(options.files);
    const std::string folder = options.common.out.empty() ? "output/survey" : options.common.out;
    if (!options.common.study.empty()) {
        survey.study = study::load_survey_study(options.common.study);
        if (!fit_stations(survey, options.common, folder)) {
            return report_interrupt(folder);
        }
    }
    const report::Json json = survey_json(survey, options, folder);
    run::write_file(folder, "survey.csv", survey_csv(survey));
    run::write_file(folder, "survey.json", report::json_text(json) + "\n");
    const auto& counts = json["counts"];
    const bool nothing = survey.study ? counts["fitted"] == 0 : counts["rejected"] == counts["stations"];
    const int status = nothing ? computation_failed : done;
    if (options.common.json) {
        fmt::print("{}\n", report::json_text(json));
        return status;
    }
    if (survey.study) {
        fmt::print("{}\n", report::study_summary(*survey.study));
    }
    fmt::print("{}: {} pass, {} fail, {} rejected", counted(survey.rows.size(), "station", "stations"),
               counts["pass"].get<int>(), counts["fail"].get<int>(), counts["rejected"].get<int>());
    if (survey.study) {
        fmt::print("; {} back-calculated, {} failed\n  {} in {}", counts["fitted"].get<int>(),
                   counts["failed"].get<int>(), counted(static_cast<std::size_t>(survey.computed), "run", "runs"),
                   run::duration_words(survey.seconds));
        if (survey.stations_computed > 0) {
            fmt::print(" ({:.1f} stations per minute)", 60.0 * survey.stations_computed / survey.seconds);
        }
    }
    fmt::print(
        "\n\n  {}\n  pass: {:g} or more; ~: D250 {}\n  deflections: um, positive down; pressure: under the plate, "
        "median of the drops used\n",
        ratio_words, data::deflection_ratio_limit, interpolation_words);
    if (survey.study) {
        fmt::print("  misfit: {} residuals; RMS: of the relative differences of the deflections; starts: searches that "
                   "ended in the best minimum\n",
                   to_string(survey.study->data.misfit));
    }
    fmt::print("\n{}\nAlong the road\n{}\n  results: {}/survey.csv, survey.json\n", station_table(survey),
               strip_chart(survey), folder);
    return status;
}

} // namespace

void add_survey(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("survey", "a road of FWD stations: deflection ratios, back-calculation of every station");
    auto options = std::make_shared<SurveyOptions>();
    command->add_option("FILE", options->files, "measured FWD files")->required();
    command->add_option("--study", options->common.study, "study (TOML) whose section and parameters are fitted");
    add_run_options(*command, options->common, "output/survey");
    command->footer("Example: pavescape survey grids/road-example.csv --study grids/road-example.toml");
    command->callback([=, &action] { action = [=] { return survey_road(*options); }; });
}

} // namespace explore::cli
