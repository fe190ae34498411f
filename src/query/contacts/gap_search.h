// Pairs of triangles of two meshes that may be the nearest, the likeliest first.
#pragma once

#include "candidates.h"

#include <cstdint>
#include <span>

namespace sqmap::query {

/// How far apart the nearest pair is at most, as far as it is known; all in float, and rounded so that nothing nearer is left
/// out.
struct GapBound {
    float limit = 0;          ///< of distances: what is at least as far need not be taken; below zero: nothing need be
    float along_limit = 0;    ///< the same of gaps along the direction, without what lies between the centres
    float along_between = 0;  ///< how far the centres are apart along the direction, at most
    float direction_a[3] = {}, direction_b[3] = {};  ///< unit, from a to b, in either frame
    float nearest_a[3] = {}, nearest_b[3] = {};      ///< of the nearest pair so far, from the centres, in either frame
};

/// Two things, one of each tree, at least `gap` apart: leaves where a has the flag, else groups; or triangles.
struct GapEntry {
    static constexpr std::uint32_t k_leaves = 1u << 31;
    float gap;
    std::uint32_t a, b;
};
// A heap whose top has the least gap: made, after its last entry was added, before its top is taken from its end. Compiled once,
// not for each instruction set.
void heap_gaps(std::span<GapEntry> entries) noexcept;
void pop_gap(std::span<GapEntry> entries) noexcept;

/// Takes a pair and gives the bound that holds from then on; context: the caller's.
using TakeNearest = GapBound (*)(void* context, const TrianglePair& pair) noexcept;

/// Hands over pairs until all that are left are beyond the bound: at least one of those that are nearest, and few others. The
/// order depends on the trees, the pose and the bounds alone, not on the instruction set.
void search_gap(const PosedTrees& trees, const GapBound& bound, TakeNearest take, void* context) noexcept;

}  // namespace sqmap::query
