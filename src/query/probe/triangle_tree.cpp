#include "query/probe/triangle_tree.h"

#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::query {

namespace {

void put(TriangleTree::BoxRow& row, std::size_t i, const Boxf& box)
{
    for (int k = 0; k < 3; ++k) {
        row.lo[k][i] = box.lo[k];
        row.hi[k][i] = box.hi[k];
    }
}

/// The slab along the mean of the triangles' normals, rounded outwards.
void put(TriangleTree::SlabRow& row, std::size_t i, const TriangleTree::CornerRow& corners)
{
    const auto corner = [&](std::size_t k, std::size_t t) {
        return Vec3d{corners.at[k][0][t], corners.at[k][1][t], corners.at[k][2][t]};
    };
    Vec3d sum{};
    for (std::size_t t = 0; t < TriangleTree::k_leaf; ++t) sum += cross(corner(1, t) - corner(0, t), corner(2, t) - corner(0, t));
    const Vec3f normal = cast<float>(normalized(sum));
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (std::size_t t = 0; t < TriangleTree::k_leaf; ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const double height = dot(cast<double>(normal), corner(k, t));
            lo = std::min(lo, height);
            hi = std::max(hi, height);
        }
    for (int k = 0; k < 3; ++k) row.normal[k][i] = normal[k];
    row.lo[i] = static_cast<float>(lo - 1e-7 * std::abs(lo));
    row.hi[i] = static_cast<float>(hi + 1e-7 * std::abs(hi));
}

Boxf box_at(const TriangleTree::BoxRow& row, std::size_t i)
{
    return {{row.lo[0][i], row.lo[1][i], row.lo[2][i]}, {row.hi[0][i], row.hi[1][i], row.hi[2][i]}};
}

}  // namespace

std::size_t TriangleTree::bytes() const noexcept
{
    const auto size_of = [](const auto&... values) { return (std::span(values).size_bytes() + ...); };
    return size_of(points_, triangles_, twin_, from_, sharp_, numbers_, corners_, leaves_, groups_, slabs_);
}

void TriangleTree::move(std::span<const Vec3d> points) noexcept
{
    SQMAP_ASSERT(points.size() == points_.size());
    if (points.size() != points_.size()) return;
    std::copy(points.begin(), points.end(), points_.begin());
    refit();
}

void TriangleTree::refit() noexcept
{
    box_ = box_of(points_);
    const Vec3d middle = centre(box_);
    const std::size_t leaves = corners_.size(), groups = (leaves + k_group - 1) / k_group;
    for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
        Boxf box;
        for (std::size_t i = 0; i < k_leaf; ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3f p = cast<float>(points_[triangles_[numbers_[leaf * k_leaf + i]][k]] - middle);
                extend(box, p);
                for (int axis = 0; axis < 3; ++axis) corners_[leaf].at[k][axis][i] = p[axis];
            }
        put(leaves_[leaf / k_group], leaf % k_group, box);
        put(slabs_[leaf / k_group], leaf % k_group, corners_[leaf]);
    }
    for (std::size_t i = leaves; i < leaves_.size() * k_group; ++i)
        put(leaves_[i / k_group], i % k_group, box_at(leaves_[(leaves - 1) / k_group], (leaves - 1) % k_group));
    for (std::size_t g = 0; g < groups_.size() * k_group; ++g) {
        Boxf box;
        for (std::size_t i = 0; i < k_group; ++i) extend(box, box_at(leaves_[std::min(g, groups - 1)], i));
        put(groups_[g / k_group], g % k_group, box);
    }
}

}  // namespace sqmap::query
