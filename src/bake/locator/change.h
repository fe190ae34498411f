// The triangles that moved before a rebake, and the space in which they matter.
#pragma once

#include "math/triangle.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/model/model.h"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace sqmap::bake {

/// Triangles where they were and where they are, model space; parts as they were, and which of them have a new map.
class Change {
public:
    Change(mesh::Mesh both, std::vector<model::Part> parts, std::vector<std::uint8_t> remade)
        : mesh_(std::move(both)), bvh_(mesh_), parts_(std::move(parts)), remade_(std::move(remade))
    {
    }
    Change(const Change&) = delete;
    Change& operator=(const Change&) = delete;

    /// True where some changed triangle is nearer than that.
    [[nodiscard]] bool reaches(Vec3d p, double within) const
    {
        bool any = false;
        if (mesh_.triangles.empty()) return any;
        bvh_.visit_nearest(p, within * within, [&](std::uint32_t t, double radius_sq) {
            const mesh::Triangle& c = mesh_.triangles[t];
            const Vec3d q = closest_point_on_triangle(p, mesh_.vertices[c[0]], mesh_.vertices[c[1]], mesh_.vertices[c[2]]);
            any = any || norm_sq(q - p) < radius_sq;
            return any ? 0 : radius_sq;
        });
        return any;
    }
    /// True where the nearest triangle of some point of the box about a centre may have changed or moved. A point
    /// of the box is at most nearest + half its diagonal from the surface, and a triangle farther from the centre by as much
    /// again matters to none. nearest: distance of the unchanged surface, or of the surface that there is now.
    [[nodiscard]] bool reaches_box(Vec3d centre, double half, double nearest) const
    {
        return reaches(centre, (nearest + 2 * std::sqrt(3.0) * half) * 1.001);
    }
    [[nodiscard]] bool remade(std::uint32_t part) const { return remade_[part] != 0; }
    [[nodiscard]] const model::Part& before(std::uint32_t part) const { return parts_[part]; }

private:
    mesh::Mesh mesh_;
    mesh::Bvh bvh_;
    std::vector<model::Part> parts_;
    std::vector<std::uint8_t> remade_;
};

}  // namespace sqmap::bake
