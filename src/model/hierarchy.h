// The hierarchy of boxes over a model's triangles: how its levels and boxes are stored.
#pragma once

#include "sqmap/math/assert.h"
#include "sqmap/math/box.h"
#include "sqmap/math/vec.h"
#include "sqmap/model/arrays.h"

#include <algorithm>
#include <cmath>

namespace sqmap::model {

inline constexpr std::uint32_t k_max_hierarchy_levels = 4;  ///< above the groups: 8 million triangles

/// The first node of each level, root first.
struct HierarchyLevels {
    std::uint32_t count = 0;
    std::uint32_t first[k_max_hierarchy_levels + 1] = {};     ///< node
    std::uint32_t children[k_max_hierarchy_levels + 1] = {};  ///< of all nodes of a level
};

inline constexpr std::uint32_t k_max_hierarchy_entries = k_hierarchy_leaf << 4 * (k_max_hierarchy_levels + 1);

constexpr std::uint32_t leaf_count(std::uint32_t entries) { return (entries + k_hierarchy_leaf - 1) / k_hierarchy_leaf; }

constexpr std::uint32_t group_count(std::uint32_t entries)
{
    return (leaf_count(entries) + k_hierarchy_width - 1) / k_hierarchy_width;
}

/// The levels above the groups: none where there is but one. @pre entries <= k_max_hierarchy_entries
constexpr HierarchyLevels hierarchy_levels(std::uint32_t entries)
{
    SQMAP_ASSERT(entries <= k_max_hierarchy_entries);
    HierarchyLevels levels;
    std::uint32_t children[k_max_hierarchy_levels] = {};
    for (std::uint32_t below = group_count(entries); below > 1 && levels.count < k_max_hierarchy_levels;
         below = (below + k_hierarchy_width - 1) / k_hierarchy_width)
        children[levels.count++] = below;
    for (std::uint32_t k = 0; k < levels.count; ++k) {
        levels.children[k] = children[levels.count - 1 - k];
        levels.first[k + 1] = levels.first[k] + (levels.children[k] + k_hierarchy_width - 1) / k_hierarchy_width;
    }
    return levels;
}

/// The boxes of up to 16 children as stored: none is smaller than it was.
inline HierarchyNode encode_node(const Boxf* boxes, std::uint32_t count)
{
    constexpr float k_max = 255;
    HierarchyNode node{};
    Boxf all;
    for (std::uint32_t i = 0; i < count; ++i) extend(all, boxes[i]);
    for (int k = 0; k < 3; ++k) node.origin[k] = all.lo[k];
    const Vec3f sides = size(all);
    const float extent = std::max({sides.x, sides.y, sides.z, 0.f});
    // Room for what rounding takes.
    node.step = std::max(extent * 1.0001f / k_max, 1e-30f);
    for (std::uint32_t i = 0; i < k_hierarchy_width; ++i)
        for (int k = 0; k < 3; ++k) {
            const Boxf& box = boxes[std::min(i, count - 1)];
            const auto steps = [&](float v) {
                return (static_cast<double>(v) - static_cast<double>(node.origin[k])) / static_cast<double>(node.step);
            };
            node.lo[k][i] = static_cast<std::uint8_t>(std::clamp(std::floor(steps(box.lo[k]) - 1e-4), 0.0, 255.0));
            node.hi[k][i] = static_cast<std::uint8_t>(std::clamp(std::ceil(steps(box.hi[k]) + 1e-4), 0.0, 255.0));
        }
    return node;
}

/// The unit vector of a code: as the vector kernels decode it, to the bit.
inline Vec3f decode_axis(std::uint8_t u, std::uint8_t v)
{
    const float x = static_cast<float>(u) * (2.f / 255.f) - 1.f, y = static_cast<float>(v) * (2.f / 255.f) - 1.f;
    const float z = 1.f - std::abs(x) - std::abs(y), fold = std::max(-z, 0.f);
    const Vec3f n{x - std::copysign(fold, x), y - std::copysign(fold, y), z};
    const float inverse = 1.f / std::sqrt(n.x * n.x + (n.y * n.y + n.z * n.z));
    return {n.x * inverse, n.y * inverse, n.z * inverse};
}

/// Axes of a leaf's box, the normal first: two beside it (T. Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1),
/// 2017), turned.
struct BoxAxes {
    Vec3f axis[3];
};
inline BoxAxes box_axes(Vec3f n, std::uint8_t turn)
{
    const float sign = std::copysign(1.f, n.z), a = -1.f / (sign + n.z), b = n.x * n.y * a;
    const Vec3f first{1.f + sign * n.x * n.x * a, sign * b, -sign * n.x}, second{b, sign + n.y * n.y * a, -n.y};
    const float t = static_cast<float>(turn) / 255.f, over = 1.f / (1.f + t * t), cosine = (1.f - t * t) * over,
                sine = 2.f * t * over;
    return {{n, cosine * first + sine * second, cosine * second - sine * first}};
}

/// One of the nearest codes to a vector, which need not be of unit length.
inline void encode_axis(Vec3d n, std::uint8_t& u, std::uint8_t& v)
{
    const double sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    if (!(sum > 0)) n = {0, 0, 1};
    const double scale = sum > 0 ? 1 / sum : 1;
    double x = n.x * scale, y = n.y * scale;
    if (n.z < 0) {
        const double fold_x = std::copysign(1 - std::abs(y), x), fold_y = std::copysign(1 - std::abs(x), y);
        x = fold_x;
        y = fold_y;
    }
    u = static_cast<std::uint8_t>(std::clamp(std::lround((x + 1) * 127.5), 0l, 255l));
    v = static_cast<std::uint8_t>(std::clamp(std::lround((y + 1) * 127.5), 0l, 255l));
}

}  // namespace sqmap::model
