// Rules for the name of a part.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

namespace sqmap::viewer {

inline constexpr std::size_t k_max_name = 60;  ///< bytes

/// False for what is empty, longer than k_max_name, or has control characters.
[[nodiscard]] inline bool is_name(const std::string& text)
{
    return !text.empty() && text.size() <= k_max_name &&
           std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

}  // namespace sqmap::viewer
