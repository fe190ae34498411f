// What the exact layer keeps beside a flat place's planes.
#pragma once

#include "bake/locator/clip_to_cube.h"
#include "query/approach.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::bake {

/// How far the solid rises above the lowest of a place's planes within the place, as stored. A linear function is greatest at a
/// corner of the solid's part of the place: at one of the place's own corners, or where the surface is in it.
class Rise {
public:
    explicit Rise(const mesh::Solid& solid) : solid_(solid) {}

    std::uint8_t operator()(const model::ModelData& data, std::uint32_t place, Vec3d centre, double h,
                            const std::vector<std::uint32_t>& near)
    {
        const double cell = static_cast<double>(data.locator.cell);
        planes_.clear();
        for (std::uint32_t k = 0; k < model::place_planes(place); ++k) {
            const std::uint32_t plane = data.planes[model::place_first(place) + k];
            planes_.push_back({cast<double>(query::plane_normal(plane)),
                               cell * static_cast<double>(model::plane_distance(plane, data.locator.plane_reach)),
                               (plane & model::k_joined) != 0, 0});
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
        // Nothing is above a group that is not above all of it.
        double highest = 0, least = 0;
        for (const Plane& plane : planes_) {
            if (!plane.joined) highest = std::max(highest, least);
            least = plane.joined ? std::min(least, plane.highest) : plane.highest;
        }
        highest = std::max(highest, least);
        const double steps = std::ceil((highest / cell + 1e-3) / static_cast<double>(model::k_rise_step));
        return steps < model::k_no_rise ? static_cast<std::uint8_t>(steps) : model::k_no_rise;
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
