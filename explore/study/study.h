// A study: the one file a user writes. Reads it, checks every key, and makes the calibration problem of it. The only
// part of the explorer that knows pavements.
#pragma once

#include "data/measurement.h"
#include "pavement/forward.h"
#include "problem/problem.h"

#include <cstdint>
#include <filesystem>

namespace explore::study {

// An engineering response predicted from every acceptable parameter set.
struct Output {
    std::string name;
    pave::pavement::Sensor sensor;
};

// Where the noise of a measurement was taken from.
enum class NoiseSource { stated, estimated };

struct DataSettings {
    std::vector<std::string> files; // as written in the study
    problem::MisfitKind misfit = problem::MisfitKind::log;
    double log_floor = 0.01; // s of the log misfit as a share of the largest |measured| of that load and quantity
    // Standard deviation of a reading without its own sigma:
    // sqrt((noise_relative |value|)^2 + (noise_floor largest |value| of that load and quantity)^2)
    std::optional<double> noise_relative;
    std::optional<double> noise_floor;
};

// The readings of one quantity under one load: what is weighed, held out and judged together.
struct Group {
    std::string name; // "fwd.deflection"
    std::vector<std::size_t> rows;
    double weight = 1.0;   // of its squared residuals in the misfit
    bool held_out = false; // predicted, never fitted
};

struct Study {
    std::string file; // as given by the user
    std::string title;
    pave::pavement::Case model; // its sensors: the measurements, then the outputs
    std::vector<pave::pavement::Parameter> parameters;
    problem::ParameterSpace space;
    DataSettings data;
    std::vector<data::Measurement> measurements;
    std::vector<Group> groups; // of the measurements, in their order
    std::vector<Output> outputs;
    NoiseSource noise = NoiseSource::estimated;
    // SI, one a measurement; empty when the noise is to be estimated (misfit "weighted" then weighs by |measured|).
    std::vector<double> sigma;
    // Of these, how many the study took from the others: their median share of a reading.
    std::size_t noise_assumed = 0;
    std::string hash; // of everything that changes a result: model, parameters, data

    // Name without folder and ending: the default folder of its results.
    std::string stem() const;
    // "stated", "partly stated" (some are assumed) or "estimated" (from what the fit leaves over).
    std::string_view noise_name() const;
    // The reporting unit of response i (measurements first, then outputs), and what takes SI there.
    std::string_view response_unit(std::size_t i) const;
    double response_to_si(std::size_t i) const;
    std::size_t responses() const { return measurements.size() + outputs.size(); }
};

// Throws pave::Error for anything wrong in the study or its data: file, line, key, found, allowed.
// Readings::elsewhere: the data files are not read; with_measurements brings the readings.
enum class Readings { own, elsewhere };
Study load_study(const std::string& file, Readings readings = Readings::own);

// The study with these measurements in place of its own, and without outputs. Throws pave::Error for a measurement that
// does not fit the model.
Study with_measurements(Study study, std::vector<data::Measurement> measurements);

// Throws pave::Error at `place` for a name that no effect has.
const pave::pavement::Effect& effect_named(const std::string& name, const pave::Place& place);

// The study with an effect of this size (in the effect's unit): added, or in place of the size of its own entry of that
// name. place: of whoever asks for it. Throws pave::Error for an unknown name, a size out of range, and an effect that
// this study cannot have.
Study with_effect(Study study, const std::string& name, double size, const pave::Place& place);

// The problem the explorer works on. Throws pave::Error when the study has no parameters or no measurements.
// What a problem computes at every point: all responses, or those of the loads with readings that are fitted (the
// others are then not numbers).
enum class Scope { everything, fitted };

// Whether a path that is read from a folder may lead out of it.
bool leaves_folder(const std::filesystem::path& path);
// The same, links in the folder followed.
bool leaves_folder(const std::filesystem::path& folder, const std::filesystem::path& path);

// Of each load: whether readings under it are fitted.
std::vector<bool> fitted_loads(const Study& study);

// Its misfit: the readings that are not held out, weighed.
problem::Problem make_problem(const Study& study, Scope scope = Scope::everything);
// One group of readings alone, each with weight 1.
problem::Problem make_problem(const Study& study, const Group& group);

// The fitted readings with every residual in units of its noise at the measured value: what statements of probability
// need. Weights count as variances. The same as make_problem where the noise is not stated.
problem::Problem make_noise_problem(const Study& study, Scope scope);

// The misfit of these measurements alone, each with weight 1.
problem::Misfit misfit_of(const Study& study, const std::vector<std::size_t>& rows);

// The same with nothing to compare with: for what needs responses and no data. Throws pave::Error when the study has no
// parameters.
problem::Problem make_prediction_problem(const Study& study);

} // namespace explore::study
