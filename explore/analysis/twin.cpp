#include "analysis/twin.h"

#include "base/error.h"
#include "base/random.h"

#include <cmath>

namespace explore::analysis {

TwinResult twin(study::Study study, const TwinOptions& options) {
    for (const auto& [name, size] : options.effects) {
        study = study::with_effect(std::move(study), name, size, {.key = "--effect"});
    }
    const auto measured = study.measured();
    if (measured.empty()) {
        throw pave::Error({.file = study.file, .key = "data"}, "a twin needs a layout of sensors", {},
                          "[data] files = [...]: their values are replaced, their places kept");
    }
    TwinResult result{.study = study, .options = options};
    const pave::pavement::ForwardModel model(study.model);
    const auto outcome = model.run(study.model, {}, *model.make_workspace());
    result.status = outcome.status();
    if (!outcome) {
        result.reason = outcome.failure().reason;
        return result;
    }
    const pave::RandomStream random(options.seed, 1);
    for (std::size_t i = 0; i < measured.size(); ++i) {
        data::Reading reading = measured[i];
        const double exact = reading.in_unit(outcome->values[i]);
        reading.value = exact * (1.0 + options.noise * random.normal(i));
        reading.sigma = options.noise > 0.0 ? std::optional(options.noise * std::abs(exact)) : std::nullopt;
        result.exact.push_back(exact);
        result.readings.push_back(std::move(reading));
    }
    return result;
}

} // namespace explore::analysis
