// Few contacts for many: those that hold a region as all of them do.
#pragma once

#include "sqmap/query/contacts.h"

namespace sqmap::query {

/// Brings the contacts to keep to the front and returns their number, at most count: the deepest, then one by one those that add
/// the largest area to the outline of the kept ones, seen along the deepest one's normal, up to eight; then those farthest from
/// all that are kept. Of equal ones the first. Cost: contacts times count. No allocation.
std::size_t keep_spanning(std::span<SurfaceContact> contacts, std::size_t count) noexcept;

}  // namespace sqmap::query
