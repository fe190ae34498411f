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
    std::vector<std::array<std::uint16_t, 4>> joints;  ///< #points by 4: the joints that move the point, indices into hand_joints
    std::vector<std::array<double, 4>> shares;         ///< #points by 4: weight of each of these joints, sum 1
    std::array<Vec3d, k_hand_joints> positions{};      ///< of the joints
};

/// Linear blend skinning of a HandMesh by the zones of a glove. The wrist and the curl of each finger follow from the zones'
/// poses, as though the hand had the bones of hand_joints. A force that holds a tip back leaves the tip off that pose: the
/// finger's bones take up the difference, a third each from the knuckle on, so that a fingertip moves with its zone. Thread
/// safety: one thread at a time; const functions by many while nobody poses it.
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
