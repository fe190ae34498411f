// Rays by the mesh's own tree in double precision. Which side of the surface a ray starts on is never left to its crossings where
// they contradict each other.
#include "paper/bake/grid.h"

#include <algorithm>
#include <limits>
#include <map>
#include <mutex>

namespace sqmap::paper {

struct MapRays::Implementation {
    explicit Implementation(const mesh::Mesh& m) : mesh(m), bvh(m) {}

    const mesh::Mesh& mesh;
    mesh::Bvh bvh;
    std::mutex making;
    std::map<double, SmoothSurface> smoothed;
};

MapRays::MapRays(const mesh::Mesh& mesh) : implementation_(std::make_unique<Implementation>(mesh)) {}
MapRays::~MapRays() = default;
MapRays::MapRays(MapRays&&) noexcept = default;
MapRays& MapRays::operator=(MapRays&&) noexcept = default;
const mesh::Mesh& MapRays::mesh() const { return implementation_->mesh; }
const mesh::Bvh& MapRays::bvh() const { return implementation_->bvh; }

const SmoothSurface& MapRays::smoothed(double share) const
{
    const std::lock_guard lock(implementation_->making);
    const auto [at, is_new] = implementation_->smoothed.try_emplace(share);
    if (is_new) at->second = smooth_surface(mesh(), share * mesh::largest_vertex_distance(mesh()));
    return at->second;
}

std::optional<MapRays::Hit> MapRays::first_hit(Vec3d origin, Vec3d direction, double from, double to) const
{
    const std::optional<mesh::Bvh::Hit> hit = implementation_->bvh.first_hit({origin, direction, from, to});
    if (!hit) return std::nullopt;
    return Hit{hit->t, hit->triangle, hit->entering};
}

MapRays::Surface MapRays::surface_along(Vec3d origin, Vec3d direction, Reach reach, std::vector<Gap>* gaps) const
{
    const auto [to, lift] = reach;
    constexpr int k_max_crossings = 64;
    constexpr double k_step = 2e-6;  // two triangles at an edge are one crossing
    const Vec3d start = origin - lift * direction;
    Hit hits[k_max_crossings];
    int count = 0, sum = 0;
    double from = 0;
    std::vector<mesh::Bvh::Hit> all;
    implementation_->bvh.all_hits({start, direction}, all);
    for (const mesh::Bvh::Hit& hit : all) {
        if (count == k_max_crossings) break;
        if (hit.t < from) continue;
        hits[count++] = {hit.t, hit.triangle, hit.entering};
        sum += hit.entering ? 1 : -1;
        from = hit.t + k_step * (1 + hit.t);
    }
    // Outside at the far end, so the start's winding number is minus the sum of what was crossed.
    int winding = -sum;
    const bool plausible = winding == 0 ? count == 0 || hits[0].entering : winding == 1 && count > 0 && !hits[0].entering;
    if (!plausible) winding = implementation_->bvh.winding_number(start);
    Surface first;
    bool inside = winding > 0, found = inside;
    if (inside) first.kind = Kind::Cap;
    for (int i = 0; i < count && hits[i].distance - lift <= to; ++i) {
        winding += hits[i].entering ? 1 : -1;
        const double distance = std::max(hits[i].distance - lift, 0.0);
        if (inside == (winding > 0)) continue;
        inside = winding > 0;
        if (!found) {
            found = true;
            first = {Kind::Hit, distance, hits[i].triangle};
        } else if (gaps) {
            if (!inside)
                gaps->push_back({distance, std::numeric_limits<double>::infinity()});
            else if (!gaps->empty())
                gaps->back().enter = distance;
        }
        if (!gaps) break;
    }
    return first;
}

}  // namespace sqmap::paper
