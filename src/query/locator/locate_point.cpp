// The look-up of LocatorLanes, compiled with one lane.
#undef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_SCALAR
#include "query/locator/locate_point.h"

#include "sqmap/math/assert.h"

#include <hwy/highway.h>

#include "query/locator/locate-inl.h"

namespace sqmap::query {

using namespace HWY_NAMESPACE;

LocatedCell locate(const ModelView& model, Vec3f point) noexcept
{
    SQMAP_ASSERT(has_locator(model));
    const LocatorLanes lanes(model);
    const V3 at = lanes.in_cells({set(point.x), set(point.y), set(point.z)});
    const M in_grid = lanes.in_grid(at);
    LocatorLanes::Located found = lanes.locate(at, in_grid);
    M occupied = hn::AndNot(found.is_free, in_grid);
    lanes.divide(found.cell, found.index, found.offset, occupied);
    LocatedCell cell;
    if (!any(occupied)) return cell;
    cell.is_free = false;
    cell.brick = static_cast<std::size_t>(hn::GetLane(found.brick));
    cell.within = static_cast<std::uint32_t>(hn::GetLane(found.within));
    cell.index = static_cast<std::size_t>(hn::GetLane(found.index));
    cell.cell = {static_cast<std::uint32_t>(hn::GetLane(found.cell))};
    cell.offset = {hn::GetLane(found.offset.x), hn::GetLane(found.offset.y), hn::GetLane(found.offset.z)};
    return cell;
}

bool is_made_up_at(const ModelView& model, Vec3f point) noexcept
{
    SQMAP_ASSERT(!model.made_up_cells.empty());
    const LocatedCell at = locate(model, point);
    return !at.is_free && (model.made_up_cells[at.index / 32] >> (at.index % 32) & 1u) != 0;
}

}  // namespace sqmap::query
