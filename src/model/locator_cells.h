// Words of the locator: bricks, cells, lists of parts, planes, seeds, rises. Each is written and read here.
//
// The locator is a uniform grid over the object that says, for a position, which part's chart answers there and on which chart
// the nearest surface lies. Four by four by four cells are a brick; one that is free as a whole is not stored, one that lies deep
// inside is a single cell. A cell may be divided in eight.
#pragma once

#include "model/octahedral.h"
#include "sqmap/math/assert.h"
#include "sqmap/model/model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace sqmap::model {

inline constexpr int k_brick = 4;  ///< cells along a brick's side
inline constexpr std::uint32_t k_brick_cells = 64;
inline constexpr int k_max_divisions = 2;              ///< of a cell
inline constexpr std::uint32_t k_max_first = 0x3ffff;  ///< greatest index that a cell can name
inline constexpr std::uint32_t k_max_planes = 7;       ///< of a cell
inline constexpr std::uint32_t k_max_seeds = 8;        ///< of a cell
inline constexpr std::uint32_t k_list_length = 4;      ///< parts in a list
inline constexpr std::uint32_t k_max_lists = 0x1ff;    ///< of a model
inline constexpr std::uint32_t k_no_part = 0xff;       ///< ends a shorter list
inline constexpr float k_gap_step = 1.f / 64;          ///< of a cell's side: unit of stored gaps
inline constexpr std::uint8_t k_no_rise = 0xff;

/// A lower bound of the distance from a centre to the solid. Rounded down, with margin for the runtime's own rounding.
inline std::uint32_t encode_gap(double gap, double cell)
{
    const double steps = std::floor(gap * (1 - 1e-5) / (cell * k_gap_step));
    return static_cast<std::uint32_t>(std::clamp(steps, 0.0, 1048575.0));
}

/// A brick: free as a whole, with a gap from its centre; deep, one cell; or stored, 64 cells from the first on, x fastest.
struct LocatorBrick {
    std::uint32_t word = 0;

    constexpr bool is_free() const { return (word & k_free) != 0; }
    constexpr std::uint32_t gap() const { return word & ~k_free; }
    /// @pre it is not free
    constexpr bool is_deep() const
    {
        SQMAP_ASSERT(!is_free());
        return (word & k_deep) != 0;
    }
    constexpr std::uint32_t first() const { return word & ~k_deep; }
    constexpr std::uint32_t cell_count() const { return is_deep() ? 1 : k_brick_cells; }

    static constexpr LocatorBrick free(std::uint32_t gap) { return {k_free | gap}; }
    static constexpr LocatorBrick deep(std::uint32_t first) { return {k_deep | first}; }
    static constexpr LocatorBrick stored(std::uint32_t first) { return {first}; }

    static constexpr std::uint32_t k_free = 1u << 31, k_deep = 1u << 30;
};

enum class LocatorCellKind : std::uint32_t {
    Free = 0,       ///< no point of the cell is in the solid
    Inside = 1,     ///< every point of it is
    Mixed = 2,      ///< the first part of the list whose chart holds a point decides; held by none, it is free
    Ambiguous = 3,  ///< too many parts for a list: all are tried
};

/// A cell. Free: the rest is its gap. Otherwise an index of part_lists, how many planes are the surface there (the cell is flat
/// where there are some), and an index of planes, or of seeds where there are none. Divided: an index of the eight cells, x
/// fastest.
struct LocatorCell {
    std::uint32_t word = 0;

    constexpr LocatorCellKind kind() const { return static_cast<LocatorCellKind>(word & k_kind_mask); }
    constexpr bool is_free() const { return kind() == LocatorCellKind::Free; }
    constexpr std::uint32_t gap() const { return word >> k_gap_shift; }
    constexpr std::uint32_t list() const { return (word >> k_list_shift) & k_list_mask; }
    constexpr std::uint32_t planes() const { return (word >> k_planes_shift) & k_planes_mask; }
    constexpr std::uint32_t first() const { return word >> k_first_shift; }
    constexpr bool is_divided() const { return (word & k_divided_mask) == k_divided; }
    constexpr bool is_flat() const { return !is_free() && !is_divided() && planes() > 0; }
    constexpr bool has_seeds() const { return !is_free() && !is_divided() && planes() == 0; }

