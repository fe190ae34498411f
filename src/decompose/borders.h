// Borders between named parts: short ones, that keep to the creases that they are in.
#pragma once

#include "sqmap/decompose/decompose.h"

#include <cstdint>
#include <vector>

namespace sqmap::decompose {

struct Mirror;

/// Parts, and the number of each one's named part (#parts), counted from zero in the order of their first part.
struct NamedPartition {
    Partition partition;
    std::vector<std::uint32_t> names;
};

/// Moves each border between two named parts to the shortest one near it: least in length, where edges in creases count less, and
/// in area that it moves over. Every part keeps half of its own extent beside each border, and borders of parts of one name stay.
/// A border between names is no cut for the fit. mirror: of the mesh, or null; borders on one half follow those of the other,
/// whose are shorter. Any units and frame. Cost: O(n) for each border, and O(m log m) for the m triangles of its band.
/// Thread-safe. @throw std::bad_alloc
[[nodiscard]] NamedPartition smoothed(const mesh::Mesh& mesh, const NamedPartition& named, const Mirror* mirror);

}  // namespace sqmap::decompose
