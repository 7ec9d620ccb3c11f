// A map as KML, which globe viewers open.
#pragma once

#include "report/json.h"

namespace explore::report {

// map: a FeatureCollection of points with properties, as survey_geojson() makes it. A placemark a feature, its name the
// property "station", the other properties as extended data; those that are null are left out.
std::string kml_of(const Json& map, const std::string& name);

} // namespace explore::report
