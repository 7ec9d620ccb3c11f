// The loads of a study, and the files that they name. Private to study/.
#pragma once

#include "base/error.h"
#include "study/study.h"

#include <functional>
#include <toml++/toml.h>

namespace explore::study {

// The text of a file beside the study that it names: of that name, and the path that messages call it by. place: of the
// name in the study; what: "measurement file".
struct NamedText {
    std::string path, text;
};
using TextReader = std::function<NamedText(const std::string& name, const pave::Place& place, std::string_view what)>;

// Throws pave::Error where a file that the study names lies outside its folder.
void check_inside(const Study& study, const std::string& name, const pave::Place& place);

// One of [[loads]]. outside: its history may lie outside the study's folder. Throws pave::Error.
pave::pavement::Load read_load(const toml::table& table, const Study& study, bool outside, const TextReader& read_text);

// Throws pave::Error where a load would be followed for too many steps.
void check_steps(const Study& study);

} // namespace explore::study
