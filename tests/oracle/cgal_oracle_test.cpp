// The exact layer, and the oracle that everything else is measured with, against CGAL: side by exact predicates,
// distance by its own tree.
#include "bake/parts/part.h"
#include "mesh/convex_hull.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/mesh/wrap.h"
#include "sqmap/query/point.h"
#include "support/baked_shapes.h"
#include "support/parsed.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace sqmap {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Primitive = CGAL::AABB_face_graph_triangle_primitive<SurfaceMesh>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

class Oracle {
public:
    explicit Oracle(const mesh::Mesh& mesh)
        : mesh_(converted(mesh)), tree_(faces(mesh_).first, faces(mesh_).second, mesh_), side_(tree_)
    {
        tree_.accelerate_distance_queries();
    }
    bool meets(const std::array<Vec3d, 3>& t) const
    {
        const auto point = [](Vec3d p) { return Kernel::Point_3(p.x, p.y, p.z); };
        // A triangle without area is no triangle to CGAL: its longest side and its corners hold all of it.
        const Kernel::Triangle_3 triangle(point(t[0]), point(t[1]), point(t[2]));
        if (!triangle.is_degenerate()) return tree_.do_intersect(triangle);
        for (std::size_t k = 0; k < 3; ++k)
            if (t[k] != t[(k + 1) % 3] && tree_.do_intersect(Kernel::Segment_3(point(t[k]), point(t[(k + 1) % 3])))) return true;
        return false;
    }
    bool inside(Vec3d p) const { return side_({p.x, p.y, p.z}) == CGAL::ON_BOUNDED_SIDE; }
    double distance(Vec3d p) const { return std::sqrt(tree_.squared_distance({p.x, p.y, p.z})); }

private:
    static SurfaceMesh converted(const mesh::Mesh& mesh)
    {
        SurfaceMesh out;
        for (const Vec3d& v : mesh.vertices) out.add_vertex({v.x, v.y, v.z});
        using Index = SurfaceMesh::Vertex_index;
        for (const mesh::Triangle& t : mesh.triangles)
            if (out.add_face(Index(t[0]), Index(t[1]), Index(t[2])) == SurfaceMesh::null_face())
                throw std::logic_error("not manifold");
        return out;
    }

    SurfaceMesh mesh_;
    Tree tree_;
    CGAL::Side_of_triangle_mesh<SurfaceMesh, Kernel> side_;
};

std::vector<Vec3f> points_about(const mesh::Mesh& mesh, double r_max, std::size_t count)
{
    test::Random random(9);
    std::vector<Vec3f> points;
    Vec3d lo = mesh.vertices.front(), hi = lo;
    for (const Vec3d& v : mesh.vertices)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], v[k]);
            hi[k] = std::max(hi[k], v[k]);
        }
    while (points.size() < count) {
        const mesh::Triangle& t = mesh.triangles[random.below(mesh.triangles.size())];
        const Vec3d c = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
        const double reach = random.between(0, 1);
        points.push_back(cast<float>(c + 0.04 * r_max * reach * reach * random.direction()));
        if (points.size() % 4 == 3) points.push_back(cast<float>(random.in_box(lo, hi)));
    }
    return points;
}

void compare(const std::string& name, const mesh::Mesh& input)
{
    const test::Baked b = test::baked(input);
    const model::ModelView view = b.in_model_space();
    const double r_max = view.header.r_max;
    const Oracle oracle(b.mesh);
    const mesh::Solid solid(b.mesh);
    std::vector<double> depth_error;
    std::size_t wrong = 0, solid_wrong = 0, judged = 0;
    for (const Vec3f& p : points_about(b.mesh, r_max, 4000)) {
        const Vec3d q = cast<double>(p);
        const double distance = oracle.distance(q);
        EXPECT_NEAR(solid.closest_boundary(q).distance, distance, 1e-9 * r_max) << name;
        if (distance <= 1e-5 * r_max) continue;
        const bool inside = oracle.inside(q);
        const query::PointResult c = query::query_point(view, q, {.layer = query::Layer::Exact});
        ++judged;
        wrong += c.contact != inside ? 1u : 0u;
        solid_wrong += solid.inside(q) != inside ? 1u : 0u;
        if (c.contact && inside) depth_error.push_back(std::abs(c.depth - distance) / r_max);
    }
    EXPECT_EQ(wrong, 0u) << name << ": exact verdicts wrong of " << judged;
    EXPECT_EQ(solid_wrong, 0u) << name << ": winding numbers wrong of " << judged;
    ASSERT_GT(depth_error.size(), 500u) << name;
    std::sort(depth_error.begin(), depth_error.end());
    EXPECT_LE(depth_error[depth_error.size() / 2], 1e-5) << name << ": median depth error";
    EXPECT_LE(depth_error[depth_error.size() * 95 / 100], 5e-4) << name << ": p95 of the depth error";
}

