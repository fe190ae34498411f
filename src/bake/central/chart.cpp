#include "chart.h"

#include "model/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
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

namespace {

/// How good a centre a point is: its clearance in the chart's metric, from corners and centroids of the part's own triangles,
/// less some of its distance from the superquadric's middle.
class CentreScore {
public:
    CentreScore(const mesh::Mesh& mesh, const shape::Superquadricd& sq, std::span<const std::uint32_t> own) : sq_(sq)
    {
        std::vector<Vec3d> surface;
        for (const std::uint32_t t : own) {
            for (const std::uint32_t v : mesh.triangles[t]) surface.push_back(mesh.vertices[v]);
            surface.push_back(mesh::triangle_centroid(mesh, t));
        }
        // Neighbours lie far apart in the order, so that the first few tell that a point is near the surface.
        constexpr std::size_t k_apart = 16;
        const std::size_t stride = std::max<std::size_t>(1, surface.size() / 1500);
        for (std::size_t first = 0; first < k_apart; ++first)
            for (std::size_t i = first * stride; i < surface.size(); i += k_apart * stride) surface_.push_back(chart(surface[i]));
    }

    /// The score, or minus infinity where it is below least.
    [[nodiscard]] double operator()(Vec3d p, double least) const
    {
        constexpr std::size_t k_step = 16;
        constexpr double k_rounding = 1e-9;
        const Vec3d c = chart(p);
        const double off_centre = 0.35 * norm(c), needed = std::max(0.0, least + off_centre);
        double clearance_sq = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < surface_.size();) {
            for (const std::size_t end = std::min(i + k_step, surface_.size()); i < end; ++i)
                clearance_sq = std::min(clearance_sq, norm_sq(surface_[i] - c));
            if (clearance_sq < (1 - k_rounding) * needed * needed) return -std::numeric_limits<double>::infinity();
        }
        return std::sqrt(clearance_sq) - off_centre;
    }

private:
    [[nodiscard]] Vec3d chart(Vec3d p) const
    {
        const Vec3d q = sq_.rotation * (p - sq_.translation);
        return Vec3d{q.x / sq_.a.x, q.y / sq_.a.y, q.z / sq_.a.z};
    }

    const shape::Superquadricd& sq_;
    std::vector<Vec3d> surface_;
};

/// Points of a grid in the superquadric's box, then points half way through the part's thickness, for parts that its middle
/// misses.
std::vector<Vec3d> centre_candidates(const mesh::Solid& solid, const shape::Superquadricd& sq, std::span<const std::uint32_t> own)
{
    std::vector<Vec3d> candidates;
    constexpr int k_side = 4;
    for (int i = -k_side; i <= k_side; ++i)
        for (int j = -k_side; j <= k_side; ++j)
            for (int k = -k_side; k <= k_side; ++k) {
                const Vec3d l{sq.a.x * i / (k_side + 1.0), sq.a.y * j / (k_side + 1.0), sq.a.z * k / (k_side + 1.0)};
                candidates.push_back(shape::to_model(sq, l));
            }
    const mesh::Mesh& mesh = solid.mesh();
    const std::size_t own_stride = std::max<std::size_t>(1, own.size() / 40);
    for (std::size_t i = 0; i < own.size(); i += own_stride) {
        const mesh::Triangle& tri = mesh.triangles[own[i]];
        const Vec3d a = mesh.vertices[tri[0]];
        const Vec3d n = normalized(cross(mesh.vertices[tri[1]] - a, mesh.vertices[tri[2]] - a));
        const Vec3d c = mesh::triangle_centroid(mesh, own[i]);
        for (double depth = 0.5 * std::min({sq.a.x, sq.a.y, sq.a.z}); depth > 1e-4; depth *= 0.5) {
            const Vec3d p = c - depth * n;
            if (solid.bvh().closest_point(p, 0.71 * depth).distance > 0.7 * depth) {
                candidates.push_back(p);
                break;
            }
        }
    }
    return candidates;
}

}  // namespace

Vec3f choose_centre(const mesh::Solid& solid, const shape::Superquadricd& sq, std::span<const std::uint32_t> own)
{
    const CentreScore score(solid.mesh(), sq, own);
    const std::vector<Vec3d> candidates = centre_candidates(solid, sq, own);
    constexpr double k_none = -std::numeric_limits<double>::infinity();
    // The floor: no surface nearer than a fraction of the least axis, or distances along rays would lose their digits.
    const double floor = 0.02 * std::min({sq.a.x, sq.a.y, sq.a.z});
    Vec3d best{};
    double best_rank = k_none;
    // The candidate as stored, where it may be the centre. Where none may, the best is taken.
    const auto admitted = [&](Vec3d p) -> std::optional<Vec3f> {
        const Vec3f stored = cast<float>(p);
        const Vec3d rounded = cast<double>(stored);
        const bool inside = solid.bvh().winding_number(rounded) > 0;
        const double clearance = solid.bvh().closest_point(rounded, 2 * floor).distance;
        if (inside && clearance > floor) return stored;
        const double rank = inside ? clearance : -1.0;
        if (rank > best_rank) {
            best_rank = rank;
            best = rounded;
        }
        return std::nullopt;
    };
    // As a rule the candidate of the highest score will do, and no other needs its own.
    double highest = k_none;
    Vec3d first = candidates.front();
    for (const Vec3d& p : candidates) {
        if (const double value = score(p, highest); value > highest) {
            highest = value;
            first = p;
        }
    }
    if (const std::optional<Vec3f> centre = admitted(first)) return *centre;
    std::vector<std::pair<double, Vec3d>> ranked;
    for (const Vec3d& p : candidates) ranked.emplace_back(score(p, k_none), p);
    std::stable_sort(ranked.begin(), ranked.end(), [](const auto& l, const auto& r) { return l.first > r.first; });
    for (const auto& [value, p] : ranked)
        if (const std::optional<Vec3f> centre = admitted(p)) return *centre;
    return cast<float>(best);
}

}  // namespace sqmap::bake
