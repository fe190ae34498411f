// Positions and directions as options have them: 0.1,0,0 or 0/0/1.
#pragma once

#include "sqmap/math/vec.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace sqmap::app {

/// Three finite numbers with one of the separators between them; none where the text is anything else.
inline std::optional<Vec3d> three_numbers(std::string_view text, std::string_view separators = ",")
{
    Vec3d v;
    const char *c = text.data(), *const last = c + text.size();
    for (int i = 0; i < 3; ++i) {
        const auto [end, error] = std::from_chars(c, last, v[i]);
        const bool ends_well = i < 2 ? end != last && separators.find(*end) != std::string_view::npos : end == last;
        if (error != std::errc() || !std::isfinite(v[i]) || !ends_well) return {};
        c = end + 1;
    }
    return v;
}

}  // namespace sqmap::app