    static constexpr LocatorCell free(std::uint32_t gap) { return {gap << k_gap_shift}; }
    static constexpr LocatorCell flat(LocatorCellKind kind, std::uint32_t list, std::uint32_t planes, std::uint32_t first)
    {
        return {static_cast<std::uint32_t>(kind) | list << k_list_shift | planes << k_planes_shift | first << k_first_shift};
    }
    static constexpr LocatorCell seeded(LocatorCellKind kind, std::uint32_t list, std::uint32_t first)
    {
        return flat(kind, list, 0, first);
    }
    static constexpr LocatorCell divided(std::uint32_t first) { return {k_divided | first << k_first_shift}; }

    static constexpr std::uint32_t k_kind_mask = 3, k_list_mask = 0x1ff, k_planes_mask = 7;
    static constexpr int k_gap_shift = 2, k_list_shift = 2, k_planes_shift = 11, k_first_shift = 14;
    /// Ambiguous, of the list that no model has.
    static constexpr std::uint32_t k_divided = 3u | k_max_lists << k_list_shift;
    static constexpr std::uint32_t k_divided_mask = k_kind_mask | k_list_mask << k_list_shift;
};

/// Four parts, lowest byte first; a shorter list ends with k_no_part.
using PartList = std::array<std::uint8_t, k_list_length>;
constexpr std::uint32_t encode_list(const PartList& parts)
{
    std::uint32_t list = 0;
    for (std::uint32_t k = 0; k < k_list_length; ++k) list |= std::uint32_t{parts[k]} << 8 * k;
    return list;
}
constexpr std::uint32_t part_in_list(std::uint32_t list, std::uint32_t slot) { return (list >> 8 * slot) & 0xffu; }
constexpr PartList decode_list(std::uint32_t list)
{
    PartList parts{};
    for (std::uint32_t k = 0; k < k_list_length; ++k) parts[k] = static_cast<std::uint8_t>(part_in_list(list, k));
    return parts;
}

/// A plane of a flat cell: 9 + 9 bits outward unit normal; 11 bits distance of the cell's centre below it, finer the nearer to
/// the surface; 2 bits: which part of the cell's list shows that surface; a flag. The
/// flag joins this plane with the one before it: the higher of the two counts. On a cell's first plane it says that this plane is
/// all that layer Two needs.
struct LocatorPlane {
    std::uint32_t word = 0;

    constexpr std::uint32_t slot() const { return (word >> k_slot_shift) & k_slot_mask; }
    constexpr bool is_joined() const { return (word & k_flag) != 0; }      ///< @pre it is not a cell's first
    constexpr bool is_sufficient() const { return (word & k_flag) != 0; }  ///< @pre it is a cell's first
    Vec3f normal() const { return octahedral_normal<k_normal_bits>(word); }
    /// In cells, from -1 on. reach: of the locator.
    constexpr float distance(float reach) const
    {
        const auto code = static_cast<float>((word >> k_distance_shift) & k_max_distance);
        return code * code * (reach / (float(k_max_distance) * float(k_max_distance))) - 1.f;
    }

    /// Towards a normal of any length, without distance.
    static LocatorPlane towards(Vec3d normal) { return {octahedral_code<k_normal_bits>(normal)}; }
    static bool holds_distance(double distance, float reach)
    {
        return !(distance < -1) && !(distance > static_cast<double>(reach) - 1);
    }
    /// The plane with another distance, in cells; what cannot be stored is clamped.
    LocatorPlane with_distance(double distance, float reach) const
    {
        constexpr double k_max = k_max_distance;
        const double share = std::sqrt(std::max(distance + 1, 0.0) / static_cast<double>(reach));
        const auto code = static_cast<std::uint32_t>(std::min(std::round(share * k_max), k_max));
        return {(word & ~(k_max_distance << k_distance_shift)) | code << k_distance_shift};
    }
    constexpr LocatorPlane with_slot(std::uint32_t slot) const
    {
        return {(word & ~(k_slot_mask << k_slot_shift)) | slot << k_slot_shift};
    }
    constexpr LocatorPlane joined() const { return {word | k_flag}; }
    constexpr LocatorPlane sufficient() const { return {word | k_flag}; }

