// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sqmap/math/rotation.h"

namespace sqmap {
namespace {

constexpr double k_pi = std::numbers::pi;
const Vec3d k_axis = normalized(Vec3d{0.3, -0.9, 0.5});

void expect_near(Vec3d a, Vec3d b, double tolerance)
{
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance);
}

TEST(Rotation, AQuarterTurnAboutZTakesXToY)
{
    const Mat3d turn = rotation_by({0, 0, k_pi / 2});
    expect_near(turn * Vec3d{1, 0, 0}, {0, 1, 0}, 1e-15);
    expect_near(turn * Vec3d{0, 0, 2}, {0, 0, 2}, 1e-15);
}

TEST(Rotation, VectorIsTheInverseFromNothingToHalfATurn)
{
    for (const double angle : {0.0, 1e-12, 1e-9, 1e-7, 1e-3, 1.0, 3.0, k_pi - 1e-3, k_pi - 1e-5}) {
        SCOPED_TRACE(angle);
        expect_near(rotation_vector(rotation_by(angle * k_axis)), angle * k_axis,
                    1e-10);  // near half a turn the sine loses digits
    }
}

TEST(Rotation, HalfATurnIsFoundUpToItsSign)
{
    for (const double angle : {k_pi, k_pi - 1e-8, k_pi - 1e-7}) {
        SCOPED_TRACE(angle);
        Vec3d found = rotation_vector(rotation_by(angle * k_axis));
        if (dot(found, k_axis) < 0) found = -1.0 * found;
        expect_near(found, k_pi * k_axis, 1e-6);
    }
}

TEST(Rotation, PreservesLengthsAndHandedness)
{
    const Mat3d turn = rotation_by(2.0 * k_axis);
    const Vec3d x = turn * Vec3d{1, 0, 0}, y = turn * Vec3d{0, 1, 0}, z = turn * Vec3d{0, 0, 1};
    EXPECT_NEAR(norm(x), 1, 1e-15);
    expect_near(cross(x, y), z, 1e-15);
}

TEST(Rotation, OrthonormalUndoesADrift)
{
    Mat3d turn = rotation_by(k_axis);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) turn.row[i][k] *= 1 + 1e-6 * (i + 2 * k);
    const Mat3d mended = orthonormal(turn);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(norm(mended.row[i]), 1, 1e-15);
    EXPECT_NEAR(dot(mended.row[0], mended.row[1]), 0, 1e-15);
    expect_near(cross(mended.row[0], mended.row[1]), mended.row[2], 1e-15);
    for (int i = 0; i < 3; ++i) expect_near(mended.row[i], turn.row[i], 2e-5);
}

}  // namespace
}  // namespace sqmap
