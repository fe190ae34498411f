#include "chart.h"

#include "model/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace sqmap::bake {

ChartDomain chart_domain(const shape::Superquadricd& sq, Vec3f centre, std::span<const Vec3d> points)
{
    // The centre is in it: the way from there to any point of the domain then stays in the domain.
    double lo[9] = {}, hi[9] = {};
    for (const Vec3d& p : points) {
        const Vec3d q = sq.rotation * (p - cast<double>(centre));
        const Vec3d x{q.x / sq.a.x, q.y / sq.a.y, q.z / sq.a.z};
        for (std::size_t k = 0; k < 9; ++k) {
            lo[k] = std::min(lo[k], model::domain_coordinate(x, k));
            hi[k] = std::max(hi[k], model::domain_coordinate(x, k));
        }
    }
    constexpr double k_hair = 2e-5;
    ChartDomain domain;
    for (std::size_t k = 0; k < 9; ++k) {
        domain.lo[k] = static_cast<float>(lo[k] - k_hair);
        domain.hi[k] = static_cast<float>(hi[k] + k_hair);
    }
    return domain;
}

Vec3f choose_centre(const mesh::Solid& solid, const shape::Superquadricd& sq, std::span<const std::uint32_t> own)
{
    const mesh::Mesh& mesh = solid.mesh();
    // Clearance in the chart's metric, from the part's own triangles (their corners and centroids).
    std::vector<Vec3d> surface;
    for (const std::uint32_t t : own) {
        for (const std::uint32_t v : mesh.triangles[t]) surface.push_back(mesh.vertices[v]);
        surface.push_back(mesh::triangle_centroid(mesh, t));
    }
    const auto chart = [&](Vec3d p) {
        const Vec3d q = sq.rotation * (p - sq.translation);
        return Vec3d{q.x / sq.a.x, q.y / sq.a.y, q.z / sq.a.z};
    };
    std::vector<Vec3d> x;
    const std::size_t stride = std::max<std::size_t>(1, surface.size() / 1500);
    for (std::size_t i = 0; i < surface.size(); i += stride) x.push_back(chart(surface[i]));

    const auto score = [&](Vec3d p) {
        const Vec3d c = chart(p);
        double clearance_sq = std::numeric_limits<double>::infinity();
        for (const Vec3d& v : x) clearance_sq = std::min(clearance_sq, norm_sq(v - c));
        return std::sqrt(clearance_sq) - 0.35 * norm(c);
    };
    std::vector<std::pair<double, Vec3d>> candidates;
    constexpr int k_side = 4;
    for (int i = -k_side; i <= k_side; ++i)
        for (int j = -k_side; j <= k_side; ++j)
            for (int k = -k_side; k <= k_side; ++k) {
                const Vec3d l{sq.a.x * i / (k_side + 1.0), sq.a.y * j / (k_side + 1.0), sq.a.z * k / (k_side + 1.0)};
                const Vec3d p = shape::to_model(sq, l);
                candidates.emplace_back(score(p), p);
            }
    // Points half way through the part's thickness, for parts that the superquadric's middle misses.
    const std::size_t own_stride = std::max<std::size_t>(1, own.size() / 40);
    for (std::size_t i = 0; i < own.size(); i += own_stride) {
        const mesh::Triangle& tri = mesh.triangles[own[i]];
        const Vec3d a = mesh.vertices[tri[0]];
        const Vec3d n = normalized(cross(mesh.vertices[tri[1]] - a, mesh.vertices[tri[2]] - a));
        const Vec3d c = mesh::triangle_centroid(mesh, own[i]);
        for (double depth = 0.5 * std::min({sq.a.x, sq.a.y, sq.a.z}); depth > 1e-4; depth *= 0.5) {
            const Vec3d p = c - depth * n;
            if (solid.bvh().closest_point(p, 0.71 * depth).distance > 0.7 * depth) {
                candidates.emplace_back(score(p), p);
                break;
            }
        }
    }
    std::stable_sort(candidates.begin(), candidates.end(), [](const auto& l, const auto& r) { return l.first > r.first; });
    // The floor: no surface nearer than a fraction of the least axis, or distances along rays would lose their digits.
    const double floor = 0.02 * std::min({sq.a.x, sq.a.y, sq.a.z});
    Vec3d best = candidates.front().second;
    double best_clearance = -1;
    for (const auto& [value, p] : candidates) {
        const Vec3d rounded = cast<double>(cast<float>(p));
        const bool inside = solid.bvh().winding_number(rounded) > 0;
        const double clearance = solid.bvh().closest_point(rounded, 2 * floor).distance;
        if (inside && clearance > floor) return cast<float>(rounded);
        const double rank = inside ? clearance : -1.0;
        if (rank > best_clearance) {
            best_clearance = rank;
            best = rounded;
        }
    }
    return cast<float>(best);
}

}  // namespace sqmap::bake
