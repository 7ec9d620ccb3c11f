#include "study/read_solver.h"

#include "base/units.h"
#include "pavement/forward.h"
#include "study/keys.h"
#include "study/table_reader.h"

#include <cmath>

namespace explore::study {
namespace {

// path_tolerance is the older way of saying it, of a path whose steps were as long as it allowed.
void read_load_steps(TableReader& reader, Study& study) {
    int& steps = study.model.settings.solver.load_steps;
    const bool by_tolerance = reader.has(keys::solver_path);
    if (reader.has(keys::solver_load_steps)) {
        if (by_tolerance) {
            throw pave::Error(reader.place(keys::solver_path.key), "the number of load steps is said twice",
                              "load_steps and path_tolerance", "one of them");
        }
        steps = reader.integer(keys::solver_load_steps);
    } else if (by_tolerance) {
        constexpr double of_default = 2e-3;
        steps = static_cast<int>(std::ceil(steps * std::cbrt(of_default / reader.number(keys::solver_path)) - 1e-9));
    } else {
        return;
    }
    study.load_steps = LoadSteps::stated;
}

} // namespace

void read_solver(const toml::table& table, Study& study) {
    TableReader reader(table, study.file, "[solver]");
    auto& settings = study.model.settings;
    settings.integration = static_cast<pave::pavement::Integration>(reader.choice(keys::solver_integration));
    check_integration(study.model, reader.place(keys::solver_integration.key));
    read_load_steps(reader, study);
    settings.solver.equilibrium_tolerance = reader.number(keys::solver_equilibrium);
    if (reader.has(keys::solver_time_limit)) {
        settings.solver.time_limit = reader.number(keys::solver_time_limit);
    }
    settings.time_step = pave::unit::ms * reader.number(keys::solver_time_step);
    reader.done();
}

} // namespace explore::study
