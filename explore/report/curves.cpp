#include "report/curves.h"

namespace explore::report {

Json curves_json(const std::vector<analysis::Curve>& curves) {
    Json list = Json::array();
    for (const analysis::Curve& c : curves) {
        Json values = Json::array();
        for (const double value : c.values) {
            values.push_back(finite_json(value));
        }
        list.push_back({{"load", c.load},
                        {"quantity", c.quantity},
                        {"by_depth", c.by_depth},
                        {"x_mm", c.x_mm},
                        {"y_mm", c.y_mm},
                        {"depth_mm", c.depth_mm},
                        {"gauge_mm", c.gauge_mm},
                        {"unit", c.unit},
                        {"to_si", data::unit_named(c.unit).to_si},
                        {"at_mm", c.at_mm},
                        {"values", std::move(values)}});
    }
    return list;
}

} // namespace explore::report
