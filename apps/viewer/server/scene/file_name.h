// Names of files that come from a browser or go there.
#pragma once

#include <string>
#include <string_view>

namespace sqmap::viewer {

/// A file's name as the browser has it, for people and for its extension; it is never opened.
[[nodiscard]] std::string harmless(std::string_view name);

}  // namespace sqmap::viewer
