// Closest points of the boundary for many points of one region.
#pragma once

#include "math/triangle.h"
#include "math/triangle_offsets.h"
#include "sqmap/mesh/solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// The triangles that can be nearest to some point of a region: its samples query these, all at once, and not the whole mesh.
class Nearby {
public:
    /// reach: from the centre, what is farther matters to none.
    Nearby(const mesh::Solid& solid, Vec3d centre, double reach) : solid_(solid), centre_(centre)
    {
        bool all = true;
        solid_.bvh().visit_nearest(centre, reach * reach, [&](std::uint32_t t, double radius_sq) {
            add(t);
            all = all && facets_.size() <= k_max;
            return all ? radius_sq : 0;
        });
        if (!all) facets_.clear();
        put_corners();
    }

    /// near: all that are nearest to some point of the region.
    Nearby(const mesh::Solid& solid, Vec3d centre, std::span<const std::uint32_t> near) : solid_(solid), centre_(centre)
    {
        for (const std::uint32_t t : near) add(t);
        put_corners();
    }

    /// Nearest points of the boundary, no farther off than rounding to float makes them.
    void closest(std::span<const Vec3d> points, std::vector<mesh::ClosestPoint>& out)
    {
        out.clear();
        if (facets_.empty()) {
            for (const Vec3d& p : points) {
                // No farther than the last one's.
                const double within = out.empty() ? INFINITY : 1.000001 * norm(p - out.back().point) + 1e-12;
                out.push_back(solid_.closest_boundary(p, within));
            }
            return;
        }
        const std::size_t columns = (points.size() + k_point_step - 1) / k_point_step * k_point_step;
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t i = 0; i < columns; ++i)
                at_[k][i] = static_cast<float>((points[std::min(i, points.size() - 1)] - centre_)[static_cast<int>(k)]);
            offset_[k].resize(facets_.size() * columns);
        }
        distance_.resize(facets_.size() * columns);
        triangle_offsets(corners_, {at_[0], at_[1], at_[2], columns}, offset_[0].data(), offset_[1].data(), offset_[2].data(),
                         distance_.data());
        std::uint32_t nearest[k_points];
        float least[k_points];
        std::fill_n(nearest, columns, 0u);
        std::copy_n(distance_.begin(), columns, least);
        for (std::uint32_t t = 1; t < facets_.size(); ++t) {
            const float* d = &distance_[t * columns];
            for (std::size_t i = 0; i < columns; ++i) {
                nearest[i] = d[i] < least[i] ? t : nearest[i];
                least[i] = d[i] < least[i] ? d[i] : least[i];
            }
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Facet& facet = facets_[nearest[i]];
            const std::array<Vec3d, 3> corners = corners_of(facet);
            const Vec3d q = closest_point_on_triangle(points[i], corners[0], corners[1], corners[2]);
            out.push_back({q, facet.triangle, norm(q - points[i])});
        }
    }

    static constexpr std::size_t k_points = 32;  ///< that can be asked at once

private:
    /// A triangle that is boundary, or a piece of one that is so in part.
    struct Facet {
        std::uint32_t triangle;
        const std::array<Vec3d, 3>* piece;  ///< null: all of the triangle
    };

    void add(std::uint32_t t)
    {
        const mesh::Boundary b = solid_.boundary()[t];
        if (b == mesh::Boundary::Whole) facets_.push_back({t, nullptr});
        if (b == mesh::Boundary::Partly)
            for (const std::array<Vec3d, 3>& piece : solid_.visible(t)) facets_.push_back({t, &piece});
    }
    std::array<Vec3d, 3> corners_of(const Facet& facet) const
    {
        if (facet.piece != nullptr) return *facet.piece;
        const mesh::Triangle& t = solid_.mesh().triangles[facet.triangle];
        const auto& v = solid_.mesh().vertices;
        return {v[t[0]], v[t[1]], v[t[2]]};
    }
    void put_corners()
    {
        for (const Facet& facet : facets_)
            for (const Vec3d& p : corners_of(facet)) corners_.push_back(cast<float>(p - centre_));
    }

    static constexpr std::size_t k_max = 400;  ///< more than these take longer than the mesh's tree

    const mesh::Solid& solid_;
    Vec3d centre_;
    std::vector<Facet> facets_;
    std::vector<Vec3f> corners_;
    float at_[3][k_points] = {};
    std::vector<float> offset_[3], distance_;
};

}  // namespace sqmap::bake
