// Every key of a study but the numbers of layers, laws and loads, which stand with what they belong to
// (pavement/parameter.h, material/law.h): where it is read from, and what docs/reference/keys.md is made of.
#pragma once

#include "fe/settings.h"
#include "problem/misfit.h"

#include <optional>
#include <span>
#include <string_view>

namespace explore::study {

struct Key {
    enum class Kind { number, whole_number, word, text, texts, numbers, table, boolean };

    std::string_view table; // as it is headed; "": above all tables
    std::string_view key;
    Kind kind = Kind::text;
    double low = 0.0; // of numbers: inclusive unless low_is_open
    double high = 0.0;
    bool low_is_open = false;
    std::optional<double> default_value{};       // of numbers; of words, which one
    std::span<const std::string_view> choices{}; // words
    std::string_view allowed{};                  // what may stand there, of a text or a table, or bounds set elsewhere
    std::string_view without{};                  // what holds when it is missing, in words
    std::string_view meaning{};

    constexpr operator std::string_view() const { return key; }
};

namespace keys {

using enum Key::Kind;

inline constexpr std::string_view load_types[] = {"plate", "wheel", "dual-wheel", "gear"};
inline constexpr std::string_view bottoms[] = {"rigid", "half-space"};
inline constexpr std::string_view patches[] = {"circle", "rectangle"};
inline constexpr std::string_view integrations[] = {"incremental", "secant"};
inline constexpr std::string_view scales[] = {"linear", "log"};
inline constexpr std::string_view levels[] = {"station", "section", "shared"};

inline constexpr Key schema{
    .table = "", .key = "schema", .kind = whole_number, .low = 1, .high = 1, .meaning = "version of this format"};
inline constexpr Key title{
    .table = "", .key = "title", .allowed = "a text", .without = "the name of the file", .meaning = "heads reports"};

inline constexpr std::string_view model_types[] = {"program", "um-bridge"};

inline constexpr Key model_type{.table = "[model]",
                                .key = "type",
                                .kind = word,
                                .choices = model_types,
                                .meaning = "a model of your own in place of layers and loads: a program that is run, "
                                           "or a server that speaks UM-Bridge (docs/guide/any-model.md)"};
inline constexpr Key model_command{.table = "[model]",
                                   .key = "command",
                                   .kind = texts,
                                   .allowed = "the program and its arguments, as in `[\"python3\", \"model.py\"]`",
                                   .without = "of a program: must be given",
                                   .meaning = "run without a shell, in a folder of its own for each run"};
inline constexpr Key model_inputs{.table = "[model]",
                                  .key = "inputs",
                                  .kind = Key::Kind::table,
                                  .allowed = "a list of `{ template, file }`",
                                  .without = "of a program: must be given",
                                  .meaning = "what the program reads"};
inline constexpr Key model_input_template{
    .table = "inputs of a program",
    .key = "template",
    .allowed = "a file with places `{{NAME}}` or `{{NAME:%12.5e}}`",
    .meaning = "where the values of parameters go; one that is wider than its format says is no answer"};
inline constexpr Key model_input_file{.table = "inputs of a program",
                                      .key = "file",
                                      .allowed = "a name in the folder of the run",
                                      .meaning = "what it is written as"};
inline constexpr Key model_files{.table = "[model]",
                                 .key = "files",
                                 .kind = texts,
                                 .allowed = "a list of files in the study's folder",
                                 .without = "none",
                                 .meaning = "linked into the folder of every run; what they hold belongs to the study"};
inline constexpr Key model_folder{.table = "[model]",
                                  .key = "folder",
                                  .allowed = "a path from the study's own folder",
                                  .without = "the study's own",
                                  .meaning = "where templates, files and a command with a / are found"};
inline constexpr Key model_outputs{.table = "[model]",
                                   .key = "outputs",
                                   .kind = Key::Kind::table,
                                   .allowed = "a list of `{ reading, file, line, column }`, `{ file, by }` and "
                                              "`{ file, at }`",
                                   .without = "of a program: must be given",
                                   .meaning = "where the readings stand in what the program writes; its standard "
                                              "output is stdout.txt"};
inline constexpr Key model_output_file{.table = "outputs of a program",
                                       .key = "file",
                                       .allowed = "a name in the folder of the run",
                                       .meaning = "that the program writes"};
inline constexpr Key model_output_reading{.table = "outputs of a program",
                                          .key = "reading",
                                          .allowed = "the name of a reading or an output",
                                          .without = "all that no other entry names",
                                          .meaning = "which one this is"};
inline constexpr Key model_output_line{
    .table = "outputs of a program",
    .key = "line",
    .allowed = "`12`, `after 'TEXT'`, `3 after 'TEXT'`, `with 'TEXT'`; `last` before the text: its last line",
    .without = "`by` or `at`",
    .meaning = "the line with the number"};
inline constexpr Key model_output_column{.table = "outputs of a program",
                                         .key = "column",
                                         .kind = whole_number,
                                         .low = 1,
                                         .high = 100000,
                                         .default_value = 1,
                                         .meaning = "of that line, between blanks, commas and semicolons"};
inline constexpr Key model_output_by{
    .table = "outputs of a program",
    .key = "by",
    .kind = texts,
    .allowed = "columns of a CSV table: name, load, quantity, x_mm, y_mm, depth_mm, gauge_mm, time_ms",
    .without = "`line` or `at`",
    .meaning = "which together tell the reading of a row"};
inline constexpr Key model_output_value{.table = "outputs of a program",
                                        .key = "value",
                                        .allowed = "the name of a column",
                                        .without = "`value`",
                                        .meaning = "of that table, in the reading's unit"};
inline constexpr Key model_output_at{
    .table = "outputs of a program",
    .key = "at",
    .allowed = "a JSON pointer",
    .without = "`line` or `by`",
    .meaning = "to a number, to a list in the order of the readings and outputs, or to an object by their names"};
inline constexpr Key model_time_limit{.table = "[model]",
                                      .key = "time_limit_s",
                                      .kind = number,
                                      .low = 0.0,
                                      .high = 1e7,
                                      .low_is_open = true,
                                      .without = "none",
                                      .meaning = "after which a run is ended, with all that it started"};
inline constexpr std::string_view model_keeps[] = {"failed", "all", "none"};
inline constexpr Key model_keep{.table = "[model]",
                                .key = "keep",
                                .kind = word,
                                .default_value = 0,
                                .choices = model_keeps,
                                .meaning = "which folders of runs stay, in `runs` of the results; of failed ones the "
                                           "first twenty"};
inline constexpr Key model_url{.table = "[model]",
                               .key = "url",
                               .allowed = "`http://HOST:PORT`",
                               .without = "of a server: `urls`",
                               .meaning = "where the server listens"};
inline constexpr Key model_urls{.table = "[model]",
                                .key = "urls",
                                .kind = texts,
                                .allowed = "a list of `http://HOST:PORT`",
                                .without = "of a server: `url`",
                                .meaning = "several servers with the same model, called in parallel"};
inline constexpr Key model_name{
    .table = "[model]", .key = "name", .allowed = "a text", .without = "`forward`", .meaning = "of the server's model"};
inline constexpr Key model_config{.table = "[model]",
                                  .key = "config",
                                  .kind = Key::Kind::table,
                                  .allowed = "whatever the model knows",
                                  .without = "empty",
                                  .meaning = "handed to the server's model with every request"};

inline constexpr Key section_bottom{
    .table = "[section]",
    .key = "bottom",
    .kind = word,
    .default_value = 0,
    .choices = bottoms,
    .meaning =
        "what the last layer stands on; of a half-space it goes on for ever, and its `thickness_mm`, which may be "
        "missing, is how deep it is meshed where a mesh is needed"};

inline constexpr Key layer_name{.table = "[[layers]]",
                                .key = "name",
                                .allowed = "a text without a full stop",
                                .meaning = "layers and loads have each a name of their own"};
inline constexpr Key layer_law{
    .table = "[[layers]]", .key = "law", .allowed = "a law, below", .meaning = "how its stiffness follows stress"};

inline constexpr Key load_name{.table = "[[loads]]",
                               .key = "name",
                               .allowed = "a text without a full stop",
                               .meaning = "layers and loads have each a name of their own"};
inline constexpr Key load_type{
    .table = "[[loads]]", .key = "type", .kind = word, .choices = load_types, .meaning = "what presses"};
inline constexpr Key load_patch{.table = "[[loads]]",
                                .key = "patch",
                                .kind = word,
                                .default_value = 1,
                                .choices = patches,
                                .meaning = "shape of a tyre's contact; those of a plate and of a gear are circles"};
inline constexpr Key load_history{.table = "[[loads]]",
                                  .key = "history",
                                  .allowed =
                                      "the name of a CSV file with the columns time_ms and force_kN or pressure_kPa",
                                  .without = "a static load",
                                  .meaning = "how a plate or wheels pressed over time; the section moves under it"};
inline constexpr Key load_wheels{.table = "[[loads]]",
                                 .key = "wheels",
                                 .kind = Key::Kind::table,
                                 .allowed = "a list of `{ x_mm, y_mm, force_kN }`",
                                 .without = "of a gear: must be given",
                                 .meaning = "of a gear: its wheels, each a circle at the pressure"};
inline constexpr Key wheel_x{
    .table = "wheels of a gear", .key = "x_mm", .kind = number, .low = -1e5, .high = 1e5, .meaning = "across the road"};
inline constexpr Key wheel_y{
    .table = "wheels of a gear", .key = "y_mm", .kind = number, .low = -1e5, .high = 1e5, .meaning = "along the road"};
inline constexpr Key wheel_force{.table = "wheels of a gear",
                                 .key = "force_kN",
                                 .kind = number,
                                 .low = 0.0,
                                 .high = 1e4,
                                 .low_is_open = true,
                                 .meaning = "on this wheel"};

inline constexpr Key solver_integration{.table = "[solver]",
                                        .key = "integration",
                                        .kind = word,
                                        .default_value = 0,
                                        .choices = integrations,
                                        .meaning = "how the load path is followed: in steps, or at once (secant)"};
inline constexpr Key solver_load_steps{.table = "[solver]",
                                       .key = "load_steps",
                                       .kind = whole_number,
                                       .low = 1,
                                       .high = 1000,
                                       .without = "9; an analysis that fits readings of stated noise takes as many as "
                                                  "that noise asks for, 5 at least",
                                       .meaning = "steps of every load path, the same at all points of a search"};
inline constexpr Key solver_path{.table = "[solver]",
                                 .key = "path_tolerance",
                                 .kind = number,
                                 .low = 1e-7,
                                 .high = 0.1,
                                 .without = "`load_steps`",
                                 .meaning =
                                     "in place of `load_steps`: 9 (0.002/path_tolerance)^(1/3) of them, rounded up"};
inline constexpr Key solver_equilibrium{.table = "[solver]",
                                        .key = "equilibrium_tolerance",
                                        .kind = number,
                                        .low = 1e-12,
                                        .high = 1e-4,
                                        .default_value = pave::fe::SolverSettings{}.equilibrium_tolerance,
                                        .meaning = "unbalanced over applied force where a run ends"};

inline constexpr Key solver_time_limit{
    .table = "[solver]",
    .key = "time_limit_s",
    .kind = number,
    .low = 0.01,
    .high = 1e6,
    .without = "no limit",
    .meaning = "processor time of the path of one load: what takes longer has no answer, and is tried "
               "again by the next run"};
inline constexpr Key solver_time_step{.table = "[solver]",
                                      .key = "time_step_ms",
                                      .kind = number,
                                      .low = 0.01,
                                      .high = 10.0,
                                      .default_value = 0.2,
                                      .meaning = "under a load with a history"};

inline constexpr Key mesh_extent{
    .table = "[mesh]",
    .key = "extent_m",
    .kind = number,
    .low = 0.1,
    .high = 1000.0,
    .without = "4 (under a load with a history 8), twice the depth or twice the farthest sensor, whichever is largest; "
               "linear layers under circles: no wall",
    .meaning = "distance of the smooth wall; nearer than twice the depth gives a warning; "
               "of a half-space: where the infinite elements begin"};
inline constexpr Key mesh_refine{.table = "[mesh]",
                                 .key = "refine",
                                 .kind = number,
                                 .low = 0.25,
                                 .high = 16.0,
                                 .default_value = 1.0,
                                 .meaning = "elements along every edge, times this"};

inline constexpr Key measure_possible{
    .table = "[measure]",
    .key = "possible",
    .kind = texts,
    .allowed = "quantities of readings: `deflection`, `strain_zz`, `strain_xx`, `strain_yy`, `stress_zz`, `stress_xx`, "
               "`stress_yy`",
    .without = "what the study reads comes first",
    .meaning = "what could still be measured: further readings that are proposed are of these"};

inline constexpr Key data_files{.table = "[data]",
                                .key = "files",
                                .kind = texts,
                                .allowed = "paths from the study's own folder",
                                .without = "no measurements",
                                .meaning = "files of measurements"};
inline constexpr Key data_outside{.table = "[data]",
                                  .key = "outside",
                                  .kind = boolean,
                                  .allowed = "`true`, `false`",
                                  .without = "`false`",
                                  .meaning = "whether files may lie outside the study's own folder"};
inline constexpr Key data_misfit{.table = "[data]",
                                 .key = "misfit",
                                 .kind = word,
                                 .default_value = 0,
                                 .choices = problem::misfit_names,
                                 .meaning = "kind of residual, whose norm the search minimises"};
inline constexpr Key data_log_floor{.table = "[data]",
                                    .key = "log_floor",
                                    .kind = number,
                                    .low = 0.0,
                                    .high = 1.0,
                                    .low_is_open = true,
                                    .default_value = 0.01,
                                    .meaning = "of misfit `log`: share of the largest reading of its group"};
inline constexpr Key data_noise_relative{.table = "[data]",
                                         .key = "noise_relative",
                                         .kind = number,
                                         .low = 0.0,
                                         .high = 10.0,
                                         .low_is_open = true,
                                         .without = "not stated",
                                         .meaning =
                                             "standard deviation of a reading without a sigma, over the model's value"};
inline constexpr Key data_noise_floor{.table = "[data]",
                                      .key = "noise_floor",
                                      .kind = number,
                                      .low = 0.0,
                                      .high = 10.0,
                                      .low_is_open = true,
                                      .without = "not stated",
                                      .meaning =
                                          "what adds to it (root sum of squares), over the largest of its group"};
inline constexpr Key data_noise{.table = "[data]",
                                .key = "noise",
                                .kind = table,
                                .allowed = "the keys of [data.noise], below",
                                .without = "noise_relative and noise_floor alone",
                                .meaning = "the noise of readings without a sigma"};
inline constexpr Key noise_relative{.table = "[data.noise]",
                                    .key = "relative",
                                    .kind = number,
                                    .low = 0.0,
                                    .high = 10.0,
                                    .low_is_open = true,
                                    .without = "not stated",
                                    .meaning = "standard deviation over the model's value; the same as noise_relative"};
inline constexpr Key noise_absolute{.table = "[data.noise]",
                                    .key = "absolute",
                                    .kind = table,
                                    .allowed = "UNIT = 0 or more, for mm or um, microstrain or strain, kPa or MPa",
                                    .without = "not stated",
                                    .meaning = "what adds to it (root sum of squares), in units of the readings"};
inline constexpr Key noise_common_relative{
    .table = "[data.noise]",
    .key = "common_relative",
    .kind = number,
    .low = 0.0,
    .high = 10.0,
    .default_value = 0.0,
    .meaning = "standard deviation of the one error that all readings of a load share, over the model's value"};
inline constexpr Key noise_correlation{
    .table = "[data.noise]",
    .key = "correlation_mm",
    .kind = number,
    .low = 0.0,
    .high = 1e6,
    .default_value = 0.0,
    .meaning = "readings of one load and quantity have errors correlated by exp(-distance / this); 0: independent"};
inline constexpr Key noise_correlation_time{
    .table = "[data.noise]",
    .key = "correlation_ms",
    .kind = number,
    .low = 0.0,
    .high = 1e4,
    .default_value = 0.0,
    .meaning =
        "the same over the time between readings under a history: exp(-distance / correlation_mm - time / this)"};
inline constexpr Key noise_drift{
    .table = "[data.noise]",
    .key = "drift_um_per_ms",
    .kind = number,
    .low = 0.0,
    .high = 1e3,
    .default_value = 0.0,
    .meaning =
        "standard deviation of the rate at which each sensor's deflections under a history drift from time 0 on"};
inline constexpr Key noise_of_drops{
    .table = "[data.noise]",
    .key = "of_drops",
    .kind = whole_number,
    .low = 1,
    .high = 1000,
    .without = "that of the readings as they are",
    .meaning =
        "of `survey` and `road`: how many drops the reading is the mean of whose noise is stated; a mean of n has "
        "relative, absolute and common_relative times the root of this / n"};
inline constexpr Key noise_shared_relative{
    .table = "[data.noise]",
    .key = "shared_relative",
    .kind = number,
    .low = 0.0,
    .high = 10.0,
    .default_value = 0.0,
    .meaning = "of `survey` and `road`: each sensor's error common to all drops of a load, which no mean makes less: "
               "standard deviation over the reading"};
inline constexpr Key noise_shared_common_relative{
    .table = "[data.noise]",
    .key = "shared_common_relative",
    .kind = number,
    .low = 0.0,
    .high = 10.0,
    .default_value = 0.0,
    .meaning = "the same of the one error that all sensors share, as of the load cell"};
inline constexpr std::string_view noise_losses[] = {"normal", "student"};
inline constexpr Key noise_loss{.table = "[data.noise]",
                                .key = "loss",
                                .kind = word,
                                .default_value = 0,
                                .choices = noise_losses,
                                .meaning =
                                    "distribution of the errors; `student`: with heavier tails, so that a single "
                                    "wrong reading counts little"};
inline constexpr Key noise_degrees{.table = "[data.noise]",
                                   .key = "degrees",
                                   .kind = number,
                                   .low = 1.0,
                                   .high = 100.0,
                                   .default_value = 4.0,
                                   .meaning = "of loss `student`: degrees of freedom of Student's t distribution"};
inline constexpr std::string_view noise_scales[] = {"stated", "sought"};
inline constexpr Key noise_scale{
    .table = "[data.noise]",
    .key = "scale",
    .kind = word,
    .default_value = 0,
    .choices = noise_scales,
    .meaning = "size of the noise; `sought`: what is stated, or 2 % of each reading where nothing "
               "is, times a factor that is fitted with the parameters"};
inline constexpr Key data_held_out{.table = "[data]",
                                   .key = "held_out",
                                   .kind = texts,
                                   .allowed = "loads, or LOAD.QUANTITY",
                                   .without = "none",
                                   .meaning = "groups of readings that are predicted, not fitted"};
inline constexpr Key data_weights{.table = "[data]",
                                  .key = "weights",
                                  .kind = table,
                                  .allowed = "LOAD or LOAD.QUANTITY = above 0, up to 1e+06",
                                  .without = "1 each",
                                  .meaning = "weights of groups of readings"};

inline constexpr Key output_name{
    .table = "[[outputs]]", .key = "name", .allowed = "a text", .meaning = "what reports call it"};
inline constexpr Key output_load{
    .table = "[[outputs]]", .key = "load", .allowed = "a load of the study", .meaning = "under which load"};
inline constexpr Key output_quantity{.table = "[[outputs]]",
                                     .key = "quantity",
                                     .allowed = "a quantity, as in measurement files",
                                     .meaning = "what is wanted"};
inline constexpr Key output_unit{.table = "[[outputs]]",
                                 .key = "unit",
                                 .allowed = "a text",
                                 .without = "`-`",
                                 .meaning = "with [model]: the unit of its value; there `name` alone must be given"};
inline constexpr Key output_x{.table = "[[outputs]]",
                              .key = "x_mm",
                              .kind = number,
                              .low = -1e5,
                              .high = 1e5,
                              .default_value = 0.0,
                              .meaning = "across the road, from the middle of the load"};
inline constexpr Key output_y{.table = "[[outputs]]",
                              .key = "y_mm",
                              .kind = number,
                              .low = -1e5,
                              .high = 1e5,
                              .default_value = 0.0,
                              .meaning = "along the road"};
inline constexpr Key output_depth{.table = "[[outputs]]",
                                  .key = "depth_mm",
                                  .kind = number,
                                  .low = 0.0,
                                  .high = 1e5,
                                  .default_value = 0.0,
                                  .meaning = "below the surface"};
inline constexpr Key output_gauge{.table = "[[outputs]]",
                                  .key = "gauge_mm",
                                  .kind = number,
                                  .low = 0.0,
                                  .high = 1e4,
                                  .default_value = 0.0,
                                  .meaning = "length over which a strain is averaged"};

inline constexpr Key output_time{.table = "[[outputs]]",
                                 .key = "time_ms",
                                 .kind = number,
                                 .low = -1e4,
                                 .high = 1e4,
                                 .without = "the extreme over time",
                                 .meaning = "under a load with a history: when"};

inline constexpr Key effect_name{
    .table = "[[effects]]", .key = "name", .allowed = "an effect, below", .meaning = "what is added to the model"};
inline constexpr Key effect_size{.table = "[[effects]]",
                                 .key = "size",
                                 .kind = number,
                                 .allowed = "by effect, below",
                                 .without = "no effect",
                                 .meaning = "how much of it"};
inline constexpr Key effect_layer{.table = "[[effects]]",
                                  .key = "layer",
                                  .allowed = "a layer of the study",
                                  .without = "by effect",
                                  .meaning = "of an effect that takes one: where it is"};
inline constexpr Key effect_load{.table = "[[effects]]",
                                 .key = "load",
                                 .allowed = "a load of the study",
                                 .without = "all it can act on",
                                 .meaning = "of an effect that takes one: on which load"};
inline constexpr Key effect_quantity{.table = "[[effects]]",
                                     .key = "quantity",
                                     .allowed = "a quantity",
                                     .without = "all it can act on",
                                     .meaning = "of an effect that takes one: on which readings"};
inline constexpr Key effect_reading{.table = "[[effects]]",
                                    .key = "reading",
                                    .kind = whole_number,
                                    .allowed = "from 1, up to the number of readings",
                                    .without = "by effect",
                                    .meaning = "of an effect that takes one: which reading"};
inline constexpr Key effect_thickness{.table = "[[effects]]",
                                      .key = "thickness_mm",
                                      .kind = number,
                                      .low = 0.0,
                                      .high = 1e5,
                                      .low_is_open = true,
                                      .without = "by effect",
                                      .meaning = "of an effect that takes one: of the sublayer it makes"};

inline constexpr Key effect_offsets{.table = "[[effects]]",
                                    .key = "offsets_mm",
                                    .kind = numbers,
                                    .low = 0.0,
                                    .high = 1e4,
                                    .allowed = "rising, as many as sensors stand on the surface",
                                    .without = "one sensor moves",
                                    .meaning = "of `sensor-position`: the layout that all sensors move to"};

inline constexpr Key effect_parameter{.table = "[[effects]]",
                                      .key = "parameter",
                                      .allowed = "a parameter of the study's own model that is not fitted",
                                      .without = "in a study with [model] it must be given",
                                      .meaning = "what the effect changes"};
inline constexpr Key effect_null{.table = "[[effects]]",
                                 .key = "null",
                                 .kind = number,
                                 .low = -1e300,
                                 .high = 1e300,
                                 .allowed = "a number in the range",
                                 .without = "in a study with [model] it must be given",
                                 .meaning = "the size without the effect"};
inline constexpr Key effect_typical{.table = "[[effects]]",
                                    .key = "typical",
                                    .kind = number,
                                    .low = -1e300,
                                    .high = 1e300,
                                    .allowed = "a number in the range, another than null",
                                    .without = "in a study with [model] it must be given",
                                    .meaning = "a size that is seen in practice"};
inline constexpr Key effect_range{.table = "[[effects]]",
                                  .key = "range",
                                  .kind = numbers,
                                  .low = -1e300,
                                  .high = 1e300,
                                  .allowed = "two numbers, the smaller first",
                                  .without = "in a study with [model] it must be given",
                                  .meaning = "least and largest size; logarithmic above 0"};

inline constexpr Key correction_channel{.table = "[[corrections]]",
                                        .key = "channel",
                                        .allowed = "a channel, below",
                                        .meaning = "the variable that the factor follows"};
inline constexpr Key correction_layer{.table = "[[corrections]]",
                                      .key = "layer",
                                      .allowed = "a layer of the study",
                                      .without = "of channels of readings it is",
                                      .meaning = "whose modulus is multiplied"};
inline constexpr Key correction_at_mm{.table = "[[corrections]]",
                                      .key = "at_mm",
                                      .kind = numbers,
                                      .low = 0.0,
                                      .high = 1e5,
                                      .without = "of channels of stress it is",
                                      .meaning = "places, rising"};
inline constexpr Key correction_at_kPa{.table = "[[corrections]]",
                                       .key = "at_kPa",
                                       .kind = numbers,
                                       .low = 0.0,
                                       .high = 1e6,
                                       .without = "of all other channels it is",
                                       .meaning = "stresses, rising, six at most"};
inline constexpr Key correction_factor{
    .table = "[[corrections]]",
    .key = "factor",
    .kind = numbers,
    .low = 0.0,
    .high = 1e3,
    .low_is_open = true,
    .meaning = "what multiplies the modulus, or the reading, there; between the places its logarithm is interpolated"};

inline constexpr Key parameter_name{.table = "[[parameters]]",
                                    .key = "name",
                                    .allowed = "LAYER.KEY, LOAD.KEY, EFFECT.size or CORRECTION.factor_1, ...",
                                    .meaning = "what is varied"};
inline constexpr Key parameter_scale{.table = "[[parameters]]",
                                     .key = "scale",
                                     .kind = word,
                                     .default_value = 0,
                                     .choices = scales,
                                     .meaning = "equal steps, or equal ratios"};
inline constexpr Key parameter_min{.table = "[[parameters]]",
                                   .key = "min",
                                   .kind = number,
                                   .allowed = "the range of its key",
                                   .meaning = "lower bound"};
inline constexpr Key parameter_max{.table = "[[parameters]]",
                                   .key = "max",
                                   .kind = number,
                                   .allowed = "the range of its key, above min",
                                   .meaning = "upper bound"};
inline constexpr Key parameter_prior{.table = "[[parameters]]",
                                     .key = "prior",
                                     .kind = table,
                                     .allowed = "`{ mean = ..., sd = ... }`",
                                     .without = "nothing but the bounds is known",
                                     .meaning =
                                         "what is known without the readings: normal; with scale `log`, the logarithm "
                                         "is"};
inline constexpr Key prior_mean{.table = "prior of a parameter",
                                .key = "mean",
                                .kind = number,
                                .allowed = "`min` to `max`",
                                .meaning = "its mean; with scale `log` its median"};
inline constexpr Key prior_sd{.table = "prior of a parameter",
                              .key = "sd",
                              .kind = number,
                              .low = 0.0,
                              .high = 1e9,
                              .low_is_open = true,
                              .meaning = "its standard deviation; with scale `log` that of the natural logarithm"};
inline constexpr Key parameter_value{.table = "[[parameters]]",
                                     .key = "value",
                                     .kind = number,
                                     .low = -1e300,
                                     .high = 1e300,
                                     .without = "the middle of the range",
                                     .meaning =
                                         "with [model]: where the study itself stands; of the built-in model the "
                                         "layers and loads say it"};
inline constexpr Key parameter_equals{
    .table = "[[parameters]]",
    .key = "equals",
    .allowed = "arithmetic of numbers, LAYER.KEY, LOAD.KEY and EFFECT.size",
    .without = "it is searched between min and max",
    .meaning = "the number is not searched but follows others, as in `0.7 * base.k1`; then no other key stands here"};
inline constexpr Key parameter_points{.table = "[[parameters]]",
                                      .key = "points",
                                      .kind = whole_number,
                                      .low = 1,
                                      .high = 100000,
                                      .without = "as many as the design asks for",
                                      .meaning = "of a grid along this axis; 1 holds it at the study's value"};

inline constexpr Key parameter_level{
    .table = "[[parameters]]",
    .key = "level",
    .kind = word,
    .default_value = 0,
    .choices = levels,
    .meaning = "of a road: one value at every station, in every homogeneous section, or for the whole road; other "
               "commands know one section only"};
inline constexpr Key correlation_between{.table = "[[prior_correlations]]",
                                         .key = "between",
                                         .kind = texts,
                                         .allowed = "the names of two parameters with a prior",
                                         .meaning = "whose errors are correlated"};
inline constexpr Key correlation_value{.table = "[[prior_correlations]]",
                                       .key = "value",
                                       .kind = number,
                                       .low = -1.0,
                                       .high = 1.0,
                                       .low_is_open = true,
                                       .meaning = "by how much, on the scales of the parameters"};

inline constexpr Key constraint_that{
    .table = "[[constraints]]",
    .key = "that",
    .allowed = "two sides with `<=`, `>=` or `==` between them, each arithmetic of numbers, LAYER.KEY, LOAD.KEY, "
               "EFFECT.size and names of outputs",
    .meaning = "what the answer must meet, as in `base.k1 <= 3 * subbase.k1`"};

inline constexpr std::string_view criterion_places[] = {"asphalt-bottom", "subgrade-top"};
inline constexpr Key criterion_name{
    .table = "[[criteria]]", .key = "name", .allowed = "a text", .meaning = "what reports call it"};
inline constexpr Key criterion_law{.table = "[[criteria]]",
                                   .key = "law",
                                   .allowed = "a law of [design.md](../guide/design.md), or `expression`",
                                   .meaning = "how many repetitions are allowed; some laws have keys of their own"};
inline constexpr Key criterion_axle{.table = "[[criteria]]",
                                    .key = "axle",
                                    .allowed = "a load of the study",
                                    .meaning = "under which the strain is evaluated, and which is counted"};
inline constexpr Key criterion_layer{.table = "[[criteria]]",
                                     .key = "layer",
                                     .allowed = "a layer of the study",
                                     .without = "the top layer, or the last one",
                                     .meaning = "at whose bottom (asphalt) or top (subgrade) the strain is evaluated"};
inline constexpr Key criterion_modulus{.table = "[[criteria]]",
                                       .key = "modulus_MPa",
                                       .kind = number,
                                       .low = 0.0,
                                       .high = 1e5,
                                       .low_is_open = true,
                                       .without = "`modulus_MPa` of the layer",
                                       .meaning = "modulus of the asphalt in the law"};
inline constexpr Key criterion_traffic{.table = "[[criteria]]",
                                       .key = "traffic_per_year",
                                       .kind = number,
                                       .low = 0.0,
                                       .high = 1e12,
                                       .low_is_open = true,
                                       .meaning = "repetitions of the axle in the first year from now"};
inline constexpr Key criterion_growth{.table = "[[criteria]]",
                                      .key = "growth",
                                      .kind = number,
                                      .low = -0.2,
                                      .high = 0.5,
                                      .default_value = 0.0,
                                      .meaning = "of the traffic a year, 0.03 for 3 %"};
inline constexpr Key criterion_passed{.table = "[[criteria]]",
                                      .key = "passed",
                                      .kind = number,
                                      .low = 0.0,
                                      .high = 1e15,
                                      .default_value = 0.0,
                                      .meaning = "repetitions so far"};
inline constexpr Key criterion_design{.table = "[[criteria]]",
                                      .key = "design_traffic",
                                      .kind = number,
                                      .low = 0.0,
                                      .high = 1e15,
                                      .low_is_open = true,
                                      .without = "the traffic of `--years`",
                                      .meaning = "repetitions still to come, which an overlay must last"};
inline constexpr Key criterion_life{.table = "[[criteria]]",
                                    .key = "life",
                                    .allowed = "arithmetic of numbers, `strain` (microstrain) and `modulus`",
                                    .without = "other laws have their own",
                                    .meaning =
                                        "with law `expression`: the allowable repetitions, as in `(9300 / strain)^7`"};
inline constexpr Key criterion_place{.table = "[[criteria]]",
                                     .key = "place",
                                     .kind = word,
                                     .choices = criterion_places,
                                     .without = "other laws have their own",
                                     .meaning = "with law `expression`: horizontal tension at the bottom of the "
                                                "asphalt, or vertical compression at the top of the subgrade"};

inline constexpr Key season_name{
    .table = "[[seasons]]", .key = "name", .allowed = "a text", .meaning = "what reports call it"};
inline constexpr Key season_share{.table = "[[seasons]]",
                                  .key = "share",
                                  .kind = number,
                                  .low = 0.0,
                                  .high = 1.0,
                                  .low_is_open = true,
                                  .meaning = "of the year's traffic; all seasons together 1"};
inline constexpr Key season_factors{.table = "[[seasons]]",
                                    .key = "factors",
                                    .kind = table,
                                    .allowed = "LAYER = above 0, up to 100",
                                    .without = "1 each",
                                    .meaning = "stiffness of layers over that at the time of the readings"};
inline constexpr Key season_asphalt{.table = "[[seasons]]",
                                    .key = "asphalt_C",
                                    .kind = number,
                                    .low = -30.0,
                                    .high = 80.0,
                                    .without = "as at the time of the readings",
                                    .meaning = "temperature of the top layer, in place of a factor: its modulus is "
                                               "10^(-0.021 (asphalt_C - tested_C)) of that of the readings"};
inline constexpr Key season_tested{.table = "[[seasons]]",
                                   .key = "tested_C",
                                   .kind = number,
                                   .low = -30.0,
                                   .high = 80.0,
                                   .without = "must be given with `asphalt_C`",
                                   .meaning = "its temperature at the time of the readings"};

} // namespace keys

// In the order of docs/reference/keys.md.
std::span<const Key> study_keys();

} // namespace explore::study
