// [model]: a forward function that is not ours, and what a study then holds in place of a section. Private to study/.
#pragma once

#include "external/simulator.h"
#include "problem/parameter_space.h"
#include "study/own_effects.h"
#include "study/read_load.h"
#include "study/table_reader.h"

namespace explore::study {

// The text of a file, where it may be no text: a file in the folder of every run.
inline constexpr std::string_view file_of_program = "file of the program";

// Before anything else is read. Throws pave::Error for tables that belong to the built-in model.
void begin_own_model(Study& study, const toml::table& table);

// Throws pave::Error at `place` for what cannot be the name of a parameter of a model of your own.
void check_own_name(const std::string& name, const pave::Place& place);
// One more value of the model, or the size of an effect that the study has.
pave::pavement::Parameter add_own_parameter(Study& study, const std::string& name, const pave::Place& place);
// The value of a parameter where the study itself stands: stated, or the middle of its range.
double own_value(TableReader& reader, const problem::Axis& axis);
// A sensor for a reading, by its place alone.
pave::pavement::Sensor own_sensor(Study& study, const data::Reading& reading);
void read_own_output(const toml::table& table, Study& study);
// Throws pave::Error where another output has that name.
void check_new_output(const Study& study, const std::string& name, const pave::Place& place);

// When all parameters, readings and outputs are known. Throws pave::Error for what no model of your own can have.
void check_own_model(const Study& study);
// Then one of these two makes study.external; it throws pave::Error. What the files of the model hold that changes its
// responses.
std::string read_model(const toml::table& table, Study& study, std::shared_ptr<const OwnEffects> effects,
                       const TextReader& read_text);
void set_function(Study& study, std::shared_ptr<const external::Simulator> function,
                  std::shared_ptr<const OwnEffects> effects);

} // namespace explore::study
