// A program as a model: a folder of its own for each run, input files from templates, readings from what it writes.
#pragma once

#include "external/outputs.h"
#include "external/simulator.h"
#include "external/template.h"

#include <memory>

namespace explore::external {

// Which folders of runs stay.
enum class Keep { failed, all, none };
inline constexpr std::string_view keep_names[] = {"failed", "all", "none"};

struct ProgramSettings {
    std::vector<std::string> command;
    struct Input {
        Template from;
        std::string file; // in the folder of the run
    };
    std::vector<Input> inputs;
    struct Link {
        std::string name, target; // in the folder of the run; absolute
    };
    std::vector<Link> files;
    std::vector<OutputFile> outputs;
    double time_limit = 0.0; // s; 0: none
    Keep keep = Keep::failed;
};

// names: of the parameters; wanted: the responses.
std::shared_ptr<const Simulator> make_program(ProgramSettings settings, std::vector<std::string> names,
                                              std::vector<Wanted> wanted);
// Throws nlohmann::json::exception for what is no description of one.
std::shared_ptr<const Simulator> program_of(const nlohmann::json& description);

} // namespace explore::external
