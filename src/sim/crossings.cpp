// Edges through triangles, measured independently of the simulation.
#include "sim/crossings.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace sqmap::sim {

namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Edge = std::array<std::uint32_t, 2>;

/// Six times the volume of a tetrahedron.
double side(Vec3d a, Vec3d b, Vec3d c, Vec3d p) { return dot(cross(b - a, c - a), p - a); }

bool goes_through(Vec3d p, Vec3d q, Vec3d a, Vec3d b, Vec3d c)
{
    if (!(side(a, b, c, p) * side(a, b, c, q) < 0)) return false;
    const double u = side(p, q, a, b), v = side(p, q, b, c), w = side(p, q, c, a);
    return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

struct Count : btDbvt::ICollide {
    std::span<const Vec3d> at;
    std::span<const std::uint32_t> same;
    std::size_t found = 0;

    [[nodiscard]] std::uint32_t name(std::uint32_t v) const { return same.empty() ? v : same[v]; }
    void Process(const btDbvtNode* edge_leaf, const btDbvtNode* triangle_leaf) override
    {
        const Edge& e = *static_cast<const Edge*>(edge_leaf->data);
        const Triangle& t = *static_cast<const Triangle*>(triangle_leaf->data);
        for (const std::uint32_t i : e)
            for (const std::uint32_t j : t)
                if (name(i) == name(j)) return;
        found += goes_through(at[e[0]], at[e[1]], at[t[0]], at[t[1]], at[t[2]]) ? 1 : 0;
    }
};

/// Rounded outwards: Bullet's boxes are float.
template <class Element>
void insert(btDbvt& tree, Element& element, std::span<const Vec3d> at)
{
    btVector3 low(SIMD_INFINITY, SIMD_INFINITY, SIMD_INFINITY), high = -low;
    for (const std::uint32_t v : element) {
        const btVector3 p(static_cast<btScalar>(at[v].x), static_cast<btScalar>(at[v].y), static_cast<btScalar>(at[v].z));
        const btVector3 slack = btScalar(1e-6) * p.absolute();
        low.setMin(p - slack);
        high.setMax(p + slack);
    }
    tree.insert(btDbvtVolume::FromMM(low, high), &element);
}

}  // namespace

std::size_t crossings(std::span<const Vec3d> positions, std::span<const Triangle> triangles, std::span<const std::uint32_t> same)
{
    std::vector<Triangle> faces(triangles.begin(), triangles.end());
    std::vector<Edge> edges;
    edges.reserve(3 * faces.size());
    for (const Triangle& t : faces)
        for (std::size_t k = 0; k < 3; ++k) edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    btDbvt edge_tree, face_tree;
    for (Edge& e : edges) insert(edge_tree, e, positions);
    for (Triangle& t : faces) insert(face_tree, t, positions);
    Count count;
    count.at = positions;
    count.same = same;
    edge_tree.collideTT(edge_tree.m_root, face_tree.m_root, count);
    return count.found;
}

}  // namespace sqmap::sim
