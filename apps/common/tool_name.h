// Tools that are named by words, as `sqmap touch --tool` takes them and its recordings keep them: NAME or NAME:RADIUS, m.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string>

namespace sqmap::app {

inline constexpr double k_tool_radius = 0.005;  ///< of a sphere without a radius, m

/// The radius, which is `otherwise` for NAME alone and NaN where no number follows; nothing for any other tool.
[[nodiscard]] inline std::optional<double> tool_radius(const std::string& tool, const std::string& name, double otherwise)
{
    if (tool == name) return otherwise;
    if (!tool.starts_with(name + ":")) return std::nullopt;
    double radius = 0;
    const char* const last = tool.data() + tool.size();
    const auto [end, error] = std::from_chars(tool.data() + name.size() + 1, last, radius);
    return error == std::errc() && end == last ? radius : std::nan("");
}

}  // namespace sqmap::app
