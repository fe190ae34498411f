// Texts of the page's messages and addresses: JSON, numbers, names of parts.
#pragma once

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

namespace sqmap::viewer {

/// JSON as it is sent: valid UTF-8 whatever bytes a file's name has.
[[nodiscard]] inline std::string text_of(const nlohmann::ordered_json& json)
{
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// Takes the decimal number that a text begins with off the text; nothing where the text begins with none.
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

inline constexpr std::size_t k_max_name = 60;  ///< bytes of a part's name

/// False for a name that is empty, longer than k_max_name, or has control characters.
[[nodiscard]] inline bool is_name(const std::string& text)
{
    return !text.empty() && text.size() <= k_max_name &&
           std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

}  // namespace sqmap::viewer
