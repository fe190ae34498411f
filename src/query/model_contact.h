// The answer for one point in model space.
#pragma once

#include "sqmap/query/contact.h"

namespace sqmap::query {

/// Lengths in model units, vectors in the model's axes.
struct ModelContact {
    Vec3f witness{};         ///< nearest surface point; the query point where free
    Vec3f normal{};          ///< unit, outward, at the witness point; zero where free
    float depth = 0;         ///< distance to the surface, >= 0; zero where free
    std::int32_t part = -1;  ///< that owns the witness point; -1 where free
    bool contact = false;
    bool certain = false;
    std::uint8_t status = k_ok;
};

/// A point without contact. certain: it is proven to be free.
[[nodiscard]] constexpr ModelContact free_at(Vec3f point, bool certain = true) noexcept
{
    ModelContact contact;
    contact.witness = point;
    contact.certain = certain;
    return contact;
}

/// The same contact as a probe reports it, for the point of an index; still in model space.
[[nodiscard]] constexpr Contact contact_of(const ModelContact& c, std::uint32_t index) noexcept
{
    return {c.witness, c.normal, c.depth, index, static_cast<std::int16_t>(c.part), c.certain, c.status};
}

}  // namespace sqmap::query
