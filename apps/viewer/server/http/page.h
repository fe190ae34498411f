// The page as it was built into the program; see apps/viewer/server/http/embed.cmake.
#pragma once

#include <string_view>

namespace sqmap::viewer {

/// A file of the page: "index.html", "app.js", "app.css", "favicon.svg"; empty where there is none.
[[nodiscard]] std::string_view page_file(std::string_view name) noexcept;
/// False where the program was built without npm.
[[nodiscard]] bool has_page() noexcept;

}  // namespace sqmap::viewer
