// Unit vectors in 2 x bits bits: the octahedron unfolded onto a square (Q. Meyer et al., On floating-point normal vectors, 2010).
#pragma once

#include "sqmap/math/vec.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sqmap::model {

/// Unit vector of a code; bits above 2 x bits are ignored.
template <int bits>
inline Vec3f octahedral_normal(std::uint32_t code)
{
    constexpr std::uint32_t mask = (1u << bits) - 1u;
    constexpr float step = 2.f / static_cast<float>(1 << bits), first = 0.5f * step - 1.f;
    const float x = static_cast<float>(code & mask) * step + first;
    const float y = static_cast<float>((code >> bits) & mask) * step + first;
    const float z = 1.f - std::abs(x) - std::abs(y), fold = std::max(-z, 0.f);
    return normalized(Vec3f{x < 0.f ? x + fold : x - fold, y < 0.f ? y + fold : y - fold, z});
}

/// Code of a vector's direction; n need not be of unit length.
template <int bits>
inline std::uint32_t octahedral_code(Vec3d n)
{
    constexpr int cells = 1 << bits;
    n = n / std::max(std::abs(n.x) + std::abs(n.y) + std::abs(n.z), 1e-300);
    const double x = n.z < 0 ? (1 - std::abs(n.y)) * (n.x < 0 ? -1 : 1) : n.x;
    const double y = n.z < 0 ? (1 - std::abs(n.x)) * (n.y < 0 ? -1 : 1) : n.y;
    const auto code = [](double v) {
        return static_cast<std::uint32_t>(std::clamp(static_cast<int>((v + 1) * 0.5 * cells), 0, cells - 1));
    };
    return code(x) | code(y) << bits;
}

}  // namespace sqmap::model
