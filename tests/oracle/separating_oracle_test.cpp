// Separating translations against CGAL's exact triangles: a little farther nothing meets, a little nearer something does.
#include "query/probe/triangle_tree.h"
#include "sqmap/query/overlap.h"
#include "sqmap/query/separating.h"
#include "support/bodies.h"
#include "support/small_meshes.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include <gtest/gtest.h>

namespace sqmap {
namespace {

using PartingKernel = CGAL::Exact_predicates_exact_constructions_kernel;
using PartingMesh = CGAL::Surface_mesh<PartingKernel::Point_3>;

PartingMesh parting_mesh(const mesh::Mesh& mesh, const Affine& move)
{
    PartingMesh out;
    for (const Vec3d& v : mesh.vertices) {
        const Vec3d p = apply(move, v);
        out.add_vertex({p.x, p.y, p.z});
    }
    using Index = PartingMesh::Vertex_index;
    for (const mesh::Triangle& t : mesh.triangles) out.add_face(Index(t[0]), Index(t[1]), Index(t[2]));
    return out;
}

std::vector<PartingKernel::Triangle_3> parting_triangles(const PartingMesh& m)
{
    std::vector<PartingKernel::Triangle_3> out;
    for (const auto f : m.faces()) {
        std::vector<PartingKernel::Point_3> p;
        for (const auto v : m.vertices_around_face(m.halfedge(f))) p.push_back(m.point(v));
        out.emplace_back(p[0], p[1], p[2]);
    }
    return out;
}

/// A common point of the closed solids; each is one piece.
bool solids_meet(const PartingMesh& a, const PartingMesh& b)
{
    for (const PartingKernel::Triangle_3& s : parting_triangles(a))
        for (const PartingKernel::Triangle_3& t : parting_triangles(b))
            if (CGAL::do_intersect(s, t)) return true;
    const CGAL::Side_of_triangle_mesh<PartingMesh, PartingKernel> in_a(a), in_b(b);
    return in_a(*b.points().begin()) != CGAL::ON_UNBOUNDED_SIDE || in_b(*a.points().begin()) != CGAL::ON_UNBOUNDED_SIDE;
}

TEST(SeparatingAgainstCgal, TranslationsEndWhereSolidsPart)
{
    test::Random random(31);
    const mesh::Mesh ball = mesh::sphere(1, 1);
    int separated = 0, convex = 0;
    for (int i = 0; i < 120; ++i) {
        const mesh::Mesh a = i % 6 == 0 ? ball : test::random_solid(random, i % 3 == 0),
                         b = test::random_solid(random, i % 3 == 0);
        const query::Probe probe_a(a.vertices, a.triangles), probe_b(b.vertices, b.triangles);
        const Pose pose = i % 3 == 0 ? Pose{} : test::random_pose(random, 1);
        const query::Body body_a{nullptr, &probe_a, {}}, body_b{nullptr, &probe_b, pose};
        query::SeparatingWorkspace space(probe_a, probe_b);
        const Affine move = query::b_in_a(body_a, body_b);
        const PartingMesh exact_a = parting_mesh(a, {});
        const double sizes = norm(size(probe_a.triangles().box())) + norm(size(probe_b.triangles().box()));
        const auto meets_at = [&](Vec3d by) { return solids_meet(exact_a, parting_mesh(b, {move.linear, move.shift + by})); };
        const query::SeparatingTranslation least = query::least_separating_translation(body_a, body_b, space);
        for (int k = 0; k < 4; ++k) {
            const query::SeparatingTranslation s =
                k == 0 ? least : query::separating_translation(body_a, body_b, random.direction(), space);
            ASSERT_EQ(s.status, query::k_ok);
            EXPECT_FALSE(meets_at((s.distance + 1e-9 * sizes) * s.direction)) << i << " " << k;
            if (s.distance <= 2e-9 * sizes) continue;  // they only touch
            ++separated;
            EXPECT_LE(least.at_least, s.distance);
            if (s.exact) {
                EXPECT_TRUE(meets_at((s.at_least - 1e-9 * sizes) * s.direction)) << i << " " << k;
            }
        }
        // No direction is shorter where both are convex.
        for (int k = 0; least.exact && least.distance > 0 && k < 20; ++k) {
            ++convex;
            EXPECT_TRUE(meets_at(0.999 * least.at_least * random.direction())) << i;
        }
    }
    EXPECT_GT(separated, 200);
    EXPECT_GT(convex, 500);
}

}  // namespace
}  // namespace sqmap
