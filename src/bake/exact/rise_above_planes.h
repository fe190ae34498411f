// The rise of the solid above a flat cell's planes, which the exact layer keeps.
#pragma once

#include "bake/locator/clip_to_cube.h"
#include "bake/locator/grid.h"
#include "model/locator_cells.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::bake {

/// How far the solid rises above the lowest of a cell's planes within the cell, as stored. A linear function is greatest at a
/// corner of the solid's part of the cell: at one of the cell's own corners, or where the surface is in it.
class Rise {
public:
    explicit Rise(const mesh::Solid& solid) : solid_(solid) {}

    std::uint8_t operator()(const model::ModelData& data, model::LocatorCell flat, const CellCube& cube,
                            const std::vector<std::uint32_t>& near)
    {
        const Vec3d centre = cube.centre;
        const double h = cube.half();
        const double cell = static_cast<double>(data.locator.cell);
        planes_.clear();
        for (std::uint32_t k = 0; k < flat.planes(); ++k) {
            const model::LocatorPlane plane{data.planes[flat.first() + k]};
            planes_.push_back({cast<double>(plane.normal()), cell * static_cast<double>(plane.distance(data.locator.plane_reach)),
                               k > 0 && plane.is_joined(), 0});
        }
        const auto offer = [&](Vec3d p) {
            for (Plane& plane : planes_) plane.highest = std::max(plane.highest, dot(plane.normal, p) - plane.distance);
        };
        for (const std::uint32_t t : near) {
            const mesh::Triangle& corners = solid_.mesh().triangles[t];
            const auto& v = solid_.mesh().vertices;
            const ClippedTriangle piece =
                clip_to_cube({v[corners[0]] - centre, v[corners[1]] - centre, v[corners[2]] - centre}, h);
            for (int i = 0; i < piece.count; ++i) offer(piece.corners[i]);
        }
        for (int k = 0; k < 8; ++k) {
            const Vec3d corner = h * Vec3d{k & 1 ? 1. : -1., k & 2 ? 1. : -1., k & 4 ? 1. : -1.};
            const bool above = std::any_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
                return dot(plane.normal, corner) - plane.distance > plane.highest;
            });
            if (above && solid_.inside(centre + corner)) offer(corner);
        }
        // A point is above a group of planes where it is above every plane of the group.
        double highest = 0, least = 0;
        for (const Plane& plane : planes_) {
            if (!plane.joined) highest = std::max(highest, least);
            least = plane.joined ? std::min(least, plane.highest) : plane.highest;
        }
        highest = std::max(highest, least);
        return model::encode_rise(highest / cell);
    }

private:
    struct Plane {
        Vec3d normal;
        double distance;
        bool joined;
        double highest;  ///< height of the solid above it
    };

    const mesh::Solid& solid_;
    std::vector<Plane> planes_;
};

}  // namespace sqmap::bake
