// A figure made of capsules on bones, that stands and walks: the avatar for tests and measurements.
// Pure functions: any number of threads.
#pragma once

#include "sqmap/query/probe.h"

#include <span>
#include <string>
#include <vector>

namespace sqmap::sim {

/// Rest pose, world, m: y up, looking along +z, arms stretched along x, soles at y = 0.
struct BoneCapsule {
    Vec3d a, b;
    double radius_a, radius_b;
};

/// A bone of a figure.
struct Bone {
    std::string name;
    int parent = -1;                 ///< stands before it
    Vec3d joint{};                   ///< about which it turns
    std::vector<BoneCapsule> flesh;  ///< overlaps the parent's about the joint
};

/// 13 bones. height: m, of the standing figure.
/// @throw std::invalid_argument for a height that is not positive
[[nodiscard]] std::vector<Bone> capsule_human(double height);

/// How the figure moves: it stands with stretched arms, lowers them, walks on the spot.
struct Gait {
    double lower_at = 1.0;  ///< s: when the arms begin to go down
    double walk_at = 2.0;   ///< s: when the first step begins
    double ease = 1.0;      ///< s: that either change takes
    double period = 1.1;    ///< s: of two steps
    double speed = 0;       ///< m / s along +z once it walks
};

/// Pose of each bone at a time: x_world = pose x_rest. poses.size() == bones.size().
/// @pre bones came from capsule_human
void walk(std::span<const Bone> bones, const Gait& gait, double time, std::span<Pose> poses);

/// Forward kinematics: takes the turn of each bone about its own joint, in its parent's frame, to its pose in the world.
/// shift: of the root.
void pose_bones(std::span<const Bone> bones, std::span<const Mat3d> turns, Vec3d shift, std::span<Pose> poses);

}  // namespace sqmap::sim
