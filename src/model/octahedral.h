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
    constexpr std::uint32_t k_mask = (1u << bits) - 1u;
    constexpr float k_step = 2.f / static_cast<float>(1 << bits), k_first = 0.5f * k_step - 1.f;
    const float x = static_cast<float>(code & k_mask) * k_step + k_first;
    const float y = static_cast<float>((code >> bits) & k_mask) * k_step + k_first;
    const float z = 1.f - std::abs(x) - std::abs(y), fold = std::max(-z, 0.f);
    return normalized(Vec3f{x < 0.f ? x + fold : x - fold, y < 0.f ? y + fold : y - fold, z});
}

/// Code of a vector's direction; n need not be of unit length.
template <int bits>
inline std::uint32_t octahedral_code(Vec3d n)
{
    constexpr int k_cells = 1 << bits;
    n = n / std::max(std::abs(n.x) + std::abs(n.y) + std::abs(n.z), 1e-300);
    const double x = n.z < 0 ? (1 - std::abs(n.y)) * (n.x < 0 ? -1 : 1) : n.x;
    const double y = n.z < 0 ? (1 - std::abs(n.x)) * (n.y < 0 ? -1 : 1) : n.y;
    const auto code = [](double v) {
        return static_cast<std::uint32_t>(std::clamp(static_cast<int>((v + 1) * 0.5 * k_cells), 0, k_cells - 1));
    };
    return code(x) | code(y) << bits;
}

/// The paper maps' code: 8 + 8 bits whose ends are the octahedron's corners; error below 1 degree.
inline std::uint16_t encode_normal(Vec3f n) noexcept
{
    const float sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    if (!(sum > 0)) return encode_normal({0, 0, 1});
    float u = n.x / sum, v = n.y / sum;
    if (n.z < 0) {
        const float fold = (1 - std::abs(v)) * (u < 0 ? -1.0f : 1.0f);
        v = (1 - std::abs(u)) * (v < 0 ? -1.0f : 1.0f);
        u = fold;
    }
    const auto code = [](float w) { return static_cast<unsigned>(std::lround(std::clamp((w + 1) * 127.5f, 0.0f, 255.0f))); };
    return static_cast<std::uint16_t>(code(u) | code(v) << 8);
}

}  // namespace sqmap::model
