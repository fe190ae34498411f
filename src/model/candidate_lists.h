// The exact layer's lists: for each locator cell the triangles that can be nearest to a point of it. Written and read here.
#pragma once

#include "sqmap/math/assert.h"
#include "sqmap/model/model.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::model {

/// Where a brick has no record in near.
inline constexpr std::uint32_t k_no_candidates = 0xffffffffu;

/// Triangles by which an exact answer is found in a cell of a brick: one of them is the nearest, for any point of it, and no
/// buried one is among them. Empty where there are too many to list: all of the mesh are tried.
struct CandidateList {
    const std::uint16_t* table;  ///< of the brick's triangles: two values each, the low one first, if wide
    const std::uint16_t* refs;   ///< indices into it: two in a value, the low one first, if narrow; null: all of the table
    std::uint32_t first, count;  ///< of refs
    bool wide, narrow;

    [[nodiscard]] constexpr std::uint32_t operator[](std::uint32_t i) const
    {
        const std::uint32_t at = first + i;
        return triangle(refs == nullptr ? at : ref(at));
    }
    /// n of them from i on.
    constexpr void read(std::uint32_t i, std::uint32_t n, std::int32_t* out) const
    {
        if (wide || refs == nullptr) {
            for (std::uint32_t k = 0; k < n; ++k) out[k] = static_cast<std::int32_t>((*this)[i + k]);
        } else if (narrow) {
            for (std::uint32_t k = 0, at = first + i; k < n; ++k, ++at)
                out[k] = table[(refs[at >> 1] >> (8 * (at & 1u))) & 0xffu];
        } else {
            for (std::uint32_t k = 0, at = first + i; k < n; ++k, ++at) out[k] = table[refs[at]];
        }
    }
    [[nodiscard]] constexpr std::uint32_t ref(std::uint32_t at) const
    {
        return narrow ? (refs[at >> 1] >> (8 * (at & 1u))) & 0xffu : refs[at];
    }
    [[nodiscard]] constexpr std::uint32_t triangle(std::uint32_t at) const
    {
        return wide ? table[2 * at] | std::uint32_t{table[2 * at + 1]} << 16 : table[at];
    }
};

/// True where triangles take two values each.
constexpr bool has_wide_candidates(std::size_t triangles) { return triangles > 0x10000; }

/// A brick's record: which of its cells are not Free, one bit each; how many triangles it has; where each such cell's refs start,
/// and where the last ones end; the triangles; the refs, bytes where there are 256 triangles or fewer. A cell without refs has
/// all triangles of the brick.
struct CandidateRecord {
    std::uint64_t occupied;
    std::uint32_t triangles;
    const std::uint16_t* starts;
    const std::uint16_t* table;
    const std::uint16_t* refs;
    bool wide;

    static constexpr std::uint32_t k_head = 5;  ///< values before the starts
    static constexpr std::uint32_t k_max_triangles = 0xffff, k_max_refs = 0xffff;

    constexpr std::uint32_t cells() const { return static_cast<std::uint32_t>(std::popcount(occupied)); }
    constexpr std::uint32_t ref_count() const { return starts[cells()]; }
    constexpr bool is_narrow() const { return is_narrow(triangles); }
    /// Values before the refs, and all of them.
    constexpr std::size_t head_size() const { return k_head + cells() + 1 + std::size_t{triangles} * (wide ? 2 : 1); }
    constexpr std::size_t size() const { return head_size() + ref_size(ref_count(), triangles); }
    constexpr CandidateList all() const { return {table, nullptr, 0, triangles, wide, false}; }
    constexpr CandidateList of_refs(std::uint32_t from, std::uint32_t count) const
    {
        return {table, refs, from, count, wide, is_narrow()};
    }
    /// cell: from 0 to 63 in its brick, 0 of a deep one. @pre the cell is not Free
    constexpr CandidateList of_cell(std::uint32_t cell) const
    {
        SQMAP_ASSERT((occupied >> cell & 1) != 0);
        const std::uint16_t* start = starts + std::popcount(occupied & ((std::uint64_t{1} << cell) - 1));
        return start[0] == start[1] ? all() : of_refs(start[0], static_cast<std::uint32_t>(start[1] - start[0]));
    }

    static constexpr bool is_narrow(std::size_t triangles) { return triangles <= 256; }
    static constexpr std::size_t ref_size(std::size_t refs, std::size_t triangles)
    {
        return is_narrow(triangles) ? (refs + 1) / 2 : refs;
    }
};
constexpr CandidateRecord candidate_record(const std::uint16_t* values, bool wide)
{
    CandidateRecord r{0, values[4], values + CandidateRecord::k_head, nullptr, nullptr, wide};
    for (std::uint32_t k = 0; k < 4; ++k) r.occupied |= std::uint64_t{values[k]} << 16 * k;
    r.table = r.starts + std::popcount(r.occupied) + 1;
    r.refs = r.table + r.triangles * (wide ? 2u : 1u);
    return r;
}
/// @pre the brick is not free
[[nodiscard]] constexpr CandidateRecord candidate_record(const ModelView& view, std::size_t brick)
{
    SQMAP_ASSERT(view.near_bricks[brick] != k_no_candidates);
    return candidate_record(view.near.data() + view.near_bricks[brick], has_wide_candidates(view.triangle_part.size()));
}
/// cell: from 0 to 63 in its brick, 0 of a deep one. @pre the cell is not Free
[[nodiscard]] constexpr CandidateList candidate_list(const ModelView& view, std::size_t brick, std::uint32_t cell)
{
    return candidate_record(view, brick).of_cell(cell);
}

/// A record's contents before it is packed. starts: one more than cells; refs: indices into triangles.
struct UnpackedCandidates {
    std::uint64_t occupied;
    std::span<const std::uint32_t> starts, triangles, refs;
};
constexpr std::size_t packed_size(const UnpackedCandidates& r, bool wide)
{
    return CandidateRecord::k_head + r.starts.size() + r.triangles.size() * (wide ? 2 : 1) +
           CandidateRecord::ref_size(r.refs.size(), r.triangles.size());
}
/// out: packed_size values.
constexpr void pack_candidates(const UnpackedCandidates& r, bool wide, std::uint16_t* out)
{
    const auto put = [&](std::uint64_t value) { *out++ = static_cast<std::uint16_t>(value); };
    for (int k = 0; k < 4; ++k) put(r.occupied >> 16 * k);
    put(r.triangles.size());
    for (const std::uint32_t s : r.starts) put(s);
    for (const std::uint32_t t : r.triangles) {
        put(t);
        if (wide) put(t >> 16);
    }
    const bool narrow = CandidateRecord::is_narrow(r.triangles.size());
    for (std::size_t i = 0; i < r.refs.size(); i += narrow ? 2 : 1)
        put(r.refs[i] | (narrow && i + 1 < r.refs.size() ? r.refs[i + 1] << 8 : 0));
}

}  // namespace sqmap::model
