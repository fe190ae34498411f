// Skinned meshes from glTF: the surface as it was bound, its joints, which joint moves which vertex, and how joints move.
// Any number of threads, on files of their own.
#pragma once

#include "sqmap/io/read.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::io {

/// Translation, rotation (unit quaternion x, y, z, w) and scale of a joint's own node, in this order from the left.
struct JointPose {
    Vec3d translation{};
    std::array<double, 4> rotation{0, 0, 0, 1};
    Vec3d scale{1, 1, 1};
};

/// A joint of a skeleton.
struct SkinJoint {
    std::string name;
    int parent = -1;        ///< among the joints, or none; stands anywhere
    Affine local{};         ///< rest: the joint's frame in its parent's; in the scene's for a root
    Affine inverse_bind{};  ///< bound mesh -> the joint's frame
    Affine above{};         ///< of the nodes between the joint above and this one: local = above * rest
    JointPose rest{};
    bool has_matrix = false;  ///< instead of rest: such a node is not animated
};

/// One channel of an animation.
struct JointTrack {
    /// The part of a joint's transform that a channel moves.
    enum class Path : std::uint8_t { Translation, Rotation, Scale };
    /// How values between its keys are found.
    enum class Between : std::uint8_t { Step, Linear, Cubic };
    std::uint32_t joint = 0;
    Path path = Path::Translation;
    Between between = Between::Linear;
    std::vector<double> times;                  ///< s, ascending, at least one
    std::vector<std::array<double, 4>> values;  ///< one a time; Cubic: tangent in, value, tangent out
};

/// Channels that play together.
struct SkinAnimation {
    std::string name;
    std::vector<JointTrack> tracks;
    double duration = 0;      ///< s: the last key's time
    std::size_t ignored = 0;  ///< channels of nodes that are no joints, and of morph targets
};

/// A bound vertex goes to sum over k of weights[k] world[joints[k]] inverse_bind[joints[k]] x.
struct SkinnedSoup {
    PolygonSoup soup;                                  ///< as bound; several primitives after each other
    std::vector<std::array<std::uint16_t, 4>> joints;  ///< #positions
    std::vector<std::array<double, 4>> weights;        ///< #positions, sum 1
    std::vector<SkinJoint> skeleton;                   ///< no joint is above itself
    std::vector<SkinAnimation> animations;
};

/// A skinned mesh, or why it is not read.
struct SkinResult {
    SkinnedSoup skin;
    std::optional<ReadError> error;
};

/// The first mesh of a glTF or GLB file that has a skin, with all its triangles; four joints a vertex at most.
/// Failures: in the result, as read_mesh_file's; E_FORMAT where nothing is skinned.
[[nodiscard]] SkinResult read_skinned_file(const std::filesystem::path& path, const ReadLimits& limits = {});

/// The pose of each joint at rest, as the file has it.
[[nodiscard]] std::vector<JointPose> rest_poses(const SkinnedSoup& skin);
/// The pose of each joint at a time of an animation, s; held before its first key and after its last.
[[nodiscard]] std::vector<JointPose> poses_at(const SkinnedSoup& skin, const SkinAnimation& animation, double time);
/// From a to b, share in [0, 1]: rotations about one axis, the short way. @pre as many of each
[[nodiscard]] std::vector<JointPose> blended(std::span<const JointPose> a, std::span<const JointPose> b, double share);
/// Bound mesh -> posed, of each joint. @pre poses.size() == skeleton.size()
[[nodiscard]] std::vector<Affine> joint_maps(const SkinnedSoup& skin, std::span<const JointPose> poses);

}  // namespace sqmap::io
