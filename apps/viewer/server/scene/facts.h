// Facts about an object as JSON: those that stay in sight.
#pragma once

#include "viewer/server/scene/object.h"

#include <nlohmann/json.hpp>

namespace sqmap::viewer {

/// Parts, bytes, certificates, measured error and notes, as the page shows them. edited: the parts are not those of the model.
[[nodiscard]] nlohmann::ordered_json facts_json(const Object& object, const Parts& parts, bool edited);

}  // namespace sqmap::viewer
