// A road as one experiment: what the stations have in common, the material, is one unknown of all of them.
#pragma once

#include "analysis/survey/survey.h"
#include "diagnose/diagnosis.h"

namespace explore::analysis {

// A parameter that the stations of the road, or of a section, have in common.
struct CommonParameter {
    std::size_t axis = 0;
    std::optional<std::size_t> section{}; // of the survey's
    ParameterRange range;
    std::size_t stations = 0; // that tell of it
    // Widths of 95 % ranges as shares of the box, ends beyond it cut off: of the range above, and the median of what
    // each of those stations says by itself.
    double width = 0.0, alone_width = 0.0;
    double narrower = 1.0; // standard error of the median station by itself over that of the road; nothing is cut off
    std::size_t alone_determined = 0; // stations that determine it by themselves
};

// The 95 % region of two parameters that the whole road has in common: the landscape of the material around its answer,
// to first order.
struct CommonRegion {
    std::size_t a = 0, b = 0;                        // of RoadResult::common
    std::vector<std::pair<double, double>> border{}; // closed, file units, within the box
};

// A station against what all say.
struct RoadStation {
    std::size_t station = 0;              // of the survey's
    std::optional<std::size_t> section{}; // of the survey's
    // Sum of squared residuals in units of the stated noise, and what is expected of it where the station belongs to
    // the road: readings less what its own and the common parameters follow of them.
    double chi2 = 0.0, dof = 0.0;
    double p_familywise = 1.0;           // that chance gives so much at any of the stations (Holm 1979)
    bool is_outlier = false;             // then the common parameters are found without it
    double chi2_alone = 0.0;             // with common parameters of its own
    std::vector<ParameterRange> alone{}; // by itself, of all parameters
};

enum class OutlierCause {
    sensor,       // without one sensor it fits
    common,       // with a material of its own it fits
    unlike,       // its own parameters are far from those of its neighbours
    not_explained // by any of these
};

struct RoadOutlier {
    std::size_t station = 0; // of RoadResult::stations
    OutlierCause cause = OutlierCause::not_explained;
    double p_explained = 0.0;   // of the station's misfit, with the cause
    std::size_t axis = 0;       // of common, unlike
    double there = 0.0;         // its value there,
    double typical = 0.0;       // and the road's, or the median of the neighbours
    double offset_mm = 0.0;     // of sensor
    double model_percent = 0.0; // of sensor: mean of model over measured - 1
};

// A load level that was kept out of the fit, as the fit predicts it.
struct WithheldLevel {
    struct Sensor {
        double offset_mm = 0.0;
        std::size_t stations = 0;
        double mean_percent = 0.0;  // of measured over predicted - 1
        double error_percent = 0.0; // its standard error: scatter over the stations, and what the fit leaves open
        double p_familywise = 1.0;  // that it is 0 (Holm over the sensors)
        // Of the same stations at the nearest level that was fitted, and what is left when that is taken off: what the
        // load changes and the model does not, with its standard error (scatter over the stations) and its p.
        double fitted_percent = 0.0;
        bool is_off_at_all_levels = false; // that were fitted, in the same direction
        double load_percent = 0.0, load_error_percent = 0.0;
        double load_p_familywise = 1.0;
    };
    std::size_t stations = 0, readings = 0;
    double step = 0.0;                // < 0: it lies below the nearest level that was fitted
    double rms_percent = 0.0;         // of measured over predicted - 1
    double noise_percent = 0.0;       // what the noise of these readings and of the prediction makes of it
    double chi2 = 0.0, p_value = 1.0; // of all readings, with the covariance of the prediction at each station
    std::vector<Sensor> sensors{};
};

// How a parameter of the stations varies along one lane (analysis/road/road_course.h): neighbours tell of each other.
struct RoadCourse {
    std::size_t axis = 0;
    std::string lane{};                 // in words; "": the road has one
    double length_m = 0.0, sd = 0.0;    // of its variation; sd: as a share of the box
    double p_none = 1.0;                // that neighbours are no more alike than any two stations
    double narrower = 1.0;              // width of the range of a station without the course over that with it, median
    std::vector<std::size_t> stations;  // of RoadResult::stations, along the road
    std::vector<ParameterRange> ranges; // of each, with the course
};

// Something that the model may lack at every station alike, its size one unknown of the road.
struct RoadEffect {
    std::size_t candidate = 0; // its number
    std::string name, on;      // of the catalogue, "the sensor at 300 mm" or ""
    double score = 0.0;        // > 0: the residuals want a larger size [standard deviations]
    double p_familywise = 1.0; // that noise makes the largest score of all candidates as large
    hypotheses::Kind kind = hypotheses::Kind::effect;
    // Where it was fitted, with everything else; of a sensor's gain to first order:
    std::optional<double> chi2{};
    double p_value = 1.0;                     // of that
    double size = 0.0, low = 0.0, high = 0.0; // in the effect's unit
    bool ends_range = false;                  // the range of the size does
    double log_evidence = 0.0;                // marginal likelihood, whatever the size of the noise
    std::string words{};                      // "the sensor at 300 mm reads 6.1 % too much"
};

struct RoadDiagnosis {
    diagnose::Decision decision;                 // rows are of a ledger of the noise and the effects
    double chi2 = 0.0, dof = 0.0, p_value = 1.0; // of the road without any
    std::vector<RoadEffect> effects;             // those that readings see; the answer's, then the most probable first
    std::vector<std::size_t> causes;             // of these; several: the road does not tell them apart
};

struct RoadOptions {
    SurveyOptions survey{};
    std::optional<LoadLevel> withhold{}; // levels within a tenth of it are predicted, not fitted
    bool diagnose = false;               // look for what the model lacks at all stations
};

struct RoadResult {
    SurveyResult survey; // with a fit at every station that has one
    std::vector<CommonParameter> common;
    std::vector<CommonRegion> regions{};
    std::vector<RoadStation> stations; // those with a fit
    std::vector<RoadOutlier> outliers;
    // Of the stations that belong: the misfit in units of the stated noise; where that does not explain it, ranges are
    // wider by the root of chi2 over degrees of freedom.
    double chi2 = 0.0, dof = 0.0, p_value = 1.0;
    bool widened = false;
    double noise_factor() const;
    double station_noise_factor = 1.0; // of the median station: outliers are judged by it
    // Of the common parameters of the whole road, in unit coordinates: the combination that is known least.
    std::vector<double> weakest{};
    double weakest_sd = 0.0;
    double condition = 1.0; // of their information (Schur complement)
    // Whether stations by themselves want other common parameters than the road has: how much lower chi2 is where each
    // has its own.
    double conflict_chi2 = 0.0, conflict_dof = 0.0, conflict_p = 1.0;
    std::optional<WithheldLevel> withheld{};
    std::optional<RoadDiagnosis> diagnosis{};
    std::vector<RoadCourse> courses{};
    int rounds = 0; // of the last search
    bool converged = false;
    std::string ended{};
};

inline constexpr double road_familywise = 0.05;
inline constexpr std::size_t road_least_course = 8; // stations of a lane that have a course
inline constexpr int road_first_stations = 8;       // that are fitted by themselves, to begin from

// survey_study: as load_survey_study() gives it; its levels say what is common. Each station is compared in units of
// its readings' noise (study::station_study), whatever the misfit of the study, at all its load levels unless a target
// load is chosen.
//
// A few stations are fitted by themselves; the medians of their common parameters are held while every station finds
// its own; then all are searched together (optimise::arrow_gauss_newton). A station whose chi2 is improbable among all
// (5 % family-wise) is an outlier: the search is repeated without it until no more are found. Ranges are 95 %, by the
// curvature of the misfit at the end (common ones: Schur complement of the information of all stations).
//
// Nothing is returned when interrupted; what was computed is in the store. Throws pave::Error where no parameter is
// common, and where no station fits the model.
std::optional<RoadResult> road(Session& session, std::vector<data::FwdFile> files, study::Study survey_study,
                               const RoadOptions& options);

} // namespace explore::analysis
