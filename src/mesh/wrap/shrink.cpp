// Dual contouring (Ju et al. 2002) of the surface at a distance from the nearest triangles. It starts from surface nets in cells
// that the input does not touch, and every step toward it is checked, so that the input stays inside.
#include "outer_steps.h"
#include "symmetric.h"

#include "math/triangle.h"
#include "sqmap/mesh/self_intersection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sqmap::mesh {

namespace {

constexpr double k_plane_share = 0.03;  ///< share of the greatest eigenvalue below which planes agree
constexpr double k_face_on = 0.5;       ///< cosine above which a triangle's own normal stands for the direction to it
constexpr double k_beyond_feet = 1;     ///< a vertex goes no farther than that from the mean of its planes' points, cells
constexpr int k_plane_rounds = 2;       ///< the second one finds the planes from near by
constexpr int k_crossing_rounds = 12;
constexpr double k_brick = 4;  ///< side of the bricks in which crossings are found again, cells
/// How far toward its target a vertex goes: one step down each time that a triangle of it touches.
constexpr std::array<double, 6> k_shares{1, 0.9, 0.75, 0.5, 0.25, 0};

class Shrinker {
public:
    Shrinker(const DualSurface& surface, const OuterLabels& labels, const ShrinkInput& input)
        : surface_(surface), labels_(labels), in_(input)
    {
    }

    ClosedMesh run()
    {
        start();
        const std::vector<Vec3d> start = triangulated(surface_, positions_).vertices;
        for (int i = 0; i < k_plane_rounds; ++i) move_to_planes();
        ClosedMesh mesh = triangulated(surface_, positions_);
        retreat(mesh, start);
        mesh.samples.clear();
        mesh.carrier.clear();
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            mesh.samples.push_back((mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3.0);
            mesh.carrier.push_back(t);
        }
        return mesh;
    }

private:
    [[nodiscard]] std::size_t sheets() const { return surface_.vertex_cell.size(); }

    /// Every vertex at the mean of its crossed edges' middles, which lies in its cell.
    void start()
    {
        std::vector<std::pair<Vec3d, int>> sums(sheets() + surface_.between_count);
        for (const DualQuad& quad : surface_.quads) {
            const Vec3d middle =
                0.5 * (position(labels_.grid.corners.point(quad.inside)) + position(labels_.grid.corners.point(quad.outside)));
            positions_.crossings.push_back(middle);
            positions_.kinds.push_back(labels_.inside[quad.inside] == k_sealed ? Crossed::Level : Crossed::Input);
            for (int k = 0; k < 4; ++k)
                for (const std::uint32_t v : {quad.vertices[k], quad.between[k]})
                    if (v != KeyTable::k_absent) {
                        sums[v].first += middle;
                        ++sums[v].second;
                    }
        }
        for (const auto& [sum, count] : sums) positions_.vertices.push_back(sum / double(count));
    }

    /// One round of dual contouring: planes at the middles of the quadrilaterals.
    void move_to_planes()
    {
        struct Sum {
            PlaneSum planes;  ///< about the vertex
            Vec3d points;     ///< relative to it
            int count = 0;
        };
        std::vector<Sum> sums(positions_.vertices.size());
        for (std::size_t q = 0; q < surface_.quads.size(); ++q) {
            const DualQuad& quad = surface_.quads[q];
            Vec3d middle;
            for (const std::uint32_t v : quad.vertices) middle += 0.25 * positions_.vertices[v];
            if (positions_.kinds[q] == Crossed::Level) continue;
            const auto [point, normal] = plane_at(middle);
            positions_.crossings[q] = point;
            for (int k = 0; k < 4; ++k)
                for (const std::uint32_t v : {quad.vertices[k], quad.between[k]})
                    if (v != KeyTable::k_absent) {
                        const Vec3d local = point - positions_.vertices[v];
                        sums[v].planes.add(local, normal);
                        sums[v].points += local;
                        ++sums[v].count;
                    }
        }
        for (std::size_t v = 0; v < sums.size(); ++v) {
            if (sums[v].count == 0) continue;
            const Vec3d mean = sums[v].points / double(sums[v].count);
            const Vec3d x = least_point(sums[v].planes, mean, k_plane_share);
            positions_.vertices[v] += norm(x - mean) < k_beyond_feet ? x : mean;
        }
    }

    /// The plane at the offset from the triangle nearest to a point outside, and its point below that one.
    [[nodiscard]] std::pair<Vec3d, Vec3d> plane_at(Vec3d p) const
    {
        const ClosestPoint nearest = in_.bvh.closest_point(p);
        const Triangle& t = in_.soup.triangles[nearest.triangle];
        const Vec3d a = in_.soup.vertices[t[0]];
        const Vec3d own = normalized(cross(in_.soup.vertices[t[1]] - a, in_.soup.vertices[t[2]] - a));
        const Vec3d off = p - nearest.point;
        if (!(nearest.distance > 1e-9)) return {nearest.point + in_.offset * own, own};
        const double cosine = dot(own, off) / nearest.distance;
        const Vec3d normal = std::abs(cosine) > k_face_on ? (cosine > 0 ? own : -own) : off / nearest.distance;
        return {nearest.point + in_.offset * normal, normal};
    }

