// Groups of a tool's points: halves at the median of the longest side, until a group has about the square root of all.
#include "sqmap/bulk/clearances.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sqmap::bulk {

namespace {

struct Extent {
    Vec3d lo, hi;
};

Extent extent_of(std::span<const Vec3d> given, std::span<const std::uint32_t> numbers)
{
    Extent out{given[numbers.front()], given[numbers.front()]};
    for (const std::uint32_t i : numbers)
        for (int k = 0; k < 3; ++k) {
            out.lo[k] = std::min(out.lo[k], given[i][k]);
            out.hi[k] = std::max(out.hi[k], given[i][k]);
        }
    return out;
}

}  // namespace

ToolPoints::ToolPoints(std::span<const Vec3d> points) : numbers_(points.size())
{
    if (points.empty()) return;
    std::iota(numbers_.begin(), numbers_.end(), 0u);
    // A pose queries every group's ball, then the points of a few groups: the sum is least where both are as many.
    const auto max_count = static_cast<std::size_t>(std::max(8.0, std::sqrt(static_cast<double>(points.size()))));
    divide(0, points.size(), max_count, points);
    points_.reserve(points.size());
    for (const std::uint32_t i : numbers_) points_.push_back(points[i]);
    const Extent extent = extent_of(points, numbers_);
    all_ = {0.5 * (extent.lo + extent.hi), 0, 0, points.size()};
    for (const Vec3d& p : points) all_.radius = std::max(all_.radius, norm(p - all_.centre));
}

void ToolPoints::divide(std::size_t first, std::size_t count, std::size_t max_count, std::span<const Vec3d> given)
{
    const std::span numbers = std::span(numbers_).subspan(first, count);
    const Extent extent = extent_of(given, numbers);
    if (count <= max_count) {
        Group group{0.5 * (extent.lo + extent.hi), 0, first, count};
        std::sort(numbers.begin(), numbers.end());
        for (const std::uint32_t i : numbers) group.radius = std::max(group.radius, norm(given[i] - group.centre));
        groups_.push_back(group);
        return;
    }
    const Vec3d size = extent.hi - extent.lo;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const std::size_t half = count / 2;
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
        return given[a][axis] != given[b][axis] ? given[a][axis] < given[b][axis] : a < b;
    };
    std::nth_element(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(half), numbers.end(), before);
    divide(first, half, max_count, given);
    divide(first + half, count - half, max_count, given);
}

}  // namespace sqmap::bulk
