#include "sim/walker.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace sqmap::sim {
namespace {

TEST(Walker, JointsStayTogetherAndBonesRigid)
{
    const auto bones = capsule_human(1.75);
    std::vector<sqmap::Pose> poses(bones.size());
    for (double time = 0; time < 6; time += 0.13) {
        walk(bones, {}, time, poses);
        for (std::size_t b = 0; b < bones.size(); ++b) {
            const Mat3d product = poses[b].rotation * transpose(poses[b].rotation);
            for (int k = 0; k < 3; ++k) EXPECT_LT(norm(product.row[k] - Mat3d{}.row[k]), 1e-12);
            if (bones[b].parent < 0) continue;
            const sqmap::Pose& parent = poses[static_cast<std::size_t>(bones[b].parent)];
            EXPECT_LT(norm(apply(poses[b], bones[b].joint) - apply(parent, bones[b].joint)), 1e-12) << bones[b].name;
        }
    }
}

TEST(Walker, FleshOverlapsAboutEachJointWhateverTheTurn)
{
    // The joint lies inside both bones' flesh: a turn about it keeps it there.
    for (const Bone& bone : capsule_human(1.75)) {
        if (bone.parent < 0) continue;
        double deepest = 0;
        for (const BoneCapsule& c : bone.flesh) {
            const Vec3d axis = c.b - c.a;
            const double s = std::min(1.0, std::max(0.0, dot(bone.joint - c.a, axis) / std::max(norm_sq(axis), 1e-12)));
            deepest = std::max(deepest, c.radius_a + s * (c.radius_b - c.radius_a) - norm(bone.joint - c.a - s * axis));
        }
        EXPECT_GT(deepest, 0.01) << bone.name;
    }
}

TEST(Walker, StandsThenStepsLeftAndRightAlike)
{
    const auto bones = capsule_human(1.75);
    std::vector<sqmap::Pose> now(bones.size()), later(bones.size());
    walk(bones, {}, 0.5, now);
    for (const sqmap::Pose& pose : now) EXPECT_LT(norm(pose.translation), 1e-12);
    const Gait gait;
    walk(bones, gait, 5.3, now);
    walk(bones, gait, 5.3 + 0.5 * gait.period, later);
    double swing = 0;
    for (std::size_t b = 0; b < bones.size(); ++b)
        for (std::size_t m = 0; m < bones.size(); ++m) {
            if (bones[b].name.substr(0, 4) != "left" || bones[m].name != "right" + bones[b].name.substr(4)) continue;
            const Vec3d left = apply(now[b], bones[b].flesh.back().b), right = apply(later[m], bones[m].flesh.back().b);
            EXPECT_LT(norm(left - Vec3d{-right.x, right.y, right.z}), 1e-9) << bones[b].name;
            swing = std::max(swing, norm(left - bones[b].flesh.back().b));
        }
    EXPECT_GT(swing, 0.2);
}

TEST(Walker, HasTheHeightChosen)
{
    double top = 0, bottom = 1;
    for (const Bone& bone : capsule_human(1.2))
        for (const BoneCapsule& c : bone.flesh) {
            top = std::max({top, c.a.y + c.radius_a, c.b.y + c.radius_b});
            bottom = std::min({bottom, c.a.y - c.radius_a, c.b.y - c.radius_b});
        }
    EXPECT_NEAR(top - bottom, 1.2, 0.012);
    EXPECT_THROW((void)capsule_human(0), std::invalid_argument);
}

}  // namespace
}  // namespace sqmap::sim