    /// Takes vertices back toward where they started until no triangle touches the input, nor another triangle.
    void retreat(ClosedMesh& mesh, const std::vector<Vec3d>& start)
    {
        const std::vector<Vec3d> target = mesh.vertices;
        std::vector<std::uint8_t> step(mesh.vertices.size());
        around_.assign(mesh.vertices.size(), {});
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (const std::uint32_t v : mesh.triangles[t]) around_[v].push_back(t);
        std::vector<std::uint32_t> doubtful(mesh.triangles.size());
        for (std::uint32_t t = 0; t < doubtful.size(); ++t) doubtful[t] = t;
        const auto back = [&](const std::vector<std::uint32_t>& bad, std::size_t steps) {
            std::vector<std::uint32_t> moved;
            for (const std::uint32_t t : bad)
                for (const std::uint32_t v : mesh.triangles[t]) moved.push_back(v);
            std::sort(moved.begin(), moved.end());
            moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
            doubtful.clear();
            for (const std::uint32_t v : moved) {
                if (step[v] == k_shares.size() - 1) continue;
                step[v] = static_cast<std::uint8_t>(std::min(step[v] + steps, k_shares.size() - 1));
                mesh.vertices[v] = start[v] + k_shares[step[v]] * (target[v] - start[v]);
                doubtful.insert(doubtful.end(), around_[v].begin(), around_[v].end());
            }
            std::sort(doubtful.begin(), doubtful.end());
            doubtful.erase(std::unique(doubtful.begin(), doubtful.end()), doubtful.end());
        };
        bool knows_crossings = false, was_outside = true;
        for (int round = 0; round < k_crossing_rounds; ++round) {
            std::vector<std::uint32_t> changed = doubtful;
            while (!doubtful.empty()) {
                back(touching(mesh, doubtful), 1);
                changed.insert(changed.end(), doubtful.begin(), doubtful.end());
            }
            std::vector<std::uint32_t> bad = knows_crossings ? crossed(mesh, changed) : std::vector<std::uint32_t>{};
            std::size_t steps = round < k_crossing_rounds / 2 ? 1 : k_shares.size();
            if (bad.empty() && was_outside) {
                bad = outside(mesh);
                was_outside = !bad.empty();
                if (was_outside) steps = k_shares.size();
            }
            if (bad.empty() && !knows_crossings) {
                bad = crossed(mesh, {});
                knows_crossings = true;
            }
            if (bad.empty()) return;
            back(bad, steps);
        }
        while (!doubtful.empty()) back(touching(mesh, doubtful), 1);
    }

    [[nodiscard]] std::vector<std::uint32_t> touching(const ClosedMesh& mesh, const std::vector<std::uint32_t>& triangles) const
    {
        std::vector<std::uint32_t> out;
        for (const std::uint32_t t : triangles) {
            const auto& [a, b, c] = mesh.triangles[t];
            if (in_.enclosed.met_by({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]})) out.push_back(t);
        }
        return out;
    }

    /// Triangles that cross others. changed: only those, and what they cross; empty for all.
    static std::vector<std::uint32_t> crossed(const ClosedMesh& mesh, const std::vector<std::uint32_t>& changed)
    {
        // A triangle that crosses a changed one has a brick of the lattice in common with it.
        const auto each_brick = [&](std::uint32_t t, auto&& visit) {
            Box box;
            for (const std::uint32_t v : mesh.triangles[t]) extend(box, mesh.vertices[v]);
            LatticePoint lo{}, hi{};
            for (int k = 0; k < 3; ++k) {
                lo[k] = static_cast<std::int32_t>(std::floor(box.lo[k] / k_brick));
                hi[k] = static_cast<std::int32_t>(std::floor(box.hi[k] / k_brick));
            }
            for (LatticePoint p = lo; p[2] <= hi[2]; ++p[2])
                for (p[1] = lo[1]; p[1] <= hi[1]; ++p[1])
                    for (p[0] = lo[0]; p[0] <= hi[0]; ++p[0]) visit(p);
        };
        KeyTable bricks;
        for (const std::uint32_t t : changed) each_brick(t, [&](LatticePoint p) { bricks.insert(p); });
        Mesh part{mesh.vertices, {}};
        std::vector<std::uint32_t> number, out;
        std::vector<std::uint8_t> is_changed(mesh.triangles.size(), changed.empty() ? 1 : 0), among;
        for (const std::uint32_t t : changed) is_changed[t] = 1;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            bool is_near = changed.empty();
            if (!is_near) each_brick(t, [&](LatticePoint p) { is_near = is_near || bricks.find(p) != KeyTable::k_absent; });
            if (!is_near) continue;
            number.push_back(t);
            part.triangles.push_back(mesh.triangles[t]);
            among.push_back(is_changed[t]);
        }
        const SelfIntersections found = find_self_intersections(part, std::numeric_limits<std::uint64_t>::max(), among);
        for (std::size_t i = 0; i < number.size(); ++i)
            if (found.crossed[i] != 0) out.push_back(number[i]);
        return out;
    }

    /// The triangles about what the surface passed over.
    [[nodiscard]] std::vector<std::uint32_t> outside(const ClosedMesh& mesh) const
    {
        const Mesh solid{mesh.vertices, mesh.triangles};
        const Bvh bvh(solid);
        std::vector<std::uint8_t> is_out(mesh.triangles.size());
        for (const Vec3d& p : in_.soup.vertices) {
            if (bvh.winding_number(p) > 0) continue;
            const std::uint32_t t = bvh.closest_point(p).triangle;
            for (const std::uint32_t v : mesh.triangles[t])
                for (const std::uint32_t near : around_[v]) is_out[near] = 1;
        }
        std::vector<std::uint32_t> out;
        for (std::uint32_t t = 0; t < is_out.size(); ++t)
            if (is_out[t] != 0) out.push_back(t);
        return out;
    }

    const DualSurface& surface_;
    const OuterLabels& labels_;
    const ShrinkInput& in_;
    Positions positions_;
    std::vector<std::vector<std::uint32_t>> around_;
};

}  // namespace

ClosedMesh shrunk(const DualSurface& surface, const OuterLabels& labels, const ShrinkInput& input)
{
    return Shrinker(surface, labels, input).run();
}

}  // namespace sqmap::mesh