TEST(AgainstCgal, TheExactLayerOnGeneratedShapes)
{
    for (const test::Shape& shape : test::small_shapes()) compare(shape.name, shape.mesh);
}

using Exact = CGAL::Exact_predicates_exact_constructions_kernel;

Exact::FT exact_dot(const HalfSpacef& side, Vec3d p)
{
    const auto number = [](auto v) { return Exact::FT(static_cast<double>(v)); };
    return number(side.normal.x) * number(p.x) + number(side.normal.y) * number(p.y) + number(side.normal.z) * number(p.z);
}

/// Each part's surface and the caps that close it, which hold its solid, lie within the sides as the file has them: in exact
/// arithmetic, and the float evaluation of the vertices says so too.
void expect_held(const std::string& name, const mesh::Mesh& input)
{
    const test::Parsed parsed(input);
    const model::ModelView& m = parsed.view();
    ASSERT_EQ(m.polytope_ends.size(), m.parts.size()) << name;
    decompose::Partition partition;
    partition.part_count = static_cast<std::uint32_t>(m.parts.size());
    for (std::size_t t = 0; t < m.triangle_part.size(); ++t) partition.part_of_triangle.push_back(model::part_of_triangle(m, t));
    const std::vector<bake::Patch> patches = bake::patches_of(parsed.mesh(), partition);
    std::size_t judged = 0;
    for (std::size_t part = 0; part < patches.size(); ++part)
        for (const Vec3d& p : bake::corners_of(parsed.mesh(), patches[part]))
            for (const HalfSpacef& side : model::polytope_of(m, part)) {
                ASSERT_LE(exact_dot(side, p), Exact::FT(static_cast<double>(side.offset))) << name << ", part " << part;
                ++judged;
                const Vec3f q = cast<float>(p);
                ASSERT_TRUE(cast<double>(q) != p || dot(side.normal, q) <= side.offset) << name;
            }
    EXPECT_GT(judged, 200u) << name;
}

TEST(AgainstCgal, PolytopesHoldTheirPartsInExactArithmetic)
{
    for (const test::Shape& shape : test::small_shapes()) expect_held(shape.name, shape.mesh);
    if (const auto mesh = test::shared_mesh_too("fandisk_8000.obj")) expect_held("fandisk", *mesh);
}

TEST(AgainstCgal, PolytopesOfAnimalsHoldTheirPartsInExactArithmetic)
{
    for (const char* name : {"elephant_10272.obj", "bull_7154.obj"})
        if (const auto mesh = test::shared_mesh_too(name)) expect_held(name, *mesh);
}

