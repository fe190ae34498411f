// The setup of a recording of sqmap touch, its tool and its force, as settings of the page.
#pragma once

#include "viewer/server/protocol/messages.h"

#include <nlohmann/json.hpp>

namespace sqmap::viewer {

/// The page's settings that are nearest to the field `setup` of a trace (docs/trace-format.md).
/// @throw device::TraceError for what sqmap touch can do and the page cannot show: objects that move, a coupled tool, a tool that
/// is neither ball nor point, numbers beyond those of the page
[[nodiscard]] Settings settings_of(const nlohmann::json& setup);

}  // namespace sqmap::viewer
