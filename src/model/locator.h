// The cell of the locator that holds a point, and how far the point lies below the cell's planes: one point at a time.
#pragma once

#include "model/locator_cells.h"
#include "sqmap/math/assert.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::model {

/// The cell under a point.
struct LocatedCell {
    bool is_free = true;       ///< outside the grid, or in a free brick or cell
    std::size_t brick = 0;     ///< its index
    std::uint32_t within = 0;  ///< of the undivided cell in its brick, 0 of a deep one
    std::size_t index = 0;     ///< of the word, where one is stored
    LocatorCell cell{};
    Vec3f offset{};  ///< of the point from the cell's centre, in cells
};

/// Cost: two look-ups, or three. @pre the model has a locator
inline LocatedCell locate(const ModelView& model, Vec3f p)
{
    SQMAP_ASSERT(has_locator(model));
    const Locator& l = model.locator;
    const float inverse_cell = 1.f / l.cell;
    constexpr auto k_n = static_cast<std::uint32_t>(k_brick);
    LocatedCell found;
    std::uint32_t at[3];
    Vec3f in_cells;
    for (int k = 0; k < 3; ++k) {
        in_cells[k] = (p[k] - l.origin[k]) * inverse_cell;
        if (!(in_cells[k] >= 0.f && in_cells[k] < static_cast<float>(k_n * l.bricks[k]))) return found;
        at[k] = static_cast<std::uint32_t>(in_cells[k]);
    }
    found.brick = (std::size_t{at[2] / k_n} * l.bricks[1] + at[1] / k_n) * l.bricks[0] + at[0] / k_n;
    const LocatorBrick brick{model.bricks[found.brick]};
    if (brick.is_free()) return found;
    const bool deep = brick.is_deep();
    for (int k = 0; k < 3; ++k) {
        const auto corner = static_cast<float>(deep ? at[k] / k_n * k_n : at[k]);
        found.offset[k] = in_cells[k] - (corner + (deep ? 0.5f * k_brick : 0.5f));
    }
    found.within = deep ? 0 : (at[2] % k_n * k_n + at[1] % k_n) * k_n + at[0] % k_n;
    found.index = brick.first() + found.within;
    found.cell = {model.locator_cells[found.index]};
    float quarter = 0.25f;
    for (int d = 0; d < k_max_divisions && !deep && found.cell.is_divided(); ++d, quarter *= 0.5f) {
        std::uint32_t eighth = 0;
        for (int k = 0; k < 3; ++k) {
            const bool up = found.offset[k] >= 0.f;
            eighth |= up ? 1u << k : 0u;
            found.offset[k] -= up ? quarter : -quarter;
        }
        found.index = found.cell.first() + eighth;
        found.cell = {model.locator_cells[found.index]};
    }
    found.is_free = !deep && found.cell.is_free();
    return found;
}

/// True where the surface nearest to a point in its cell may be made up. Cost: as locate. @pre view.made_up_cells is not empty
inline bool is_made_up_at(const ModelView& view, Vec3f p)
{
    SQMAP_ASSERT(!view.made_up_cells.empty());
    const LocatedCell at = locate(view, p);
    return !at.is_free && (view.made_up_cells[at.index / 32] >> (at.index % 32) & 1u) != 0;
}

/// How far a point is below a seed's plane, model units. offset: from the centre of the seed's cell, model units.
inline float seed_gap(const Locator& locator, Seed seed, Vec3f offset)
{
    return static_cast<float>(seed_distance(seed)) * (k_seed_distance_step * locator.cell) - dot(seed_normal(seed), offset);
}

/// How far a point is below a plane, model units. offset: from the centre of its cell, model units.
inline float plane_gap(const Locator& locator, LocatorPlane plane, Vec3f offset)
{
    return plane.distance(locator.plane_reach) * locator.cell - dot(plane.normal(), offset);
}

/// How far a point is below the planes of a flat cell: the lowest of the groups' highest (see LocatorPlane), which plane that is,
/// and where its group ends.
struct FlatGap {
    float gap = INFINITY;
    std::size_t plane = 0, group_end = 0;
};
/// gap(k): below plane k; is_joined(k): it goes on with the group of the plane before it.
template <class Gap, class IsJoined>
FlatGap flat_gap(std::size_t planes, Gap&& gap, IsJoined&& is_joined)
{
    FlatGap lowest;
    for (std::size_t k = 0; k < planes;) {
        FlatGap highest{-INFINITY};
        do {
            const float below = gap(k);
            if (below > highest.gap) highest = {below, k};
        } while (++k < planes && is_joined(k));
        if (highest.gap < lowest.gap) lowest = {highest.gap, highest.plane, k};
    }
    return lowest;
}

}  // namespace sqmap::model
