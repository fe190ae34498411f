// Arrays of parts, one behind another.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// Puts some behind all; returns where it begins.
template <class T>
std::uint32_t append(std::span<const T> some, std::vector<T>& all)
{
    const auto first = static_cast<std::uint32_t>(all.size());
    all.insert(all.end(), some.begin(), some.end());
    return first;
}
template <class T>
std::uint32_t append(const std::vector<T>& some, std::vector<T>& all)
{
    return append(std::span<const T>(some), all);
}

}  // namespace sqmap::bake
