// The exact layer's lists: for each locator cell the triangles that can be nearest to a point of it. Written and read here.
#pragma once

#include "sqmap/math/assert.h"
#include "sqmap/model/model.h"

#include <algorithm>
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
    const std::uint16_t* refs;   ///< indices into it, of so many bits each, lowest first; null: all of the table
    std::uint32_t first, count;  ///< of refs
    std::uint32_t bits;          ///< of a ref
    bool wide;

    [[nodiscard]] constexpr std::uint32_t operator[](std::uint32_t i) const
    {
        const std::uint32_t at = first + i;
        return triangle(refs == nullptr ? at : ref(at));
    }
    /// n of them from i on.
    constexpr void read(std::uint32_t i, std::uint32_t n, std::int32_t* out) const
    {
        if (wide || refs == nullptr)
            for (std::uint32_t k = 0; k < n; ++k) out[k] = static_cast<std::int32_t>((*this)[i + k]);
        else
            for (std::uint32_t k = 0; k < n; ++k) out[k] = table[ref(first + i + k)];
    }
    [[nodiscard]] constexpr std::uint32_t ref(std::uint32_t at) const
    {
        const std::uint32_t bit = at * bits;
        const std::uint16_t* value = refs + (bit >> 4);
        return ((value[0] | std::uint32_t{value[1]} << 16) >> (bit & 15u)) & ((1u << bits) - 1);
    }
    [[nodiscard]] constexpr std::uint32_t triangle(std::uint32_t at) const
    {
        return wide ? table[2 * at] | std::uint32_t{table[2 * at + 1]} << 16 : table[at];
    }
};

/// True where triangles take two values each.
constexpr bool has_wide_candidates(std::size_t triangles) { return triangles > 0x10000; }

/// A brick's record: which of its cells are not Free, one bit each; how many triangles it has; where each such cell's refs start,
/// and where the last ones end; the triangles; the refs, of as many bits as the triangles need. A cell without refs has all
/// triangles of the brick.
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
    /// Values before the refs, and all of them.
    constexpr std::size_t head_size() const { return k_head + cells() + 1 + std::size_t{triangles} * (wide ? 2 : 1); }
    constexpr std::size_t size() const { return head_size() + ref_size(ref_count(), triangles); }
    constexpr CandidateList all() const { return {table, nullptr, 0, triangles, 0, wide}; }
    constexpr CandidateList of_refs(std::uint32_t from, std::uint32_t count) const
    {
        return {table, refs, from, count, ref_bits(triangles), wide};
    }
    /// cell: from 0 to 63 in its brick, 0 of a deep one. @pre the cell is not Free
    constexpr CandidateList of_cell(std::uint32_t cell) const
    {
        SQMAP_ASSERT((occupied >> cell & 1) != 0);
        const std::uint16_t* start = starts + std::popcount(occupied & ((std::uint64_t{1} << cell) - 1));
        return start[0] == start[1] ? all() : of_refs(start[0], static_cast<std::uint32_t>(start[1] - start[0]));
    }

    static constexpr std::uint32_t ref_bits(std::size_t triangles)
    {
        return triangles > 2 ? static_cast<std::uint32_t>(std::bit_width(triangles - 1)) : 1u;
    }
    /// Any ref is read from two values.
    static constexpr std::size_t ref_size(std::size_t refs, std::size_t triangles)
    {
        return refs > 0 ? (refs - 1) * ref_bits(triangles) / 16 + 2 : 0;
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
    const std::uint32_t bits = CandidateRecord::ref_bits(r.triangles.size());
    std::fill(out, out + CandidateRecord::ref_size(r.refs.size(), r.triangles.size()), std::uint16_t{0});
    for (std::size_t i = 0; i < r.refs.size(); ++i) {
        std::uint16_t* value = out + (i * bits >> 4);
        const std::uint32_t shifted = r.refs[i] << (i * bits & 15u);
        value[0] = static_cast<std::uint16_t>(value[0] | shifted);
        value[1] = static_cast<std::uint16_t>(value[1] | shifted >> 16);
    }
}

}  // namespace sqmap::model
