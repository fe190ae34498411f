// A hand of 25 joints without a wearer: postures, poses of its joints, a simulated glove of five fingers and a palm, and a
// skinned mesh that a glove moves.
#pragma once

#include "sqmap/device/simulated.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::device {

/// Joints as WebXR's hand input names them: the wrist, then metacarpal, phalanges and tip of thumb (4) and of index, middle, ring
/// and little finger (5 each), from the palm outwards.
inline constexpr std::size_t k_hand_joints = 25;
/// Zones of a glove: the tips of thumb, index, middle, ring, little finger, and the palm.
inline constexpr std::size_t k_glove_zones = 6;
inline constexpr std::array<std::size_t, 5> k_tip_joints{4, 9, 14, 19, 24};

/// Angles of the fingers, radians; zero is a flat hand with the fingers together.
struct HandPosture {
    Pose wrist{};  ///< hand -> world. The hand's frame: x to the thumb's side, y along the middle finger, z out of the back
    std::array<double, 5> curl{};    ///< of each finger at its proximal joint; the joints beyond follow by 0.8 and 0.6 of it
    std::array<double, 5> spread{};  ///< of each finger at its proximal joint, towards the thumb's side
};

/// World pose of every joint, m, right-handed; the y axis lies along the bone that begins at the joint. length: m, from wrist to
/// middle fingertip. Bones are about as long as Buchholz, Armstrong and Goldstein (1992) found, as shares of the hand's length.
[[nodiscard]] std::array<Pose, k_hand_joints> hand_joints(const HandPosture& posture, double length = 0.19) noexcept;

/// Poses of a glove's zones for these joints: the tips, and the middle of the palm. Any thread.
[[nodiscard]] std::array<Pose, k_glove_zones> glove_zones(const std::array<Pose, k_hand_joints>& joints) noexcept;

/// A hand that opens and closes while it goes to and fro.
struct GloveMotion {
    Pose wrist{};            ///< in the middle of the sway
    Vec3d sway{0, 0, 0.02};  ///< m, to either side
    double sway_period = 3;  ///< s
    double curl = 0.9;       ///< rad, of the closed hand
    double curl_period = 2;  ///< s
    double length = 0.19;    ///< m, of the hand
};
/// time: s. Any thread.
[[nodiscard]] HandPosture posture_at(const GloveMotion& motion, double time) noexcept;
/// A HandScript; its context is a GloveMotion.
HandTarget glove_script(const void* motion, double time, std::size_t zone) noexcept;

/// A SimulatedDevice of six zones, held by a hand that follows the motion. @pre motion outlives it (not checked)
[[nodiscard]] std::unique_ptr<SimulatedDevice> simulated_glove(const GloveMotion& motion, MotorRecord* motors = nullptr);

/// WebXR's names of the joints, in the order of hand_joints; "" beyond them. Any thread.
[[nodiscard]] const char* hand_joint_name(std::size_t joint) noexcept;

/// A hand as it was bound: flat or nearly so, either side. Any unit, any frame.
struct HandMesh {
    std::vector<Vec3d> points;
    std::vector<float> weights;                        ///< area about each point
    std::vector<std::array<std::uint16_t, 4>> joints;  ///< #points by 4: the joints that move the point, indices into hand_joints
    std::vector<std::array<double, 4>> shares;         ///< #points by 4: weight of each of these joints, sum 1
    std::array<Vec3d, k_hand_joints> positions{};      ///< of the joints
};

/// Linear blend skinning of a HandMesh by the zones of a glove. The wrist and the curl of each finger follow from the zones'
/// poses, as though the hand had the bones of hand_joints. A force that holds a tip back leaves the tip off that pose: the
/// finger's bones take up the difference, a third each from the knuckle on, so that a fingertip moves with its zone. Thread
/// safety: one thread at a time; const functions by many while no thread poses it.
class HandSkin {
public:
    /// Scales the mesh to `length`, m, from wrist to middle fingertip, mirrors a right hand, since hand_joints is a left one, and
    /// sorts the points by zone. Allocates. @pre sizes agree, joints < k_hand_joints, weights finite
    HandSkin(const HandMesh& mesh, double length);

    /// No allocation; cost: some 50 operations a point. Poses that are not finite give points that are not finite.
    void pose(std::span<const Pose, k_glove_zones> zones) noexcept;

    [[nodiscard]] std::span<const Vec3d> points() const noexcept { return posed_; }     ///< world
    [[nodiscard]] std::span<const float> weights() const noexcept { return weights_; }  ///< of each point
    /// The points of a zone are [first(zone), first(zone + 1)).
    [[nodiscard]] std::uint32_t first(std::size_t zone) const noexcept { return first_[zone]; }
    /// The greatest distance, m, in the flat hand from a zone's pose to the points that it moves; for the palm, to all points.
    [[nodiscard]] double reach(std::size_t zone) const noexcept { return reach_[zone]; }

private:
    double length_;
    std::vector<Vec3d> rest_, posed_;  ///< rest: hand's frame, see HandPosture
    std::vector<float> weights_;
    std::vector<std::array<std::uint16_t, 4>> joints_;
    std::vector<std::array<double, 4>> shares_;
    std::array<Vec3d, k_hand_joints> positions_{};  ///< hand's frame
    std::array<Vec3d, 5> axis_{};                   ///< axis about which each finger closes, hand's frame
    std::array<std::uint32_t, k_glove_zones + 1> first_{};
    std::array<double, k_glove_zones> reach_{};
};

}  // namespace sqmap::device
