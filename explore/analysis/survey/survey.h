// A road of FWD stations: what each bowl tells, the parameters of a study at each station, sections that are alike.
#pragma once

#include "analysis/common/floor.h"
#include "analysis/common/session.h"
#include "analysis/design/criterion_life.h"
#include "data/bowl_indices.h"
#include "data/temperature_curves.h"
#include "inference/quantiles.h"
#include "landscape/minima.h"
#include "study/station.h"

namespace explore::analysis {

// A load, as pressure under the plate or as force on it.
struct LoadLevel {
    std::optional<double> pressure_kPa{};
    std::optional<double> force_kN{};

    double pressure_on(double radius_mm) const; // kPa
};
// "40kN", "566 kPa"; nothing: no load.
std::optional<LoadLevel> load_level_of(const std::string& text);

struct SurveyOptions {
    data::DropChoice drops{};
    std::optional<LoadLevel> normalise{};         // nothing: the median pressure of the stations
    std::string layers{};                         // a table of thicknesses by chainage; "": none
    std::optional<double> asphalt_thickness_mm{}; // nothing: that of the top layer
    std::optional<double> air_of_day_before_C{};  // mean; nothing: the station's air temperature stands in
    std::optional<double> reference_C{};          // that indices and asphalt modulus are taken to; nothing: not at all
    data::TemperatureCurve curve = data::TemperatureCurve::fhwa;
    std::optional<double> latitude_deg{}; // of stations whose file states none
};

enum class StationState {
    ok,
    doubtful, // back-calculated, but the root mean square of the relative differences is beyond doubtful_percent
    rejected, // its readings cannot be right
    no_fit,   // the model does not describe them: no back-calculation
    failed    // the model has no answer
};
constexpr std::string_view state_words[] = {"ok", "doubtful", "rejected", "no-fit", "failed"};
constexpr std::string_view to_string(StationState state) {
    return state_words[static_cast<int>(state)];
}

// Why a fit is none.
enum class NoFit {
    far_off, // root mean square of the relative differences beyond no_fit_percent
    all_on_bounds
};
inline constexpr double no_fit_percent = 25.0;
// Five times the 2 % within which sensors are good.
inline constexpr double doubtful_percent = 10.0;

// A parameter with its 95 % range, by the curvature of the misfit at the best fit.
struct ParameterRange {
    double value = 0.0;
    double low = 0.0, high = 0.0; // within the bounds of the study
    bool determined = false;      // the range reaches neither bound and covers less than half of the box
};

// An [[outputs]] entry of the study at the best fit, with its 95 % range by the delta method: g' C g of its gradient g
// and the covariance C that the parameters' own ranges are made of. SI.
struct OutputRange {
    double value = 0.0;
    double low = 0.0, high = 0.0;
    bool determined = false; // no direction that the readings do not see moves it
};

// Lives by the criteria of the study at the best fit (analysis/survey/survey_lives.h).
struct StationLives {
    std::vector<CriterionLife> criteria; // in the order of the study's
    Overlay overlay;
    bool has_range = false; // else nothing is known of the ends

    const CriterionLife& first() const { return ends_first(criteria); }
};

struct StationFit {
    landscape::Minimum best;
    std::size_t minima = 0;
    std::size_t starts = 0;
    double rms_percent = 0.0;                  // of the relative differences
    std::vector<std::vector<double>> model_um; // at the readings of each fitted level
    std::vector<std::size_t> levels;           // of the station's bowls that were fitted together
    std::vector<ParameterRange> parameters;    // in the order of the study's
    landscape::LocalAnalysis local;
    double quantile = inference::two_sided_95; // half a 95 % range over a standard error
    std::vector<std::size_t> held_by{};  // inequalities of the study that cut ranges: those end there, on one side
    std::vector<OutputRange> outputs{};  // in the order of SurveyResult::outputs
    std::string why_no_outputs{};        // where the model has no answer for them
    std::optional<StationLives> lives{}; // nothing: no criteria, or no answer under their axles
};

enum class TemperatureSource {
    measured,
    bells3,
    bells3_of_the_hour
}; // the last: the air of the hour, not of the day before
struct AsphaltTemperature {
    double celsius = 0.0;
    TemperatureSource source = TemperatureSource::measured;
};

struct StationResult {
    data::FwdStation station;
    std::optional<data::StationBowls> bowls{};
    StationState state = StationState::ok;
    std::string reason{}; // of rejected and failed, in words
    std::optional<NoFit> no_fit{};
    std::optional<StationFit> fit{};
    std::optional<data::BowlIndices> indices{}; // at normalised_kPa
    double normalised_kPa = 0.0;
    std::optional<AsphaltTemperature> asphalt{};
    std::optional<data::IndicesAtReference> at_reference{}; // at normalised_kPa; nothing: no temperature
    std::optional<double> asphalt_at_reference_MPa{};

