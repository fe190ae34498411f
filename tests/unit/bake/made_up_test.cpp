// Tests what a model says of a mesh that was closed: its rung, how far the surface moved, and which contacts lie on made-up
// surface.
#include "bake/bake.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/admission.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/model/parse.h"
#include "sqmap/query/point.h"
#include "sqmap/query/probe.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

namespace sqmap::bake {
namespace {

/// A ball without its top.
mesh::AdmitResult closed_ball()
{
    const mesh::Mesh ball = mesh::sphere(1, 4);
    std::vector<std::int64_t> indices;
    std::vector<std::uint32_t> offsets{0};
    for (std::uint32_t t = 0; t < ball.triangles.size(); ++t) {
        if (mesh::triangle_centroid(ball, t).z > 0.9) continue;
        for (const std::uint32_t v : ball.triangles[t]) indices.push_back(v);
        offsets.push_back(static_cast<std::uint32_t>(indices.size()));
    }
    return mesh::admit({ball.vertices, offsets, indices});
}

struct Baked {
    mesh::AdmitResult gate = closed_ball();
    std::vector<std::byte> bytes;
    model::ModelView view;

    Baked()
    {
        BakeOptions options;
        options.cured = {model::Rung::Closed, gate.made_up, *gate.deviation};
        bytes = io::serialize(bake(gate.mesh, gate.solid, options).model);
        EXPECT_EQ(model::parse(bytes, view), model::ParseStatus::Ok);
    }
};

const Baked& baked()
{
    static const Baked one;
    return one;
}

TEST(MadeUp, IsInTheFileFromClosedUp)
{
    ASSERT_EQ(baked().gate.admission, mesh::Admission::Closed);
    const model::Cure& cure = baked().view.cure;
    EXPECT_EQ(cure.rung, model::Rung::Closed);
    EXPECT_EQ(cure.from_p99, baked().gate.deviation->input_to_result.p99);
    EXPECT_EQ(cure.to_max, baked().gate.deviation->result_to_input.max);
    EXPECT_NEAR(cure.made_up_share, 0.05, 0.01);
    const BakeResult plain = bake(baked().gate.mesh, true, {});
    EXPECT_EQ(plain.model.cure.rung, model::Rung::AsItIs);
    EXPECT_TRUE(plain.model.made_up_cells.empty());
}

TEST(MadeUp, MarksContactsOfTheExactLayerByTheirTriangle)
{
    const mesh::Bvh bvh(baked().gate.mesh);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> in(-1, 1);
    int marked = 0;
    for (int i = 0; i < 4000; ++i) {
        const Vec3d p{in(random), in(random), in(random)};
        const query::PointResult result = query::query_point(baked().view, p, {.layer = query::Layer::Exact});
        if (!result.contact) continue;
        const mesh::ClosestPoint nearest = bvh.closest_point(p);
        if (norm(nearest.point - result.witness) > 1e-5) continue;  // as near elsewhere
        const bool says = (result.status & query::k_made_up) != 0, is = baked().gate.made_up[nearest.triangle] != 0;
        // Along the filling's rim triangles of both kinds are nearest.
        if (says != is) {
            EXPECT_NEAR(nearest.point.z, 0.9, 0.05);
        }
        marked += says ? 1 : 0;
    }
    EXPECT_GT(marked, 20);
}

TEST(MadeUp, MarksLayerTwoAndThreeWhereTheCellMayBeNearest)
{
    std::mt19937 random(12);
    std::uniform_real_distribution<double> in(-1, 1);
    std::vector<Vec3d> points;
    for (int i = 0; i < 4000; ++i) points.push_back({in(random), in(random), in(random)});
    for (const query::Layer layer : {query::Layer::Two, query::Layer::Three}) {
        int missed = 0, marked = 0, contacts = 0;
        for (const Vec3d& p : points) {
            const query::PointResult exact = query::query_point(baked().view, p, {.layer = query::Layer::Exact});
            const query::PointResult coarse = query::query_point(baked().view, p, {.layer = layer});
            if (!exact.contact || !coarse.contact) continue;
            ++contacts;
            marked += (coarse.status & query::k_made_up) != 0 ? 1 : 0;
            missed += (exact.status & query::k_made_up) != 0 && (coarse.status & query::k_made_up) == 0 ? 1 : 0;
        }
        EXPECT_LT(missed, contacts / 200);  // a point that the layer puts into the next cell
        EXPECT_GT(marked, 20);
        EXPECT_LT(marked, contacts / 2);
    }
}

TEST(MadeUp, MarksAProbeAsItsPoints)
{
    const mesh::Mesh small = mesh::sphere(0.5, 3);
    std::vector<Vec3d> points;
    for (const Vec3d& p : small.vertices) points.push_back(p + Vec3d{0, 0, 0.5});
    const query::Probe probe(points);
    for (const query::Layer layer : {query::Layer::Three, query::Layer::Exact}) {
        std::vector<query::Contact> contacts(points.size());
        const query::ProbeResult result =
            query::query_probe({&baked().view, nullptr, {}}, {nullptr, &probe, {}}, {.layer = layer}, contacts);
        int marked = 0;
        for (const query::Contact& c : result.written(contacts)) {
            const query::PointResult single = query::query_point(baked().view, points[c.index], {.layer = layer});
            EXPECT_EQ(c.status & query::k_made_up, single.status & query::k_made_up);
            marked += (c.status & query::k_made_up) != 0 ? 1 : 0;
        }
        EXPECT_GT(marked, 0);
    }
}

}  // namespace
}  // namespace sqmap::bake
