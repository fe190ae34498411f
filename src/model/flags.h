// Flag bits of parts, and the words of triangles: the part that each belongs to and what of it is boundary.
#pragma once

#include "sqmap/model/model.h"

#include <cstddef>
#include <cstdint>

namespace sqmap::model {

/// The bits of Part::flags.
enum PartFlag : std::uint32_t {
    k_centre_inside = 1u,  ///< the chart's centre lies in the solid
    k_fit_fallback = 2u,   ///< the closed-form ellipsoid bounds the part
};

/// The bits of an entry of triangle_part.
enum SurfaceFlag : std::uint16_t {
    k_part_mask = 0x1fff,
    k_made_up = 0x2000,  ///< nothing of the input stood there: see Cure
    k_buried = 0x4000,   ///< both sides are inside the solid: no boundary
    k_crossed = 0x8000,  ///< another triangle cuts it: of it only its pieces are boundary
};
inline constexpr std::size_t k_max_parts = k_part_mask;

constexpr std::uint16_t triangle_word(std::uint32_t part, std::uint16_t flags)
{
    return static_cast<std::uint16_t>(part | flags);
}
constexpr std::uint32_t part_of(std::uint16_t triangle_word) { return triangle_word & k_part_mask; }
/// The flags of a triangle's word that say how much of the triangle is boundary.
constexpr std::uint16_t flags_of(std::uint16_t triangle_word)
{
    return static_cast<std::uint16_t>(triangle_word & (k_buried | k_crossed));
}
constexpr bool is_made_up(std::uint16_t triangle_word) { return (triangle_word & k_made_up) != 0; }
constexpr bool is_buried(std::uint16_t triangle_word) { return (triangle_word & k_buried) != 0; }
constexpr bool is_crossed(std::uint16_t triangle_word) { return (triangle_word & k_crossed) != 0; }

}  // namespace sqmap::model
