// A study: the one file a user writes, checked and as plain values. With problems.h, which makes the calibration
// problem of it, the part of the explorer that knows pavements.
#pragma once

#include "data/csv.h"
#include "data/reading.h"
#include "pavement/parameter.h"
#include "problem/misfit.h"
#include "problem/parameter_space.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>

namespace explore::external {
class Model;
}

namespace explore::study {

// Who says in how many steps the load path is followed (model.settings.solver.load_steps). by_default: an analysis may
// choose another number; chosen: one has (analysis/common/load_steps.h).
enum class LoadSteps { by_default, stated, chosen };

// Where the noise of a measurement was taken from.
// sought: known but for its size ([data.noise] scale).
enum class NoiseSource { stated, sought, estimated };

struct DataSettings {
    std::vector<std::string> files; // as written in the study
    problem::MisfitKind misfit = problem::MisfitKind::log;
    double log_floor = 0.01; // s of the log misfit as a share of the largest |measured| of that load and quantity
    // Standard deviation of a reading without its own sigma: sqrt((noise_relative v)^2 + (noise_floor largest |value|
    // of that load and quantity)^2 + noise_absolute^2), v the value without error.
    std::optional<double> noise_relative;
    std::optional<double> noise_floor;
    std::array<double, 4> noise_absolute{}; // SI, of every data::Dimension
    // Errors that add to those of every reading, whoever states it, and tie those of a load: see data::Noise.
    double noise_common_relative = 0.0;
    double noise_correlation_length = 0.0; // m
    double noise_correlation_time = 0.0;   // s
    double noise_drift = 0.0;              // m/s, of deflections in time
    double noise_degrees = 0.0;            // of Student's t distribution; 0: normal
    bool noise_scale_is_sought = false;    // what is stated is its size but for a factor
    // Of means of drops (data::Reading::drops): how many the noise above is of, 0: of the readings as they are; and
    // what the drops of a load share, each sensor by itself and all sensors alike.
    int noise_of_drops = 0;
    double noise_shared_relative = 0.0;
    double noise_shared_common_relative = 0.0;
    int noise_line = 0; // of [data.noise]

    bool correlates_readings() const { return noise_correlation_length > 0.0 || noise_correlation_time > 0.0; }
    bool correlates_noise() const {
        return noise_common_relative > 0.0 || noise_shared_common_relative > 0.0 || noise_shared_relative > 0.0 ||
               noise_drift > 0.0 || correlates_readings();
    }
    bool shapes_noise() const { return correlates_noise() || noise_degrees > 0.0; }
    bool states_noise() const { return noise_relative || noise_floor || noise_absolute != std::array<double, 4>{}; }
};

// The readings of one quantity under one load: what is weighed, held out and judged together.
struct Group {
    std::string name;              // "fwd.deflection"
    std::vector<std::size_t> rows; // of the study's readings
    double weight = 1.0;           // of its squared residuals in the misfit
    bool held_out = false;         // predicted, never fitted
};

// A condition that the answer must meet, over paths of the model and names of outputs, in file units.
struct Constraint {
    enum class Relation { at_most, at_least, equal }; // of the left side to the right one
    std::string text;                                 // as written
    pave::Expression left, right;
    Relation relation = Relation::at_most;
    double tolerance = 1.0; // how far apart the sides may be where they should be equal
    int line = 0;
};

struct Study {
    std::string file; // as given by the user
    std::string text; // of the file
    std::string title;
    pave::pavement::Case model;
    std::vector<data::Reading> readings; // what each sensor of the model reads: the measured ones first, then outputs
    std::vector<pave::pavement::Parameter> parameters;
    problem::ParameterSpace space;
    std::vector<Constraint> constraints;
    DataSettings data;
    std::vector<pave::pavement::Quantity> possible{}; // what could still be measured; empty: not stated
    std::vector<Group> groups;                        // of the measured readings, in their order
    NoiseSource noise = NoiseSource::estimated;
    LoadSteps load_steps = LoadSteps::by_default;
    // Of the measured readings, how many took their noise from the others: their median share of a reading.
    std::size_t noise_assumed = 0;
    std::string hash; // of everything that changes a result: model, parameters, data
    // Of the file as it was read: a study that was derived from it (other laws, effects, readings) keeps it.
    std::string file_hash;
    std::shared_ptr<const std::vector<data::InputFile>> inputs; // the file, then its data files; null: from memory
    // [model]: a forward function that is not ours. Then `model` holds loads and sensors by name alone, and the values
    // of the parameters as the factors of a correction that acts on nothing.
    bool has_own_model = false;
    std::shared_ptr<const external::Model> external{};

    // Name without folder and ending: the default folder of its results.
    std::string stem() const;
    // Of its results: the stem; of the extended study that a diagnosis writes, also the name of the folder it is in.
    std::string folder_name() const;
    // "stated", "partly stated" (some are assumed) or "estimated" (from the residuals of the fit).
    std::string_view noise_name() const;
    std::span<const data::Reading> measured() const;
    std::vector<std::size_t> outputs() const;       // which of the readings are outputs
    std::vector<std::string> groups_fitted() const; // their names
    std::size_t held_out_readings() const;
    // Whether it is known that this can be measured: stated, or measured already.
    bool is_at_hand(pave::pavement::Quantity quantity) const;
};

// Throws pave::Error for anything wrong in the study or its data: file, line, key, found, allowed.
// Readings::elsewhere: the data files are not read; with_measurements brings the readings.
enum class Readings { own, elsewhere };
Study load_study(const std::string& file, Readings readings = Readings::own);

// The same from memory: the text of a study, which messages call `name`, and the texts of its data files by the names
// that it calls them.
Study study_of(std::string text, const std::string& name, const std::map<std::string, std::string>& files);

// The study with these measurements in place of its own, and without outputs. Throws pave::Error for a measurement that
// does not fit the model.
Study with_measurements(Study study, std::vector<data::Reading> measurements);

// Throws pave::Error at `place` for a name that no effect has.
const pave::pavement::Effect& effect_named(const std::string& name, const pave::Place& place);
std::vector<std::string> effect_names();

// Throws pave::Error at `place` where the study cannot have the effect.
void check_effect(const Study& study, const pave::pavement::AppliedEffect& applied, const pave::Place& place);

// The study with an effect of this size (in the effect's unit): added, or in place of the size of its own entry of that
// name. place: of whoever asks for it. Throws pave::Error for an unknown name, a size out of range, and an effect that
// this study cannot have.
Study with_effect(Study study, const std::string& name, double size, const pave::Place& place);

// Throws pave::Error for a study with a model of its own, which `what` is not for.
void refuse_own_model(const Study& study, const std::string& what);

// Whether a path that is read from a folder may lead out of it.
bool leaves_folder(const std::filesystem::path& path);
// The same, links in the folder followed.
bool leaves_folder(const std::filesystem::path& folder, const std::filesystem::path& path);

} // namespace explore::study
