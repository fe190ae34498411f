// The answer for one point in model space.
#pragma once

#include "sqmap/query/contact.h"

namespace sqmap::query {

/// Lengths in model units, vectors in the model's axes.
struct ModelContact {
    Vec3f point{};           ///< nearest surface point; the query point where free
    Vec3f normal{};          ///< unit, outward, at that surface point; zero where free
    float depth = 0;         ///< distance to the surface, >= 0; zero where free
    std::int32_t part = -1;  ///< that owns the surface point; -1 where free
    bool contact = false;
    bool certain = false;
    std::uint8_t status = k_ok;
};

/// The same contact as a probe reports it, for the point of an index; still in model space.
[[nodiscard]] constexpr Contact contact_of(const ModelContact& c, std::uint32_t index) noexcept
{
    return {c.point, c.normal, c.depth, index, static_cast<std::int16_t>(c.part), c.certain, c.status};
}

}  // namespace sqmap::query
