// Stored values of one cell or sample, decoded as the kernels decode them many at a time.
#pragma once

#include "bake/locator/gaps.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::test {

/// How far a point is below a plane, model units. offset: from the centre of its cell, model units.
inline float plane_gap(const model::Locator& locator, model::LocatorPlane plane, Vec3f offset)
{
    return plane.distance(locator.plane_reach) * locator.cell - dot(plane.normal(), offset);
}

/// How far a point is below the planes of a flat cell, model units. offset: from the cell's centre, model units.
inline bake::FlatGap flat_gap(const model::Locator& locator, std::span<const std::uint32_t> planes, Vec3f offset)
{
    return bake::flat_gap(
        planes.size(), [&](std::size_t k) { return plane_gap(locator, {planes[k]}, offset); },
        [&](std::size_t k) { return model::LocatorPlane{planes[k]}.is_joined(); });
}

/// The normal of a code that model::encode_normal gave.
inline Vec3f decode_normal(std::uint16_t code) noexcept
{
    float u = static_cast<float>(code & 255u) / 127.5f - 1, v = static_cast<float>(code >> 8) / 127.5f - 1;
    const float z = 1 - std::abs(u) - std::abs(v);
    if (z < 0) {
        const float fold = (1 - std::abs(v)) * (u < 0 ? -1.0f : 1.0f);
        v = (1 - std::abs(u)) * (v < 0 ? -1.0f : 1.0f);
        u = fold;
    }
    return normalized(Vec3f{u, v, z});
}

}  // namespace sqmap::test
