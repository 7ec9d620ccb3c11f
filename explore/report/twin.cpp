#include "report/twin.h"

#include "base/text.h"
#include "pavement/effects/effect.h"
#include "report/text.h"

#include <fmt/format.h>

namespace explore::report {

std::string twin_csv(const analysis::TwinResult& twin) {
    std::string text =
        fmt::format("# Synthetic: {}, noise {:g} of each value, seed {}\n"
                    "# {}\n",
                    pave::printable(twin.study.title), twin.options.noise, twin.options.seed, signs(twin.study));
    for (const auto& applied : twin.study.model.effects) {
        text += fmt::format("# effect: {} = {} [{}]\n", applied.effect->name, applied.size, applied.effect->unit);
    }
    return text + data::measurement_rows(twin.readings);
}

Json twin_json(const analysis::TwinResult& twin, const std::string& file) {
    if (twin.status != pave::Status::converged) {
        return {{"status", std::string(to_string(twin.status))}, {"reason", twin.reason}};
    }
    Json rows = Json::array();
    for (std::size_t i = 0; i < twin.readings.size(); ++i) {
        const data::Reading& reading = twin.readings[i];
        Json row = place_json(reading);
        row["value"] = reading.value;
        row["exact"] = twin.exact[i];
        row["unit"] = std::string(reading.unit.name);
        rows.push_back(std::move(row));
    }
    return {{"file", file}, {"measurements", rows}};
}

} // namespace explore::report
