#include "device/hand.h"

#include "sqmap/device/servo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

namespace sqmap::device {
namespace {

constexpr double k_hand_length = 0.19;

bool is_rotation(const Mat3d& m)
{
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            if (std::fabs(dot(m.row[i], m.row[k]) - (i == k)) > 1e-9) return false;
    return std::fabs(dot(cross(m.row[0], m.row[1]), m.row[2]) - 1) < 1e-9;
}

TEST(Glove, AFlatHandIsFlatAndAsLongAsItSays)
{
    const auto joints = hand_joints({}, k_hand_length);
    for (std::size_t j = 5; j < joints.size(); ++j) EXPECT_EQ(joints[j].translation.z, 0) << j;
    EXPECT_NEAR(joints[14].translation.y, k_hand_length, 1e-9) << "to the tip of the middle finger";
    for (const std::size_t tip : {4u, 9u, 19u, 24u}) EXPECT_LT(joints[tip].translation.y, k_hand_length);
    EXPECT_GT(joints[9].translation.x, joints[24].translation.x) << "thumb's side";
}

TEST(Glove, BonesKeepTheirLengthsAndLieAlongTheirJointsInEveryPosture)
{
    const auto flat = hand_joints({});
    for (int i = 0; i < 50; ++i) {
        const HandPosture posture = posture_at({.curl = 1.5, .length = k_hand_length}, 0.1 * i);
        const auto joints = hand_joints(posture);
        for (std::size_t j = 1; j < joints.size(); ++j) {
            ASSERT_TRUE(is_rotation(joints[j].rotation));
            if (j == 1 || j == 5 || j == 10 || j == 15 || j == 20) continue;  // the first joint of a finger: no bone before it
            const Vec3d bone = joints[j].translation - joints[j - 1].translation;
            EXPECT_NEAR(norm(bone), norm(flat[j].translation - flat[j - 1].translation), 1e-12);
            EXPECT_NEAR(dot(bone, joints[j - 1].rotation * Vec3d{0, 1, 0}), norm(bone), 1e-12);
        }
    }
}

TEST(Glove, ACurledFingerPointsIntoThePalm)
{
    HandPosture posture;
    posture.curl[1] = 3.14159265358979 / 2;
    const auto joints = hand_joints(posture);
    const Vec3d proximal = joints[7].translation - joints[6].translation;
    EXPECT_NEAR(proximal.z, -norm(proximal), 1e-9);
    EXPECT_EQ(joints[14].translation, hand_joints({})[14].translation) << "the others stay";
}

TEST(Glove, TheScriptMovesAsItsTwistSays)
{
    const GloveMotion motion;
    for (std::size_t z = 0; z < k_glove_zones; ++z)
        for (double t = 0.05; t < 2; t += 0.11) {
            const HandTarget a = glove_script(&motion, t - 1e-5, z), b = glove_script(&motion, t + 1e-5, z),
                             now = glove_script(&motion, t, z);
            EXPECT_LT(norm((b.pose.translation - a.pose.translation) / 2e-5 - now.twist.linear), 1e-3);
        }
}

TEST(Glove, ItIsADeviceOfSixZonesThatFollowsTheHand)
{
    const GloveMotion motion;
    const auto glove = simulated_glove(motion);
    EXPECT_EQ(glove->capabilities().zones, 6u);
    Sample sample;
    double far = 0;
    for (int i = 0; i < 100; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        ASSERT_TRUE(glove->read(sample));
        glove->write({});
        // A tip is a few millimetres behind where the hand wants it: somewhere on its way, within the hand's reach.
        for (std::size_t z = 0; z < 6; ++z) far = std::max(far, norm(sample.poses[z].translation));
    }
    EXPECT_LT(far, 0.25);
    EXPECT_GT(far, 0.1);
}

}  // namespace
}  // namespace sqmap::device
