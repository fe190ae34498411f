// How deep cloth is inside solids: measured, apart from what the simulation believes.
#include "sqmap/sim/cloth.h"

#include <algorithm>

namespace sqmap::sim {

namespace {

double depth_of(Vec3d p, std::span<const Solid> solids, query::Layer layer)
{
    double deepest = 0;
    for (const Solid& solid : solids) {
        if (solid.model == nullptr) continue;
        const auto& header = solid.model->header;
        const query::Pose to = query::inverse(solid.pose);
        const Vec3d in_mesh = to.rotation * p + to.translation;
        const Vec3d in_model = (in_mesh - Vec3d{header.origin[0], header.origin[1], header.origin[2]}) / header.unit;
        const query::Contact contact = query::query_point(*solid.model, cast<float>(in_model), layer);
        if (contact.contact) deepest = std::max(deepest, header.unit * static_cast<double>(contact.depth));
    }
    return deepest;
}

}  // namespace

Penetration penetration(std::span<const Vec3d> nodes, std::span<const std::array<std::uint32_t, 3>> triangles,
                        std::span<const Solid> solids, int steps, query::Layer layer)
{
    Penetration out;
    const auto keep = [&](Vec3d p, double& deepest, Vec3d& at) {
        const double depth = depth_of(p, solids, layer);
        if (!(depth > deepest)) return;
        deepest = depth;
        at = p;
    };
    for (const Vec3d& p : nodes) keep(p, out.nodes, out.node_at);
    for (const auto& t : triangles)
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; j <= steps - i; ++j) {
                const int k = steps - i - j;
                if (i == steps || j == steps || k == steps) continue;
                const double n = steps;
                const Vec3d p = (i / n) * nodes[t[0]] + (j / n) * nodes[t[1]] + (k / n) * nodes[t[2]];
                keep(p, out.interiors, out.interior_at);
            }
    return out;
}

}  // namespace sqmap::sim
