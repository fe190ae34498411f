#include "steps.h"

#include "../surface.h"

#include "math/triangle.h"
#include "sqmap/math/box.h"

#include <algorithm>
#include <initializer_list>

namespace sqmap::mesh {

namespace {

constexpr double k_same = 1e-3;  ///< distances of the crossing from both diagonals that are taken for equal, cells

class Triangulator {
public:
    Triangulator(const DualSurface& surface, const Positions& positions) : surface_(surface), positions_(positions)
    {
        mesh_.vertices = positions.vertices;
    }

    ClosedMesh run()
    {
        for (std::size_t q = 0; q < surface_.quads.size(); ++q) {
            const DualQuad& quad = surface_.quads[q];
            mesh_.samples.push_back(sample_of(q));
            mesh_.carrier.push_back(static_cast<std::uint32_t>(mesh_.triangles.size()));
            if (std::all_of(quad.between.begin(), quad.between.end(), [](std::uint32_t v) { return v == KeyTable::k_absent; })) {
                halve(quad.vertices, positions_.crossings[q]);
            } else {
                fan(quad, positions_.crossings[q]);
            }
            mesh_.made_up.resize(mesh_.triangles.size(), positions_.kinds[q] == Crossed::Level);
        }
        return std::move(mesh_);
    }

private:
    /// The crossing; of a shell, whose vertices are moved away from there, the middle.
    [[nodiscard]] Vec3d sample_of(std::size_t q) const
    {
        if (positions_.kinds[q] != Crossed::Shell) return positions_.crossings[q];
        Vec3d sum;
        for (const std::uint32_t v : surface_.quads[q].vertices) sum += positions_.vertices[v];
        return 0.25 * sum;
    }

    [[nodiscard]] double distance_sq(const Triangle& t, Vec3d p) const
    {
        return norm_sq(closest_point_on_triangle(p, mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]) - p);
    }

    void halve(const std::array<std::uint32_t, 4>& v, Vec3d crossing)
    {
        const Triangle first[2] = {{v[0], v[1], v[2]}, {v[0], v[2], v[3]}}, second[2] = {{v[0], v[1], v[3]}, {v[1], v[2], v[3]}};
        const double near_first = std::sqrt(std::min(distance_sq(first[0], crossing), distance_sq(first[1], crossing)));
        const double near_second = std::sqrt(std::min(distance_sq(second[0], crossing), distance_sq(second[1], crossing)));
        const auto& p = mesh_.vertices;
        const bool shorter = norm_sq(p[v[0]] - p[v[2]]) <= norm_sq(p[v[1]] - p[v[3]]);
        const bool take_first = std::abs(near_first - near_second) < k_same ? shorter : near_first < near_second;
        for (const Triangle& t : take_first ? first : second) mesh_.triangles.push_back(t);
    }

    /// Triangles about the crossing.
    void fan(const DualQuad& quad, Vec3d crossing)
    {
        const auto middle = static_cast<std::uint32_t>(mesh_.vertices.size());
        mesh_.vertices.push_back(crossing);
        for (int k = 0; k < 4; ++k) {
            const std::uint32_t a = quad.vertices[k], b = quad.vertices[(k + 1) % 4], m = quad.between[k];
            if (m == KeyTable::k_absent) {
                mesh_.triangles.push_back({middle, a, b});
            } else {
                mesh_.triangles.push_back({middle, a, m});
                mesh_.triangles.push_back({middle, m, b});
            }
        }
    }

    const DualSurface& surface_;
    const Positions& positions_;
    ClosedMesh mesh_;
};

}  // namespace

ClosedMesh triangulated(const DualSurface& surface, const Positions& positions) { return Triangulator(surface, positions).run(); }

void drop_crumbs(ClosedMesh& mesh, double diagonal)
{
    UnionFind sets(mesh.vertices.size());
    for (const Triangle& t : mesh.triangles) {
        sets.unite(t[0], t[1]);
        sets.unite(t[0], t[2]);
    }
    std::vector<Box> boxes(mesh.vertices.size());
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) extend(boxes[sets.find(v)], mesh.vertices[v]);
    std::vector<std::uint32_t> number(mesh.triangles.size(), k_none);
    std::uint32_t kept = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (norm(size(boxes[sets.find(mesh.triangles[t][0])])) < diagonal) continue;
        mesh.triangles[kept] = mesh.triangles[t];
        mesh.made_up[kept] = mesh.made_up[t];
        number[t] = kept++;
    }
    mesh.triangles.resize(kept);
    mesh.made_up.resize(kept);
    std::size_t samples = 0;
    for (std::size_t s = 0; s < mesh.samples.size(); ++s) {
        if (number[mesh.carrier[s]] == k_none) continue;
        mesh.samples[samples] = mesh.samples[s];
        mesh.carrier[samples++] = number[mesh.carrier[s]];
    }
    mesh.samples.resize(samples);
    mesh.carrier.resize(samples);
}

}  // namespace sqmap::mesh
