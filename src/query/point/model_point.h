// The query of one point in model space.
#pragma once

#include "sqmap/query/contact.h"
#include "sqmap/query/options.h"

namespace sqmap::query {

/// The answer for one point, model space.
struct ModelContact {
    Vec3f point{};           ///< nearest surface point; the query point where free
    Vec3f normal{};          ///< unit, outward, at that surface point; zero where free
    float depth = 0;         ///< distance to the surface, >= 0; zero where free
    std::int32_t part = -1;  ///< that owns the surface point; -1 where free
    bool contact = false;
    bool certain = false;
    std::uint8_t status = k_ok;
};

/// As query_point.
[[nodiscard]] ModelContact query_in_model(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;

/// As a probe's contact has it.
[[nodiscard]] constexpr Contact contact_of(const ModelContact& c, std::uint32_t index) noexcept
{
    return {c.point, c.normal, c.depth, index, static_cast<std::int16_t>(c.part), c.certain, c.status};
}

}  // namespace sqmap::query
