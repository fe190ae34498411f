// Facts about an object as JSON: those that stay in sight, and the superquadrics as a file.
#pragma once

#include "viewer/server/scene/object.h"

#include <nlohmann/json.hpp>

namespace sqmap::viewer {

/// Parts, bytes, certificates, measured error and notes, as the page shows them. edited: the parts are not those of the model.
[[nodiscard]] nlohmann::ordered_json facts_json(const Object& object, const Parts& parts, bool edited);
/// Parameters of every superquadric, mesh units, in the mesh's frame; those of taper have no unit.
[[nodiscard]] nlohmann::ordered_json superquadrics_json(const Object& object, const Parts& parts);

}  // namespace sqmap::viewer
