// A grid sees no wall thinner than its cells. Corners within half a cell of such a wall count as inside: with the rule that
// inside corners join across ambiguous sides, a layer one cell thick has no hole.
#include "steps.h"

#include "math/triangle.h"

#include <algorithm>

namespace sqmap::mesh {

namespace {

constexpr double k_half_layer = 0.55;    ///< of a layer without holes, cells
constexpr double k_depth = 1.05;         ///< a solid that deep needs no layer, cells
constexpr double k_shallow = 0.6;        ///< a solid that deep which ends at no triangle needs no layer, cells
constexpr double k_probe_height = 1e-3;  ///< where the two sides of a triangle are probed, cells
constexpr double k_from_rim = 0.05;      ///< how far from a triangle's edge it is probed, cells
constexpr double k_opposite = -0.8;      ///< cosine between the normals of a thin wall's two sides
constexpr double k_alike = 0.95;         ///< cosine between normals of triangles of which one is probed
constexpr std::size_t k_probes = 4;      ///< triangles of one cell that are probed

class Labeller {
public:
    Labeller(Grid& grid, const Source& source) : grid_(grid), in_(source) {}

    Labels run()
    {
        labels_.thin.assign(in_.soup.triangles.size(), Thin::No);
        label_new_corners();
        std::vector<std::uint32_t> near_thin;
        for (std::uint32_t cell = 0; cell + 1 < grid_.first.size(); ++cell) find_thin(cell, near_thin);
        for (const std::uint32_t corner : near_thin)
            if (labels_.inside[corner] == 0) labels_.inside[corner] = k_shell;
        follow_boundary();
        return std::move(labels_);
    }

private:
    void label_new_corners()
    {
        for (auto c = static_cast<std::uint32_t>(labels_.winding.size()); c < grid_.corners.size(); ++c) {
            const double w = in_.winding.at(position(grid_.corners.point(c)));
            labels_.winding.push_back(static_cast<float>(w));
            labels_.inside.push_back(w > 0.5 ? k_solid : 0);
        }
    }

    /// Tells a thin wall or a sheet at point q of a triangle; No if the solid below is deep or ends at a slope, as it does at a
    /// sharp edge.
    Thin thinness(Vec3d q, Vec3d normal)
    {
        const Vec3d below = q - k_probe_height * normal;
        const bool solid_below = in_.winding.at(below) > 0.5;
        if (in_.winding.at(q - k_depth * normal) > 0.5) return Thin::No;
        if (!solid_below) return Thin::Sheet;
        if (in_.winding.at(q + k_probe_height * normal) > 0.5) return Thin::No;
        in_.bvh.ray_crossings(below, -normal, crossings_);
        bool sloping = false;
        for (const Bvh::Crossing& crossing : crossings_) {
            if (crossing.t > k_depth) break;
            if (crossing.sign < 0) continue;
            if (dot(normal_of(crossing.triangle), normal) <= k_opposite)
                return crossing.t > in_.thickness ? Thin::Wall : Thin::Sheet;
            sloping = true;
        }
        // No opposite wall is near: a sheet, if a point just below already lies outside.
        return sloping || in_.winding.at(q - k_shallow * normal) > 0.5 ? Thin::No : Thin::Sheet;
    }

    [[nodiscard]] Vec3d normal_of(std::uint32_t t) const
    {
        const Triangle& v = in_.soup.triangles[t];
        const Vec3d a = in_.soup.vertices[v[0]];
        return normalized(cross(in_.soup.vertices[v[1]] - a, in_.soup.vertices[v[2]] - a));
    }

    /// Probes the triangles of a cell that have corners behind them which are outside.
    void find_thin(std::uint32_t cell, std::vector<std::uint32_t>& near_thin)
    {
        const auto& corners = grid_.cell_corners[cell];
        const Vec3d lo = position(grid_.cells.point(cell)), middle = lo + Vec3d{0.5, 0.5, 0.5};
        std::vector<std::pair<Vec3d, Thin>> probed;
        for (const std::uint32_t t : grid_.triangles_of(cell)) {
            const Triangle& v = in_.soup.triangles[t];
            const Vec3d a = in_.soup.vertices[v[0]], b = in_.soup.vertices[v[1]], c = in_.soup.vertices[v[2]];
            const Vec3d normal = normal_of(t);
            const bool suspicious = std::any_of(corners.begin(), corners.end(), [&](std::uint32_t corner) {
                return labels_.inside[corner] == 0 && dot(position(grid_.corners.point(corner)) - a, normal) < 0;
            });
            if (!suspicious || norm_sq(normal) == 0) continue;
            const Vec3d q = closest_point_on_triangle(middle, a, b, c), off = q - middle, inward = (a + b + c) / 3.0 - q;
            if (std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) > 0.5 + k_probe_height) continue;
            // Parallel triangles of a cell get the same label without another probe.
            const auto alike = std::find_if(probed.begin(), probed.end(), [&](const auto& other) {
                const double cosine = dot(other.first, normal);
                return cosine > k_alike || (cosine < -k_alike && other.second != Thin::No);
            });
            if (alike == probed.end() && probed.size() == k_probes) continue;
            // Not at the triangle's rim, where another one's plane may be probed.
            const Vec3d inner = q + std::min(1.0, k_from_rim / std::max(norm(inward), k_from_rim)) * inward;
            const Thin thin = alike == probed.end() ? thinness(inner, normal) : alike->second;
            if (alike == probed.end()) probed.emplace_back(normal, thin);
            if (thin != Thin::No) {
                labels_.thin[t] = std::max(labels_.thin[t], thin);
                for (const std::uint32_t corner : corners) {
                    const Vec3d p = position(grid_.corners.point(corner));
                    if (norm_sq(closest_point_on_triangle(p, a, b, c) - p) <= k_half_layer * k_half_layer)
                        near_thin.push_back(corner);
                }
            }
        }
    }

    /// Adds the neighbours across sides whose corners differ, and theirs.
    void follow_boundary()
    {
        for (std::uint32_t cell = 0; cell < grid_.cells.size(); ++cell) {
            for (int side = 0; side < 6; ++side) {
                const int axis = side / 2, upper = side % 2;
                int count = 0;
                for (int k = 0; k < 8; ++k)
                    if ((k >> axis & 1) == upper && labels_.inside[grid_.cell_corners[cell][k]] != 0) ++count;
                if (count == 0 || count == 4) continue;
                LatticePoint p = grid_.cells.point(cell);
                p[axis] += upper ? 1 : -1;
                grid_.add_cell(p);
                label_new_corners();
            }
        }
    }

    Grid& grid_;
    const Source& in_;
    std::vector<Bvh::Crossing> crossings_;
    Labels labels_;
};

}  // namespace

Labels label_corners(Grid& grid, const Source& source) { return Labeller(grid, source).run(); }

}  // namespace sqmap::mesh
