#include "admit_steps.h"

#include "sqmap/mesh/bvh.h"

#include <algorithm>

namespace sqmap::mesh {

namespace {

constexpr double k_stands_out = 1e-3;  ///< share of the diagonal below which no warning is given

}  // namespace

std::optional<Warning> dropped_warning(const Mesh& dropped, const Mesh& solid, double diagonal)
{
    const Bvh bvh(solid);
    double area = 0, farthest = 0;
    std::uint64_t count = 0;
    for (const Triangle& t : dropped.triangles) {
        const Vec3d a = dropped.vertices[t[0]], b = dropped.vertices[t[1]], c = dropped.vertices[t[2]];
        double out = 0;
        for (const Vec3d& p : {a, b, c, (a + b + c) / 3.0})
            if (bvh.winding_number(p) <= 0) out = std::max(out, bvh.closest_point(p).distance);
        if (!(out > k_stands_out * diagonal)) continue;
        area += 0.5 * norm(cross(b - a, c - a));
        farthest = std::max(farthest, out);
        ++count;
    }
    if (count == 0) return std::nullopt;
    return Warning{.kind = WarningKind::DroppedSurface, .count = count, .first = area, .second = farthest};
}

std::optional<Warning> tolerance_warning(const Mesh& wrapped, const Deviation& moved, const WrapOptions& options)
{
    const double r_max = largest_vertex_distance(wrapped), share = moved.result_to_input.p99 / r_max;
    if (share <= options.tolerance && wrapped.triangles.size() <= options.max_triangles) return std::nullopt;
    return Warning{.kind = WarningKind::Tolerance,
                   .count = 1,
                   .first = share,
                   .second = options.tolerance,
                   .triangles = wrapped.triangles.size(),
                   .wanted = options.max_triangles};
}

}  // namespace sqmap::mesh
