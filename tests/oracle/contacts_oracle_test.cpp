// Complete contacts against CGAL's exact kernel: all pairs of triangles that have a point in common, and the regions they make.
#include "sqmap/query/contacts.h"
#include "support/bodies.h"
#include "support/small_meshes.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <set>

namespace sqmap {
namespace {

using ExactKernel = CGAL::Exact_predicates_exact_constructions_kernel;

/// The triangles and edges of a mesh as the query sees them: of b moved by b_in_a.
struct ExactMesh {
    ExactMesh(const mesh::Mesh& m, const Affine* move) : mesh(m)
    {
        for (const Vec3d& v : m.vertices) {
            const Vec3d p = move != nullptr ? apply(*move, v) : v;
            points.emplace_back(p.x, p.y, p.z);
        }
    }
    [[nodiscard]] const ExactKernel::Point_3& corner(std::size_t t, std::size_t k) const
    {
        return points[mesh.triangles[t][k % 3]];
    }
    [[nodiscard]] ExactKernel::Triangle_3 triangle(std::size_t t) const { return {corner(t, 0), corner(t, 1), corner(t, 2)}; }
    [[nodiscard]] ExactKernel::Segment_3 side(std::size_t t, std::size_t k) const { return {corner(t, k), corner(t, k + 1)}; }
    /// The lower half-edge of an edge.
    [[nodiscard]] std::size_t edge(std::size_t t, std::size_t k) const
    {
        const std::uint32_t p = mesh.triangles[t][k], q = mesh.triangles[t][(k + 1) % 3];
        for (std::size_t s = 0; s < mesh.triangles.size(); ++s)
            for (std::size_t j = 0; j < 3; ++j)
                if (mesh.triangles[s][j] == q && mesh.triangles[s][(j + 1) % 3] == p) return std::min(3 * t + k, 3 * s + j);
        return 3 * t + k;
    }
    const mesh::Mesh& mesh;
    std::vector<ExactKernel::Point_3> points;
};

/// Pairs that meet, and regions of them: pairs that share where an edge meets a triangle belong together.
struct Truth {
    std::size_t pairs = 0, regions = 0;
};
Truth truth_of(const ExactMesh& a, const ExactMesh& b)
{
    std::vector<std::size_t> parent;
    const auto root = [&](std::size_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    std::map<std::tuple<int, std::size_t, std::size_t>, std::size_t> first;
    for (std::size_t t = 0; t < a.mesh.triangles.size(); ++t)
        for (std::size_t s = 0; s < b.mesh.triangles.size(); ++s) {
            const ExactKernel::Triangle_3 ta = a.triangle(t), tb = b.triangle(s);
            if (!CGAL::do_intersect(ta, tb)) continue;
            const std::size_t self = parent.size();
            parent.push_back(self);
            const auto join = [&](std::tuple<int, std::size_t, std::size_t> key) {
                parent[root(self)] = root(first.try_emplace(key, self).first->second);
            };
            for (std::size_t k = 0; k < 3; ++k) {
                if (CGAL::do_intersect(a.side(t, k), tb)) join({0, a.edge(t, k), s});
                if (CGAL::do_intersect(b.side(s, k), ta)) join({1, b.edge(s, k), t});
            }
        }
    Truth truth{parent.size(), 0};
    for (std::size_t i = 0; i < parent.size(); ++i) truth.regions += root(i) == i ? 1u : 0u;
    return truth;
}

struct Tally {
    std::size_t touching = 0, pairs = 0, regions = 0;
};

void compare(const mesh::Mesh& a, const mesh::Mesh& b, const Pose& pose, query::ContactWorkspace& workspace, Tally& tally)
{
    const query::Probe probe_a(a.vertices, a.triangles), probe_b(b.vertices, b.triangles);
    const query::Body body_a{nullptr, &probe_a, {}}, body_b{nullptr, &probe_b, pose};
    const Affine move = query::b_in_a(body_a, body_b);
    const Truth truth = truth_of(ExactMesh(a, nullptr), ExactMesh(b, &move));
    const query::ContactResult r = query::query_contacts(body_a, body_b, {}, workspace);
    EXPECT_EQ(r.meetings, truth.pairs);
    EXPECT_EQ(r.regions, truth.regions);
    std::set<std::uint32_t> named;
    for (const query::SurfaceContact& c : r.contacts) {
        named.insert(c.region);
        EXPECT_GE(c.depth, 0.f);
        EXPECT_NEAR(norm(c.normal), 1.f, 1e-5f);
    }
    EXPECT_EQ(named.size(), truth.regions) << "regions without a contact";
    tally.touching += truth.pairs > 0 ? 1u : 0u;
    tally.pairs += truth.pairs;
    tally.regions += truth.regions;
}

TEST(ContactsAgainstCgal, SolidsOnALatticeMissNoPairAndNoRegion)
{
    test::Random random(11);
    query::ContactWorkspace workspace(4096);
    Tally tally;
    for (int i = 0; i < 1200; ++i) {
        const mesh::Mesh a = test::random_solid(random, true);
        const mesh::Mesh b = i % 10 == 0 ? a : test::random_solid(random, true);
        // Quarter turns and whole shifts are exact.
        Pose pose;
        if (i % 3 == 0) pose.rotation = {{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}};
        if (i % 20 != 0)
            pose.translation = {static_cast<double>(random.below(3)) - 1, static_cast<double>(random.below(3)) - 1, 0};
        compare(a, b, pose, workspace, tally);
    }
    EXPECT_GT(tally.touching, 500u);
    EXPECT_GT(tally.pairs, 5000u);
}

TEST(ContactsAgainstCgal, SolidsAnywhereMissNoPairAndNoRegion)
{
    test::Random random(12);
    query::ContactWorkspace workspace(4096);
    Tally tally;
    for (int i = 0; i < 800; ++i)
        compare(test::random_solid(random, i % 2 == 0), test::random_solid(random, i % 4 == 0), test::random_pose(random, 2),
                workspace, tally);
    EXPECT_GT(tally.touching, 200u);
    EXPECT_GT(tally.regions, tally.touching);
}

TEST(ContactsAgainstCgal, FinerMeshesMissNoPairAndNoRegion)
{
    test::Random random(13);
    query::ContactWorkspace workspace(20000);
    Tally tally;
    const mesh::Mesh ball = mesh::sphere(1, 2);  // 320 triangles
    for (int i = 0; i < 6; ++i) compare(ball, ball, i == 0 ? Pose{} : test::random_pose(random, 1), workspace, tally);
    EXPECT_EQ(tally.touching, 6u);
}

}  // namespace
}  // namespace sqmap
