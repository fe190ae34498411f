#include "sqmap/haptic/patch.h"

#include "sqmap/math/assert.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

namespace sqmap::haptic {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

struct Surface {
    std::span<const Vec3d> vertices;
    std::span<const Triangle> triangles;
};

/// Divides the triangles; nothing if that needs more than max_points.
std::optional<PatchPoints> divide(const Surface& surface, double spacing, std::size_t max_points)
{
    PatchPoints out;
    out.points.assign(surface.vertices.begin(), surface.vertices.end());
    out.weights.assign(surface.vertices.size(), 0.f);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(out.points.size()));
        if (fresh) {
            out.points.push_back(0.5 * (out.points[a] + out.points[b]));
            out.weights.push_back(0.f);
        }
        return at->second;
    };
    std::vector<Triangle> left;
    for (const Triangle& whole : surface.triangles) {
        SQMAP_ASSERT(std::max({whole[0], whole[1], whole[2]}) < surface.vertices.size());
        left.assign(1, whole);
        while (!left.empty()) {
            const Triangle t = left.back();
            left.pop_back();
            const Vec3d a = out.points[t[0]], b = out.points[t[1]], c = out.points[t[2]];
            const double longest_sq = std::max({norm_sq(b - a), norm_sq(c - b), norm_sq(a - c)});
            if (!(spacing > 0) || !(longest_sq > spacing * spacing)) {
                const auto third = static_cast<float>(norm(cross(b - a, c - a)) / 6);
                for (const std::uint32_t v : t) out.weights[v] += third;
                continue;
            }
            const std::uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
            if (out.points.size() > max_points) return std::nullopt;
            left.insert(left.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
        }
    }
    return out;
}

}  // namespace

PatchPoints patch_points(std::span<const Vec3d> vertices, std::span<const Triangle> triangles, double spacing,
                         std::size_t max_points)
{
    for (;; spacing *= 1.2)
        if (std::optional<PatchPoints> points = divide({vertices, triangles}, spacing, max_points)) return std::move(*points);
}

DenserSets::DenserSets(std::span<const Vec3d> vertices, std::span<const Triangle> triangles, std::size_t max_points)
{
    std::size_t before = vertices.size();
    for (const double spacing : {0.0025, 0.002, 0.0015}) {
        std::optional<PatchPoints> patch = divide({vertices, triangles}, spacing, max_points);
        if (!patch) break;
        if (patch->points.size() == before) continue;
        before = patch->points.size();
        sets_.push_back(std::make_unique<Set>(Set{query::Probe(patch->points), std::move(patch->weights)}));
    }
    for (const auto& set : sets_) points_.push_back({&set->probe, set->weights});
}

std::size_t DenserSets::max_points() const noexcept { return points_.empty() ? 0 : points_.back().probe->size(); }

}  // namespace sqmap::haptic
