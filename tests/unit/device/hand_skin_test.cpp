#include "device/hand.h"

#include "support/tube_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sqmap::device {
namespace {

using sqmap::test::tube_hand;

constexpr double k_length = 0.19;

Vec3d back(const Pose& pose, const Vec3d& p) { return transpose_mul(pose.rotation, p - pose.translation); }

/// The position to which the joints take a bound point of the tubes.
Vec3d carried(const HandMesh& flat, std::size_t i, const std::array<Pose, k_hand_joints>& rest,
              const std::array<Pose, k_hand_joints>& posed)
{
    const std::size_t joint = flat.joints[i][0];
    return apply(posed[joint], back(rest[joint], flat.points[i]));
}

double farthest(std::span<const Vec3d> points, const std::vector<Vec3d>& expected)
{
    // In whatever order.
    double worst = 0;
    for (const Vec3d& e : expected) {
        double nearest = 1;
        for (const Vec3d& p : points) nearest = std::min(nearest, norm(p - e));
        worst = std::max(worst, nearest);
    }
    return worst;
}

TEST(HandSkin, FollowsTheJointsInEveryPostureOfEitherHandInAnyFrame)
{
    const HandMesh flat = tube_hand(k_length, [](const Vec3d& p) { return p; });
    const auto rest = hand_joints({}, k_length);
    const Mat3d turn{{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}};
    for (const double side : {1., -1.}) {
        HandSkin skin(tube_hand(k_length,
                                [&](const Vec3d& p) {
                                    return 1000. * (turn * Vec3d{side * p.x, p.y, p.z}) + Vec3d{3, 50, -7};
                                }),
                      k_length);
        for (const double curl : {0., 0.3, 0.9, 1.4}) {
            HandPosture posture;
            posture.wrist = {{{{0.6, 0.8, 0}, {-0.8, 0.6, 0}, {0, 0, 1}}}, {0.1, 0.2, 0.3}};
            posture.curl = {0.5 * curl, curl, 0.9 * curl, 0.8 * curl, 0.2};
            const auto joints = hand_joints(posture, k_length);
            skin.pose(glove_zones(joints));
            std::vector<Vec3d> expected;
            for (std::size_t i = 0; i < flat.points.size(); ++i) expected.push_back(carried(flat, i, rest, joints));
            EXPECT_LT(farthest(skin.points(), expected), 1e-9) << side << ' ' << curl;
        }
    }
}

TEST(HandSkin, AFingertipThatIsHeldBackTakesItsFingerAlongAndNoOther)
{
    HandSkin skin(tube_hand(k_length, [](const Vec3d& p) { return p; }), k_length);
    HandPosture posture;
    posture.curl = {0.2, 0.4, 0.4, 0.4, 0.4};
    auto zones = glove_zones(hand_joints(posture, k_length));
    skin.pose(zones);
    const std::vector<Vec3d> before(skin.points().begin(), skin.points().end());
    const Vec3d held{0.001, -0.002, 0.004};
    zones[1].translation += held;
    skin.pose(zones);
    for (std::size_t z = 0; z < k_glove_zones; ++z)
        for (std::uint32_t i = skin.first(z); i < skin.first(z + 1); ++i) {
            const Vec3d moved = skin.points()[i] - before[i];
            if (z != 1) {
                EXPECT_LT(norm(moved), 1e-12) << z;
            } else {
                EXPECT_LT(norm(moved - std::round(3 * dot(moved, held) / norm_sq(held)) / 3 * held), 1e-9) << "in thirds";
                EXPECT_GT(norm(moved), 0.3 * norm(held));
            }
        }
}

TEST(HandSkin, EveryPointBelongsToAZoneAndTheZonesToTheirFingers)
{
    const HandMesh mesh = tube_hand(k_length, [](const Vec3d& p) { return p; });
    const HandSkin skin(mesh, k_length);
    EXPECT_EQ(skin.first(0), 0u);
    EXPECT_EQ(skin.first(k_glove_zones), mesh.points.size());
    const auto joints = hand_joints({}, k_length);
    for (std::size_t z = 0; z < k_glove_zones; ++z) {
        ASSERT_LT(skin.first(z), skin.first(z + 1));
        EXPECT_GT(skin.reach(z), 0.03);
        EXPECT_LT(skin.reach(z), z < 5 ? 0.12 : 0.19);
        for (std::uint32_t i = skin.first(z); i < skin.first(z + 1) && z < 5; ++i)
            EXPECT_LT(norm(skin.points()[i] - joints[k_tip_joints[z]].translation), skin.reach(z) + 1e-12);
    }
}

}  // namespace
}  // namespace sqmap::device
