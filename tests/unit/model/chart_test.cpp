#include "model/central_map.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::model {
namespace {

TEST(Chart, ToChartAndFaceDirectionAreInverse)
{
    test::Random random(1);
    for (int i = 0; i < 5000; ++i) {
        const Vec3f x = cast<float>(random.between(0.01, 3) * random.direction());
        const ChartPoint q = to_chart(x);
        EXPECT_LE(std::abs(q.s), 1.f);
        EXPECT_LE(std::abs(q.t), 1.f);
        const Vec3f back = (1.f / q.w) * face_direction(q.face, q.s, q.t);
        EXPECT_LE(norm(back - x), 1e-6f * norm(x));
    }
    // The chart's own axes, diagonals and centre.
    for (int face = 0; face < k_faces; ++face)
        for (const float s : {-1.f, -0.5f, 0.f, 0.5f, 1.f}) {
            const ChartPoint q = to_chart(2.f * face_direction(face, s, 0.f));
            EXPECT_EQ(q.w, 0.5f);
            EXPECT_EQ((1.f / q.w) * face_direction(q.face, q.s, q.t), 2.f * face_direction(face, s, 0.f));
        }
    EXPECT_TRUE(std::isfinite(to_chart({}).w));
}

TEST(Chart, DeviationCodesGrow)
{
    for (std::uint32_t code = 0; code + 1 < 256; ++code)
        EXPECT_LT(deviation_of_code(code, 1e-4f), deviation_of_code(code + 1, 1e-4f));
}

TEST(Chart, APlaneIsReadBackWithoutError)
{
    // n . x = 1 on a face is w = sign n_m + n_u s + n_v t: the bilinear form of its corners is the plane itself.
    test::Random random(2);
    for (int i = 0; i < 500; ++i) {
        const int face = i % 6, m = face_axis(face);
        Vec3d n = random.in_box({-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3});
        n[m] = static_cast<double>(face_sign(face)) * random.between(0.8, 2);
        const auto w = [&](float s, float t) { return static_cast<float>(dot(n, cast<double>(face_direction(face, s, t)))); };
        const float s0 = -0.5f, t0 = 0.25f, size = 0.25f;
        const float corner[4] = {w(s0, t0), w(s0 + size, t0), w(s0, t0 + size), w(s0 + size, t0 + size)};
        const float u = static_cast<float>(random.between(0, 1)), v = static_cast<float>(random.between(0, 1));
        const SheetValue value = bilinear_value(corner, u, v, size);
        EXPECT_NEAR(value.w, w(s0 + u * size, t0 + v * size), 1e-6);
        EXPECT_NEAR(value.ws, n[(m + 1) % 3], 5e-6);
        EXPECT_NEAR(value.wt, n[(m + 2) % 3], 5e-6);
    }
}

}  // namespace
}  // namespace sqmap::model
