// [[effects]] of a study with [model]: switches of a model that is not ours, and what instruments do to its readings.
#pragma once

#include "external/model.h"
#include "pavement/effects/effect.h"
#include "study/study.h"
#include "study/table_reader.h"

#include <deque>

namespace explore::study {

// An effect that a study declares. Where it has a size the study's model has it already, else it may lack it.
struct OwnEffect {
    std::string name, parameter, mechanism, acts_on; // what `effect` refers to
    pave::Place place;                               // of its parameter
    pave::pavement::Effect effect;
};
using OwnEffects = std::deque<OwnEffect>; // whose addresses stay

// The type of Study::external.
struct OwnModel : external::Model {
    OwnModel(std::shared_ptr<const external::Simulator> simulator, problem::ParameterSpace space,
             std::vector<double> to_si, std::shared_ptr<const OwnEffects> declared);
    std::shared_ptr<const OwnEffects> effects;
};

// Those of a study, with the ones that have a size, and with wrong readings and gains that are stated, in study.model.
std::shared_ptr<const OwnEffects> read_own_effects(const std::vector<const toml::table*>& tables, Study& study);
// Throws pave::Error for one whose parameter is fitted.
void check_own_effects(const OwnEffects& effects, const Study& study);

// Every effect that the study may lack: of a model of its own what it declares, wrong readings and gains.
std::vector<const pave::pavement::Effect*> effects_of(const Study& study);

// The effect that the study may lack or have by this name. Throws pave::Error at `place` for a name that none has.
const pave::pavement::Effect& effect_named(const Study& study, const std::string& name, const pave::Place& place);

// The size of an effect in study.model; nothing: the path names none.
std::optional<pave::pavement::Parameter> own_size(const Study& study, const std::string& path);

// The responses of the study's own model as a function of these parameters; the others stand at its own values.
std::shared_ptr<const problem::ForwardFunction> own_function(const Study& study,
                                                             const std::vector<pave::pavement::Parameter>& parameters);

} // namespace explore::study
