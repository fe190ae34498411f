// Numbers in the words of an address.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

namespace sqmap::viewer {

/// The decimal number that text begins with, which is taken off it; nothing where it begins with none.
/// By strtod, since not every standard library has std::from_chars for doubles.
[[nodiscard]] inline std::optional<double> take_number(std::string_view& text)
{
    constexpr std::size_t k_longest = 32;
    const std::string copy(text.substr(0, k_longest));
    char* end = nullptr;
    const double value = std::strtod(copy.c_str(), &end);
    if (end == copy.c_str()) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - copy.c_str()));
    return value;
}

}  // namespace sqmap::viewer
