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

/// Stands for a brick that has no record in near.
inline constexpr std::uint32_t k_no_candidates = 0xffffffffu;

/// Values of 16 bits that hold so many bits.
constexpr std::size_t mask_words(std::size_t bits) { return (bits + 15) / 16; }

constexpr std::uint32_t set_bits(std::span<const std::uint16_t> words)
{
    int count = 0;
    for (; words.size() >= 4; words = words.subspan(4))
        count += std::popcount(words[0] | std::uint64_t{words[1]} << 16 | std::uint64_t{words[2]} << 32 |
                               std::uint64_t{words[3]} << 48);
    for (const std::uint16_t word : words) count += std::popcount(word);
    return static_cast<std::uint32_t>(count);
}

/// Triangles by which an exact answer is found in a cell of a brick: one of them is the nearest, for any point of it, and no
/// buried one is among them. Empty where there are too many to list: all of the mesh are tried.
struct CandidateList {
    const std::uint16_t* table;  ///< of the brick's triangles: two values each, the low one first, if wide
    const std::uint16_t* mask;   ///< which of them, see CandidateRecord; null: all
    std::uint32_t table_size;    ///< triangles
    std::uint32_t count;         ///< of the list
    bool wide;

    /// visit(index of the word's first triangle, word) while it returns true: a bit for each of sixteen triangles. Words without
    /// one are left out.
    template <class Visit>
    constexpr void each_word(Visit&& visit) const
    {
        const auto words = static_cast<std::uint32_t>(mask_words(table_size));
        if (mask == nullptr) {
            for (std::uint32_t w = 0; w < words; ++w)
                if (!visit(16 * w, w + 1 == words ? 0xffffu >> (16 * words - table_size) : 0xffffu)) return;
            return;
        }
        const std::uint16_t* word = mask + mask_words(words);
        for (std::uint32_t s = 0; s < mask_words(words); ++s)
            for (std::uint32_t filled = mask[s]; filled != 0; filled &= filled - 1)
                if (!visit(16 * (16 * s + static_cast<std::uint32_t>(std::countr_zero(filled))), *word++)) return;
    }
    /// visit(triangle) for each, in the table's order.
    template <class Visit>
    constexpr void each(Visit&& visit) const
    {
        const auto each_of = [&](auto&& triangle_at) {
            each_word([&](std::uint32_t base, std::uint32_t word) {
                for (; word != 0; word &= word - 1) visit(triangle_at(base + static_cast<std::uint32_t>(std::countr_zero(word))));
                return true;
            });
        };
        if (wide)
            each_of([this](std::uint32_t at) { return triangle(at); });
        else
            each_of([this](std::uint32_t at) { return std::uint32_t{table[at]}; });
    }
    /// n of them from i on. @pre i + n <= count
    constexpr void read(std::uint32_t i, std::uint32_t n, std::int32_t* out) const
    {
        SQMAP_ASSERT(i + n <= count);
        if (n == count) {
            each([&](std::uint32_t t) { *out++ = static_cast<std::int32_t>(t); });
            return;
        }
        each_word([&](std::uint32_t base, std::uint32_t word) {
            for (; i > 0 && word != 0; --i) word &= word - 1;
            for (; word != 0 && n > 0; word &= word - 1, --n)
                *out++ = static_cast<std::int32_t>(triangle(base + static_cast<std::uint32_t>(std::countr_zero(word))));
            return n > 0;
        });
    }
    [[nodiscard]] constexpr std::uint32_t operator[](std::uint32_t i) const
    {
        std::int32_t one = 0;
        read(i, 1, &one);
        return static_cast<std::uint32_t>(one);
    }
    [[nodiscard]] constexpr std::uint32_t triangle(std::uint32_t at) const
    {
        return wide ? table[2 * at] | std::uint32_t{table[2 * at + 1]} << 16 : table[at];
    }
};

/// True where triangles take two values each.
constexpr bool has_wide_candidates(std::size_t triangles) { return triangles > 0x10000; }

/// A brick's record: which of its cells are not Free, one bit each; how many triangles it has; where each such cell's list
/// starts, and where the last one ends; the triangles; the lists. A list is a mask of the triangles in two steps: one bit for
/// each 16 of them, and for each of these bits that is set a value of 16 bits. A cell whose list has no values has all triangles.
struct CandidateRecord {
    std::uint64_t occupied;
    std::uint32_t triangles;
    const std::uint16_t* starts;
    const std::uint16_t* table;
    const std::uint16_t* lists;
    bool wide;

    static constexpr std::uint32_t k_head = 5;  ///< values before the starts
    static constexpr std::uint32_t k_max_triangles = 0xffff, k_max_list_values = 0xffff;

