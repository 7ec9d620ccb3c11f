// The start of back-calculating a road, station by station or all at once: the stations with their bowls, a problem
// each, and starts for its searches.
#pragma once

#include "analysis/survey/survey.h"
#include "landscape/multistart.h"
#include "search/design.h"

namespace explore::analysis {

// The stations of the files along the road, with bowls, indices and temperatures; nothing is fitted.
SurveyResult begin_survey(std::vector<data::FwdFile> files, std::optional<study::Study> survey_study,
                          const SurveyOptions& options);
// Derived from the fits: moduli at the reference temperature, values typical of sections, a suspect sensor.
void finish_survey(SurveyResult& result);

// A station that can be fitted.
struct StationTask {
    StationResult* station = nullptr;
    std::vector<std::size_t> levels; // of its bowls that are fitted
    study::Study study;              // study::station_study
    problem::Problem problem;

    std::vector<const data::DeflectionBowl*> bowls() const;
    data::DeflectionBowl layout() const; // a bowl with the sensors of all these
    std::string words() const;           // "station P07, L1 at 350 m"
};

// Radius [mm] of the plate and offsets [mm] of the sensors: what stations share that one exploration serves.
std::vector<double> layout_key(const data::DeflectionBowl& layout);
// Of each of these readings the number of the sensor of the layout that stands there.
std::vector<std::size_t> sensors_of(const data::DeflectionBowl& bowl, const data::DeflectionBowl& layout);

// One for every station with a bowl and at least `unknowns` readings; the others become `failed`. make_problem: of the
// station's study. Throws pave::Error where it does so for the stations, and none is left.
std::vector<StationTask> station_tasks(SurveyResult& result, std::size_t unknowns,
                                       const std::function<problem::Problem(const study::Study&)>& make_problem);

// Nothing but what the readings say of the best point: the fit without ranges and statistics.
StationFit fit_at(const StationTask& task, const landscape::Minimum& best);
// Its state by the fit that it has.
void judge_fit(StationResult& s);

// The 95 % range of a parameter about a point in unit coordinates. half: its half width, in the same.
ParameterRange range_about(const problem::Axis& axis, double unit, double half);
// The same of its ends; the value is left to the caller.
ParameterRange range_between(const problem::Axis& axis, double low, double high);

class Networks;

// Exploration shared by all stations with one plate and one set of sensors: the responses at the points of a
// design, under the common pressure. Nothing: interrupted.
class Exploration {
public:
    // command: under which the run is kept; networks: models that explore where there is one. All but the design must
    // outlive this.
    Exploration(const SurveyResult& result, search::Design design, Session& session, std::string command,
                const Networks* networks = nullptr);

    struct Starts {
        std::vector<std::vector<double>> points;
        std::string why_none; // when there is no point
    };

    // Points from which to search at a station: the best by the explored responses, in proportion to its pressures.
    // That is exact for a linear pavement and near enough to choose starts for another.
    std::optional<Starts> starts(const StationTask& task, const landscape::MultistartSettings& settings);

    const search::Design& design() const { return design_; }
    const run::Tally& tally() const { return tally_; } // of the full model

private:
    const std::vector<problem::Evaluation>* at(const StationResult& s, data::DeflectionBowl bowl);

    const SurveyResult& result_;
    search::Design design_;
    Session& session_;
    std::string command_;
    const Networks* networks_;
    std::map<std::vector<double>, std::vector<problem::Evaluation>> explored_; // by plate radius and offsets
    run::Tally tally_;
};

} // namespace explore::analysis
