// The exact layer where triangles cut each other: pieces of triangles, with slivers among them, meet at a corner.
#include "sqmap/mesh/bvh.h"
#include "sqmap/query/point.h"
#include "support/bodies.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace sqmap::query {
namespace {

/// Thin boxes across each other, each turned and moved at random.
mesh::Mesh crossing_boxes(int count, test::Random& random)
{
    mesh::Mesh all;
    for (int i = 0; i < count; ++i) {
        mesh::Mesh one = test::cube_of({0.5, 0.15, 0.02});
        const Mat3d turn = test::rotation_about(random.direction(), random.between(0, 3));
        const Vec3d shift = random.in_box({-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3});
        for (Vec3d& v : one.vertices) v = turn * v + shift;
        all = i == 0 ? one : test::together(all, one);
    }
    return all;
}

TEST(ExactLayer, IsRightAroundTheCornersWherePiecesMeet)
{
    test::Random random(1);
    const mesh::Mesh boxes = mesh::canonicalized(crossing_boxes(8, random));
    const test::Parsed model(boxes);
    const model::ModelView& view = model.in_model_space();
    ASSERT_GT(view.pieces.size(), 1000u);
    const mesh::Bvh truth(model.mesh());
    int judged = 0, wrong = 0;
    for (int i = 0; i < 20000; ++i) {
        const std::size_t corner = 3 * random.below(static_cast<std::uint32_t>(view.pieces.size() / 3));
        const double reach = random.between(0, 0.1);
        const Vec3d p = cast<double>(cast<float>(cast<double>(model::vec3(view.pieces.data() + corner)) +
                                                 random.in_box({-reach, -reach, -reach}, {reach, reach, reach})));
        if (truth.closest_point(p).distance < 1e-5) continue;
        ++judged;
        const PointResult answer = query_point(view, p, {.layer = Layer::Exact});
        wrong += answer.contact != (truth.winding_number(p) > 0) ? 1 : 0;
    }
    EXPECT_GT(judged, 15000);
    EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace sqmap::query