    constexpr std::uint32_t cells() const { return static_cast<std::uint32_t>(std::popcount(occupied)); }
    constexpr std::uint32_t list_values() const { return starts[cells()]; }
    /// Values before the lists, and all of them.
    constexpr std::size_t head_size() const { return k_head + cells() + 1 + std::size_t{triangles} * (wide ? 2 : 1); }
    constexpr std::size_t size() const { return head_size() + list_values(); }
    constexpr CandidateList all() const { return {table, nullptr, triangles, triangles, wide}; }
    /// The list of an occupied cell, counted from the first one.
    constexpr CandidateList of_occupied(std::uint32_t index) const
    {
        const std::uint16_t* start = starts + index;
        if (start[0] == start[1]) return all();
        const std::size_t filled = mask_words(mask_words(triangles));
        return {table, lists + start[0], triangles, set_bits({lists + start[0] + filled, lists + start[1]}), wide};
    }
    /// cell: from 0 to 63 in its brick, 0 of a deep one. @pre the cell is not Free
    constexpr CandidateList of_cell(std::uint32_t cell) const
    {
        SQMAP_ASSERT((occupied >> cell & 1) != 0);
        return of_occupied(static_cast<std::uint32_t>(std::popcount(occupied & ((std::uint64_t{1} << cell) - 1))));
    }
};
constexpr CandidateRecord candidate_record(const std::uint16_t* values, bool wide)
{
    CandidateRecord r{0, values[4], values + CandidateRecord::k_head, nullptr, nullptr, wide};
    for (std::uint32_t k = 0; k < 4; ++k) r.occupied |= std::uint64_t{values[k]} << 16 * k;
    r.table = r.starts + std::popcount(r.occupied) + 1;
    r.lists = r.table + r.triangles * (wide ? 2u : 1u);
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

/// Values of a list. refs: indices into the brick's triangles, ascending.
constexpr std::size_t list_size(std::span<const std::uint32_t> refs, std::size_t triangles)
{
    if (refs.empty()) return 0;
    std::size_t words = 1;
    for (std::size_t i = 1; i < refs.size(); ++i) words += refs[i] / 16 != refs[i - 1] / 16 ? 1 : 0;
    return mask_words(mask_words(triangles)) + words;
}

/// A record's contents before it is packed. starts: one more than cells, into refs; refs: of each cell a list's, or none.
struct UnpackedCandidates {
    std::uint64_t occupied;
    std::span<const std::uint32_t> starts, triangles, refs;

    constexpr std::span<const std::uint32_t> list(std::size_t cell) const
    {
        return refs.subspan(starts[cell], starts[cell + 1] - starts[cell]);
    }
    constexpr std::size_t list_values() const
    {
        std::size_t values = 0;
        for (std::size_t c = 0; c + 1 < starts.size(); ++c) values += list_size(list(c), triangles.size());
        return values;
    }
};
constexpr std::size_t packed_size(const UnpackedCandidates& r, bool wide)
{
    return CandidateRecord::k_head + r.starts.size() + r.triangles.size() * (wide ? 2 : 1) + r.list_values();
}
/// out: packed_size values. @pre at most CandidateRecord::k_max_list_values of lists
constexpr void pack_candidates(const UnpackedCandidates& r, bool wide, std::uint16_t* out)
{
    const auto put = [&](std::uint64_t value) { *out++ = static_cast<std::uint16_t>(value); };
    for (int k = 0; k < 4; ++k) put(r.occupied >> 16 * k);
    put(r.triangles.size());
    std::size_t start = 0;
    put(start);
    for (std::size_t c = 0; c + 1 < r.starts.size(); ++c) put(start += list_size(r.list(c), r.triangles.size()));
    for (const std::uint32_t t : r.triangles) {
        put(t);
        if (wide) put(t >> 16);
    }
    const std::size_t filled = mask_words(mask_words(r.triangles.size()));
    for (std::size_t c = 0; c + 1 < r.starts.size(); ++c) {
        const std::span<const std::uint32_t> list = r.list(c);
        if (list.empty()) continue;
        std::uint16_t* mask = out;
        std::fill(out, out + list_size(list, r.triangles.size()), std::uint16_t{0});
        out += filled;
        for (std::size_t i = 0; i < list.size(); ++i) {
            const std::uint32_t word = list[i] / 16;
            if (i > 0 && word != list[i - 1] / 16) ++out;
            mask[word / 16] = static_cast<std::uint16_t>(mask[word / 16] | 1u << word % 16);
            *out = static_cast<std::uint16_t>(*out | 1u << list[i] % 16);
        }
        ++out;
    }
}

}  // namespace sqmap::model
