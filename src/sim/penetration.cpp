// Depth of cloth inside colliders, measured independently of the simulation.
#include "sqmap/math/assert.h"
#include "sqmap/query/point.h"
#include "sqmap/sim/cloth.h"

#include <algorithm>
#include <vector>

namespace sqmap::sim {

namespace {

double depth_of(Vec3d p, std::span<const Collider> colliders, query::Layer layer)
{
    double deepest = 0;
    for (const Collider& collider : colliders) {
        if (collider.model == nullptr || collider.skin != nullptr) continue;
        const query::Body touched{collider.model, nullptr, collider.pose};
        const query::PointResult contact = query::query_point(touched, p, {.layer = layer});
        if (contact.contact) deepest = std::max(deepest, contact.depth);
    }
    return deepest;
}

}  // namespace

Penetration penetration(std::span<const Vec3d> nodes, std::span<const std::array<std::uint32_t, 3>> triangles,
                        std::span<const Collider> colliders, const PenetrationOptions& options)
{
    const int steps = options.steps;
    std::vector<Vec3d> points(nodes.begin(), nodes.end());
    for (const auto& t : triangles) {
        SQMAP_ASSERT(t[0] < nodes.size() && t[1] < nodes.size() && t[2] < nodes.size());
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; j <= steps - i; ++j) {
                const int k = steps - i - j;
                if (i == steps || j == steps || k == steps) continue;
                const double n = steps;
                points.push_back((i / n) * nodes[t[0]] + (j / n) * nodes[t[1]] + (k / n) * nodes[t[2]]);
            }
    }
    std::vector<double> depth(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) depth[p] = depth_of(points[p], colliders, options.layer);
    for (const Collider& collider : colliders)
        if (collider.model != nullptr && collider.skin != nullptr) {
            query::SkinWorkspace workspace(collider.skin->lattice(), points);
            std::vector<query::SkinContact> contacts(points.size());
            const auto found = query::query_skin({collider.model, &collider.skin->to(), points, {}}, {.layer = options.layer},
                                                 workspace, contacts);
            for (const query::SkinContact& c : std::span(contacts).first(std::min(found.contacts, contacts.size())))
                depth[c.index] = std::max(depth[c.index], c.depth);
        }
    Penetration out;
    for (std::size_t p = 0; p < points.size(); ++p) {
        const bool node = p < nodes.size();
        double& deepest = node ? out.nodes : out.interiors;
        if (!(depth[p] > deepest)) continue;
        deepest = depth[p];
        (node ? out.node_at : out.interior_at) = points[p];
    }
    return out;
}

}  // namespace sqmap::sim
