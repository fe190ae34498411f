// J. O'Rourke, "Finding minimal enclosing boxes", 1985, shows that two adjacent faces of the least box hold edges of the hull.
// Here boxes with a face in a facet of the hull are tried at all turns about its normal, beside boxes of evenly spread attitudes;
// the best are turned freely, by a pattern search, until no turn makes them smaller (C.-T. Chang, B. Gorissen, S. Melchior, "Fast
// oriented bounding box optimization on the rotation group", 2011, search the same way).
#include "collider/searches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::collider {
namespace {

constexpr int k_turns = 45;  ///< of a quarter about a facet's normal
constexpr std::size_t k_facets = 60, k_starts = 12;
constexpr int k_spread = 24;  ///< attitudes that do not depend on the hull, times k_turns

Candidate box_about(std::span<const Vec3d> points, const Mat3d& axes)
{
    Vec3d lo{}, hi{};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d q = transpose_mul(axes, points[i]);
        for (int k = 0; k < 3; ++k) {
            lo[k] = i == 0 ? q[k] : std::min(lo[k], q[k]);
            hi[k] = i == 0 ? q[k] : std::max(hi[k], q[k]);
        }
    }
    const Vec3d size = 0.5 * (hi - lo);
    return {axes, axes * (0.5 * (lo + hi)), size, 8 * size.x * size.y * size.z};
}

}  // namespace

Candidate least_box(const mesh::Mesh& hull)
{
    const std::span<const Vec3d> points = hull.vertices;
    std::vector<Vec3d> normals = facet_normals(hull, k_facets);
    for (const Vec3d& d : half_sphere(k_spread)) normals.push_back(d);
    normals.push_back({1, 0, 0});
    std::vector<Candidate> starts;
    for (const Vec3d& n : normals) {
        const Mat3d axes = axes_along(n);
        Candidate best{.volume = std::numeric_limits<double>::infinity()};
        for (int i = 0; i < k_turns; ++i) {
            const Candidate c = box_about(points, turned(axes, std::numbers::pi / 2 * i / k_turns * n));
            if (c.volume < best.volume) best = c;
        }
        starts.push_back(best);
    }
    std::stable_sort(starts.begin(), starts.end(), [](const Candidate& l, const Candidate& r) { return l.volume < r.volume; });
    starts.resize(std::min(starts.size(), k_starts));
    Candidate best = starts.front();
    for (const Candidate& start : starts) {
        const auto found = pattern_search<3>({}, {0.05, 0.05, 0.05}, 1e-6, [&](const std::array<double, 3>& x) {
            return box_about(points, turned(start.axes, {x[0], x[1], x[2]})).volume;
        });
        const Candidate c = box_about(points, turned(start.axes, {found[0], found[1], found[2]}));
        if (c.volume < best.volume) best = c;
    }
    return best;
}

}  // namespace sqmap::collider