    bool has_bowl() const { return state != StationState::rejected; }
    const data::DeflectionBowl& bowl() const { return bowls->bowl(); }
    bool is_fitted() const { return fit.has_value() && (state == StationState::ok || state == StationState::doubtful); }
    std::optional<double> ratio() const { return has_bowl() ? bowl().deflection_ratio() : std::nullopt; }
    std::optional<bool> passes() const;
    // Levels that were used: fitted, or the one that counts.
    std::vector<std::size_t> used_levels() const;
};

// Values that 15, 50 and 85 % of the stations do not exceed.
struct Percentiles {
    double p15 = 0.0, p50 = 0.0, p85 = 0.0;
    std::size_t stations = 0;
};
Percentiles percentiles_of(std::vector<double> values);

// Neighbouring stations that are alike in D0: cumulative differences (AASHTO Guide 1993, appendix J). A part of the
// road is parted where the cumulative difference of ln D0 from its mean is farthest from zero, if both sides keep five
// stations and their means differ (Welch's t, p < 0.01).
struct RoadSection {
    std::string profile, lane;
    std::size_t first = 0, last = 0;     // of the result's stations; both included
    Percentiles d0_um;                   // normalised
    std::size_t fitted = 0;              // stations
    std::vector<Percentiles> parameters; // of those of them that determine it; stations = 0: none
};
inline constexpr std::size_t section_stations = 5;

// A sensor whose residual repeats over the stations with one sign and differs from that of its neighbours.
struct SuspectSensor {
    double offset_mm = 0.0;
    std::size_t stations = 0, same_sign = 0;
    double p = 1.0;                   // that chance alone gives so many of one sign, times the number of sensors
    double model_percent = 0.0;       // median of model over measured - 1
    std::optional<double> fits_at_mm; // where the fitted bowls have that deflection (median)
    bool is_beside_others = false;    // the signs are those of what it is off beyond the sensors on its two sides
};

// A reduced model that the searches of many stations shared (study/network.h); every answer is the full model's.
struct NetworkModel {
    std::size_t stations = 0;
    pave::reduced::BuildReport report;
};

// The residual of one sensor along the road, at the highest level that was fitted.
struct SensorResidual {
    double offset_mm = 0.0;
    std::size_t stations = 0, above = 0; // above: of these, where the model is above the reading
    double percent = 0.0;                // median of model over measured - 1
    double scatter_percent = 0.0;        // about it: 1.4826 times the median of the distances
    bool one_sign = false;               // more often than chance allows (p < 0.01 over all sensors) and by 1 % or more
};

// The same of one level of load, where stations are fitted to several: the mean over the sensors of a station.
struct LoadResidual {
    double pressure_kPa = 0.0; // median over the stations
    std::size_t stations = 0, above = 0;
    double percent = 0.0, scatter_percent = 0.0;
    bool one_sign = false; // as of a sensor
};

// A usual layout of sensors that describes the bowls where the file's does not.
struct BetterLayout {
    std::vector<double> offsets_mm;
    std::size_t stations = 0;                            // that it was tried at
    double rms_percent = 0.0, rms_percent_of_file = 0.0; // medians over them
    double misfit_ratio = 1.0;                           // squared, of the layout over the file's; median
};

// Another section in place of the study's, tried at a few stations.
struct SectionTrial {
    std::string words; // "a half-space in place of the floor"
    std::size_t stations = 0;
    double rms_percent = 0.0, rms_percent_of_study = 0.0; // medians over them
    double misfit_ratio = 1.0;                            // squared, of it over the study's; geometric mean
};

struct SurveyCounts {
    std::size_t pass = 0, fail = 0; // by the deflection ratio
    std::size_t no_ratio = 0;       // with a bowl, but without sensors to form it
    std::size_t rejected = 0, fitted = 0, doubtful = 0, no_fit = 0, failed = 0;
};

struct SurveyResult {
    std::vector<StationResult> stations; // along the road: by profile, lane and chainage
    std::vector<std::string> remarks;    // of the files
    std::optional<study::Study> study;
    bool fits_all_levels = false;
    double common_pressure_kPa = 0.0; // median of the stations
    std::optional<LoadLevel> normalise;
    std::optional<LoadLevel> target; // that the level was chosen by
    std::optional<double> reference_C;
    data::TemperatureCurve curve = data::TemperatureCurve::fhwa;
    std::optional<double> repeatability; // of a reading, over the road
    double noise_factor = 1.0;           // survey_noise.h
    std::vector<RoadSection> sections;
    std::vector<SensorResidual> residuals;    // by offset
    std::vector<LoadResidual> load_residuals; // by rising load; none: stations are fitted to one level
    std::optional<SuspectSensor> suspect;     // the worst, where one sensor explains the residuals of several
    bool section_is_suspect = false; // several sensors have one sign along the road, and no single one explains it
    std::optional<BetterLayout> layout;
    std::vector<SectionTrial> trials; // where the bowls do not fit: what helps most first
    // Of the fitted station with the median D0.
    struct Floor {
        std::size_t station = 0;
        WithoutFloor without;
    };
    std::optional<Floor> floor;
    std::vector<NetworkModel> networks; // one for each plate and set of sensors that enough stations have
    std::int64_t computed = 0;          // model runs of this process
    int stations_computed = 0;
    double seconds = 0.0;

    std::size_t count(const std::function<bool(const StationResult&)>& is) const;
    SurveyCounts counts() const;
    // Behind the last of the stations from `begin` on that lie in one profile and lane.
    std::size_t end_of_lane(std::size_t begin) const;
    std::vector<std::string> parameter_names() const;
    std::vector<data::Reading> outputs() const; // of the study; none without one
    bool has_lives() const;                     // at any station
    double d0_at_common(const StationResult& s) const {
        return s.bowl().d0_um() * common_pressure_kPa / s.bowl().pressure_kPa;
    }
};

inline constexpr int survey_explored_points = 256; // once for the road

// survey_study: as load_survey_study() gives it; nothing: no back-calculation. Nothing is returned when interrupted;
// what was computed is in the store. Throws pave::Error where no station fits the model.
std::optional<SurveyResult> survey(Session& session, std::vector<data::FwdFile> files,
                                   std::optional<study::Study> survey_study, const SurveyOptions& options);

} // namespace explore::analysis
