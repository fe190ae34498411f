// Named parts of a model: what a person would name one thing may have several superquadrics.
// Pure functions: any number of threads.
#pragma once

#include "sqmap/math/assert.h"
#include "sqmap/model/model.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace sqmap::model {

/// Part::flags holds the number of the part's group plus one from this bit on; zero: the part is a group of its own.
inline constexpr unsigned k_group_shift = 8;

/// Number of the group, or named part, that a part belongs to; groups are counted in the order of their first part. A model that
/// was baked before there were groups has one a part. @pre part < view.parts.size()
[[nodiscard]] constexpr std::uint32_t group_of_part(const ModelView& view, std::size_t part)
{
    SQMAP_ASSERT(part < view.parts.size());
    const std::uint32_t stored = view.parts[part].flags >> k_group_shift;
    return stored == 0 ? static_cast<std::uint32_t>(part) : stored - 1;
}

/// How many groups the parts of a model make. Linear.
[[nodiscard]] constexpr std::uint32_t group_count(const ModelView& view)
{
    std::uint32_t count = 0;
    for (std::size_t part = 0; part < view.parts.size(); ++part) count = std::max(count, group_of_part(view, part) + 1);
    return count;
}

/// Stores a part's group. @pre group < 2^24 - 1
constexpr void set_group(Part& part, std::uint32_t group)
{
    SQMAP_ASSERT(group + 1 < 1u << (32 - k_group_shift));
    part.flags = (part.flags & ((1u << k_group_shift) - 1)) | (group + 1) << k_group_shift;
}

/// Gives a part the group of another model's part.
constexpr void copy_group(const Part& from, Part& to)
{
    constexpr std::uint32_t k_own = (1u << k_group_shift) - 1;
    to.flags = (to.flags & k_own) | (from.flags & ~k_own);
}

}  // namespace sqmap::model
