// A hand of 25 joints without a wearer: postures, poses of its joints, and a simulated glove of five fingers and a palm.
#pragma once

#include "sqmap/device/simulated.h"

#include <array>
#include <cstddef>
#include <memory>

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

/// A SimulatedDevice of six zones, held by a hand that follows the motion. @pre motion outlives it
[[nodiscard]] std::unique_ptr<SimulatedDevice> simulated_glove(const GloveMotion& motion, MotorRecord* motors = nullptr);

}  // namespace sqmap::device
