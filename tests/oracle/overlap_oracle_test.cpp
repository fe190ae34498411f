// Volumes of overlap against CGAL's corefinement in its exact kernel.
#include "sqmap/query/overlap.h"
#include "support/bodies.h"
#include "support/small_meshes.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Surface_mesh.h>

#include <gtest/gtest.h>

namespace sqmap {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace PMP = CGAL::Polygon_mesh_processing;

SurfaceMesh exact_mesh(const mesh::Mesh& mesh, const Affine* move)
{
    SurfaceMesh out;
    for (const Vec3d& v : mesh.vertices) {
        const Vec3d p = move != nullptr ? apply(*move, v) : v;
        out.add_vertex({p.x, p.y, p.z});
    }
    using Index = SurfaceMesh::Vertex_index;
    for (const mesh::Triangle& t : mesh.triangles) out.add_face(Index(t[0]), Index(t[1]), Index(t[2]));
    return out;
}

TEST(OverlapAgainstCgal, VolumesAreThoseOfTheCorefinement)
{
    test::Random random(21);
    const mesh::Mesh ball = mesh::sphere(1, 2), torus = test::small_torus();
    int overlapping = 0;
    for (int i = 0; i < 200; ++i) {
        const mesh::Mesh a = i % 10 == 0 ? ball : i % 10 == 1 ? torus : test::random_solid(random, i % 4 == 0);
        const mesh::Mesh b = i % 10 == 0 ? torus : i % 10 == 1 ? ball : test::random_solid(random, i % 4 == 0);
        // On the lattice corners and faces coincide.
        const Pose pose = i % 4 == 0 && i % 10 > 1 ? Pose{} : test::random_pose(random, 1);
        const query::Probe probe_a(a.vertices, a.triangles), probe_b(b.vertices, b.triangles);
        const query::Body body_a{nullptr, &probe_a, {}}, body_b{nullptr, &probe_b, pose};
        query::OverlapWorkspace workspace(probe_a, probe_b);
        const query::Overlap found = query::overlap(body_a, body_b, workspace);
        EXPECT_EQ(found.status, query::k_ok);

        const Affine move = query::b_in_a(body_a, body_b);
        SurfaceMesh exact_a = exact_mesh(a, nullptr), exact_b = exact_mesh(b, &move), both;
        const double smaller = std::min(CGAL::to_double(PMP::volume(exact_a)), CGAL::to_double(PMP::volume(exact_b)));
        if (!PMP::corefine_and_compute_intersection(exact_a, exact_b, both)) continue;  // not manifold: touching corners
        const double volume = both.is_empty() ? 0 : CGAL::to_double(PMP::volume(both));
        EXPECT_NEAR(found.volume, volume, 1e-9 * smaller) << i;
        overlapping += volume > 0 ? 1 : 0;
    }
    EXPECT_GT(overlapping, 100);
}

}  // namespace
}  // namespace sqmap