    static constexpr int k_normal_bits = 9, k_distance_bits = 11, k_distance_shift = 2 * k_normal_bits, k_slot_shift = 29;
    static constexpr std::uint32_t k_max_distance = (1u << k_distance_bits) - 1, k_slot_mask = 3, k_flag = 1u << 31;
};

/// Seeds: 8 bits part, 12 + 12 bits outward unit normal; 16 bits signed distance of the cell's centre below the plane, 8 bits
/// reach, a flag on the last of a cell's chain.
inline constexpr int k_seed_normal_bits = 12, k_seed_normal_shift = 8, k_seed_reach_shift = 16;
inline constexpr std::uint32_t k_seed_part_mask = 0xff, k_seed_distance_mask = 0xffff, k_seed_distance_zero = 0x8000,
                               k_last_seed = 1u << 31;
inline constexpr float k_seed_distance_step = 1.f / 512;  ///< of the locator's cell
inline constexpr float k_seed_reach_step = 1.f / 8;       ///< of the locator's cell

constexpr std::uint32_t seed_part(Seed seed) { return seed.direction & k_seed_part_mask; }
/// In steps.
constexpr int seed_distance(Seed seed)
{
    return static_cast<int>(seed.extent & k_seed_distance_mask) - static_cast<int>(k_seed_distance_zero);
}
inline Vec3f seed_normal(Seed seed) { return octahedral_normal<k_seed_normal_bits>(seed.direction >> k_seed_normal_shift); }
/// A surface found from the seed within this distance, in steps, is the nearest, whatever the rest of the chain finds.
constexpr std::uint32_t seed_reach(Seed seed) { return (seed.extent >> k_seed_reach_shift) & 0xffu; }
constexpr bool is_last_seed(Seed seed) { return (seed.extent & k_last_seed) != 0; }

inline Seed make_seed(std::uint32_t part, Vec3d normal)
{
    return {part | octahedral_code<k_seed_normal_bits>(normal) << k_seed_normal_shift, k_seed_distance_zero};
}
/// length: of the cell's centre below the plane, in the unit of cell.
inline Seed with_distance(Seed seed, double length, double cell)
{
    const double steps = std::round(length / (k_seed_distance_step * cell));
    const auto code = static_cast<std::uint32_t>(static_cast<int>(std::clamp(steps, -32768.0, 32767.0)) +
                                                 static_cast<int>(k_seed_distance_zero));
    return {seed.direction, (seed.extent & ~k_seed_distance_mask) | code};
}
/// reach: in cells.
inline Seed with_reach(Seed seed, double reach)
{
    const double steps = std::floor(reach / k_seed_reach_step);
    return {seed.direction, seed.extent | static_cast<std::uint32_t>(std::clamp(steps, 0.0, 255.0)) << k_seed_reach_shift};
}
constexpr Seed as_last(Seed seed) { return {seed.direction, seed.extent | k_last_seed}; }
constexpr Seed as_not_last(Seed seed) { return {seed.direction, seed.extent & ~k_last_seed}; }

/// Before a chain of several: which of its seeds comes first in each octant of the cell; 1 upper x, 2 upper y, 4 upper z.
constexpr std::uint32_t seed_choice(std::uint32_t choices, std::uint32_t octant) { return (choices >> (3 * octant)) & 7u; }
constexpr std::uint32_t with_seed_choice(std::uint32_t choices, std::uint32_t octant, std::uint32_t seed)
{
    return choices | seed << (3 * octant);
}

/// The rise of a flat cell, for the exact layer: no point of the solid in the cell is farther above the lowest plane; k_no_rise
/// says nothing.
inline constexpr float k_rise_step = 1.f / 1024;  ///< of the locator's cell
/// Rises of so many cells, to whole words.
constexpr std::size_t padded_rises(std::size_t cells) { return (cells + 3) / 4 * 4; }
/// rise: in cells. Rounded up, with margin for the runtime's own rounding.
inline std::uint8_t encode_rise(double rise)
{
    const double steps = std::ceil((rise + 1e-3) / static_cast<double>(k_rise_step));
    return steps < k_no_rise ? static_cast<std::uint8_t>(steps) : k_no_rise;
}

}  // namespace sqmap::model
