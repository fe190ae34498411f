// Content hashes as sixteen hexadecimal digits, in reports, traces and messages.
#pragma once

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

namespace sqmap::app {

[[nodiscard]] inline std::string hash_text(std::uint64_t hash)
{
    char text[20];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

/// Nothing for a text that is no hexadecimal number of 64 bits.
[[nodiscard]] inline std::optional<std::uint64_t> hash_from(std::string_view text)
{
    std::uint64_t hash = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), hash, 16);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return hash;
}

}  // namespace sqmap::app