TEST(AgainstCgal, ConvexHullsAreTheSame)
{
    for (const test::Shape& shape : test::small_shapes()) {
        std::vector<Exact::Point_3> points;
        for (const Vec3d& v : shape.mesh.vertices) points.emplace_back(v.x, v.y, v.z);
        CGAL::Surface_mesh<Exact::Point_3> theirs;
        CGAL::convex_hull_3(points.begin(), points.end(), theirs);
        const mesh::Mesh ours = mesh::convex_hull(shape.mesh.vertices);
        // Their corners are ours; of ours, those in the middle of a flat facet may be none of theirs.
        for (const auto v : theirs.vertices()) {
            const auto& p = theirs.point(v);
            const Vec3d q{CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z())};
            EXPECT_NE(std::find(ours.vertices.begin(), ours.vertices.end(), q), ours.vertices.end()) << shape.name;
        }
        Exact::FT our_six = 0, their_six = 0;
        const auto add = [](Exact::FT& six, const auto& a, const auto& b, const auto& c) {
            six += CGAL::determinant(a - CGAL::ORIGIN, b - CGAL::ORIGIN, c - CGAL::ORIGIN);
        };
        for (const mesh::Triangle& t : ours.triangles) {
            const auto at = [&](std::uint32_t v) {
                return Exact::Point_3(ours.vertices[v].x, ours.vertices[v].y, ours.vertices[v].z);
            };
            add(our_six, at(t[0]), at(t[1]), at(t[2]));
        }
        for (const auto f : theirs.faces()) {
            std::vector<Exact::Point_3> corners;
            for (const auto v : vertices_around_face(theirs.halfedge(f), theirs)) corners.push_back(theirs.point(v));
            for (std::size_t i = 2; i < corners.size(); ++i) add(their_six, corners[0], corners[i - 1], corners[i]);
        }
        EXPECT_EQ(our_six, their_six) << shape.name;
    }
}

/// Every triangle of the soup lies within its outer solid: its corner is inside and it meets no face, by exact predicates.
void expect_enclosed(const std::string& name, const mesh::Mesh& soup)
{
    const mesh::OuterResult outer = mesh::outer_solid(soup.vertices, soup.triangles, {.tolerance = 0.004});
    ASSERT_FALSE(outer.mesh.triangles.empty()) << name;
    const Oracle oracle(outer.mesh);
    std::size_t outside = 0, cut = 0;
    for (const mesh::Triangle& t : soup.triangles) {
        const std::array<Vec3d, 3> corners{soup.vertices[t[0]], soup.vertices[t[1]], soup.vertices[t[2]]};
        outside += oracle.inside(corners[0]) ? 0u : 1u;
        cut += oracle.meets(corners) ? 1u : 0u;
    }
    EXPECT_EQ(outside, 0u) << name << " of " << soup.triangles.size();
    EXPECT_EQ(cut, 0u) << name << " of " << soup.triangles.size();
}

/// Triangles in a ball, in no order, some of them needles, some without area.
mesh::Mesh shards(std::size_t count, std::uint64_t seed)
{
    test::Random random(seed);
    mesh::Mesh soup;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3d at = std::cbrt(random.between(0, 1)) * random.direction();
        const double size = random.between(0.001, 0.3);
        const Vec3d side = size * random.direction();
        const Vec3d third = i % 7 == 0 ? random.between(0, 2) * side : (i % 5 == 0 ? 1e-9 : size) * random.direction();
        const auto first = static_cast<std::uint32_t>(soup.vertices.size());
        for (const Vec3d& p : {at, at + side, at + third}) soup.vertices.push_back(p);
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    return soup;
}

TEST(AgainstCgal, OuterSolidsHoldTheirSoup)
{
    for (const std::size_t count : {1u, 3u, 40u}) expect_enclosed(std::to_string(count) + " shards", shards(count, 11 + count));
    const auto shapes = test::small_shapes();
    for (const test::Shape& shape : std::span(shapes).first(2)) {
        mesh::Mesh soup = shape.mesh;
        soup.triangles.resize(soup.triangles.size() / 2);
        expect_enclosed("half of " + std::string(shape.name), soup);
    }
}

class SharedMesh : public testing::TestWithParam<const char*> {};

TEST_P(SharedMesh, ExactLayer)
{
    const auto mesh = test::shared_mesh(std::string(GetParam()) + ".obj");
    if (!mesh) GTEST_SKIP() << "no " << GetParam() << ".obj in " << test::shared_folder();
    const auto crossed = mesh::find_self_intersections(*mesh).crossed;
    if (std::find(crossed.begin(), crossed.end(), 1) != crossed.end())
        GTEST_SKIP() << "what stands in for " << GetParam() << " crosses itself: CGAL counts crossings, the solid is where the "
                     << "winding number is positive";
    compare(GetParam(), *mesh);
}

INSTANTIATE_TEST_SUITE_P(AgainstCgal, SharedMesh, testing::Values("elephant_10272", "knot_6400", "fandisk_8000"),
                         [](const auto& mesh) { return std::string(mesh.param); });

}  // namespace
}  // namespace sqmap
