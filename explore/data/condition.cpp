#include "data/condition.h"

namespace explore::data {
namespace {

struct Limits {
    double warning, severe;
};
struct LimitsOfBase {
    Limits d0, roc, sci, bdi, bci;
};
constexpr std::array<LimitsOfBase, 3> limits = {{
    {{500, 750}, {100, 50}, {200, 400}, {100, 200}, {50, 100}},
    {{400, 600}, {250, 100}, {200, 400}, {100, 200}, {50, 100}},
    {{200, 400}, {150, 80}, {100, 300}, {50, 100}, {40, 80}},
}};

std::optional<Condition> class_of(const std::optional<double>& value, const Limits& limit) {
    if (!value) {
        return std::nullopt;
    }
    const double sign = limit.severe > limit.warning ? 1.0 : -1.0; // of a radius the small one is severe
    return sign * (*value - limit.severe) > 0.0     ? Condition::severe
           : sign * (*value - limit.warning) >= 0.0 ? Condition::warning
                                                    : Condition::sound;
}

} // namespace

ConditionClasses condition_of(const BowlIndices& indices, BaseKind base) {
    const LimitsOfBase& of = limits[static_cast<std::size_t>(base)];
    return {.d0 = class_of(indices.d0_um, of.d0),
            .roc = class_of(indices.curvature_radius_m, of.roc),
            .sci = class_of(indices.sci_um, of.sci),
            .bdi = class_of(indices.bdi_um, of.bdi),
            .bci = class_of(indices.bci_um, of.bci)};
}

} // namespace explore::data
