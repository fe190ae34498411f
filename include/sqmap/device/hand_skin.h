// A skinned mesh of a hand on a glove: six zones' poses in, the hand's points out, every tick.
#pragma once

#include "sqmap/device/glove.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::device {

/// WebXR's names of the joints, in the order of hand_joints; "" beyond them. Any thread.
[[nodiscard]] const char* hand_joint_name(std::size_t joint) noexcept;

/// A hand as it was bound: flat or nearly so, either side. Any unit, any frame.
struct HandMesh {
    std::vector<Vec3d> points;
    std::vector<float> weights;                        ///< area about each point
    std::vector<std::array<std::uint16_t, 4>> joints;  ///< #points, that move it: numbers of hand_joints
    std::vector<std::array<double, 4>> shares;         ///< #points, sum 1
    std::array<Vec3d, k_hand_joints> positions{};      ///< of the joints
};

/// Linear blend skinning of a HandMesh by the zones of a glove. Wrist and curls follow from how the zones lie, as though its
/// bones were those of hand_joints; what the tips then are off by, as when a force holds them back, moves the finger's bones, in
/// thirds from the knuckle on: a fingertip moves with its zone.
/// Thread safety: one thread at a time; const functions by many while nobody poses it.
class HandSkin {
public:
    /// Scaled to `length`, m, from wrist to middle fingertip; a right hand becomes a left one, which hand_joints is.
    /// Points are sorted by zone. Allocates. @pre sizes agree, joints < k_hand_joints, weights finite
    HandSkin(const HandMesh& mesh, double length);

    /// No allocation; cost: some 50 operations a point. Of poses that are not finite, points are not.
    void pose(std::span<const Pose, k_glove_zones> zones) noexcept;

    [[nodiscard]] std::span<const Vec3d> points() const noexcept { return posed_; }     ///< world
    [[nodiscard]] std::span<const float> weights() const noexcept { return weights_; }  ///< of each point
    /// The points of a zone are [first(zone), first(zone + 1)).
    [[nodiscard]] std::uint32_t first(std::size_t zone) const noexcept { return first_[zone]; }
    /// How far what a zone moves is from its pose in the flat hand, m: its points; of the palm all.
    [[nodiscard]] double reach(std::size_t zone) const noexcept { return reach_[zone]; }

private:
    double length_;
    std::vector<Vec3d> rest_, posed_;  ///< rest: hand's frame, see HandPosture
    std::vector<float> weights_;
    std::vector<std::array<std::uint16_t, 4>> joints_;
    std::vector<std::array<double, 4>> shares_;
    std::array<Vec3d, k_hand_joints> positions_{};  ///< hand's frame
    std::array<Vec3d, 5> axis_{};                   ///< about which each finger closes, hand's frame
    std::array<std::uint32_t, k_glove_zones + 1> first_{};
    std::array<double, k_glove_zones> reach_{};
};

}  // namespace sqmap::device
