// Skinned meshes from glTF: the surface as it was bound, its joints, and which joint moves which vertex.
#pragma once

#include "sqmap/io/read.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sqmap::io {

struct SkinJoint {
    std::string name;
    int parent = -1;        ///< among the joints, or none; stands anywhere
    Affine local{};         ///< rest: the joint's frame in its parent's; in the scene's where there is none
    Affine inverse_bind{};  ///< bound mesh -> the joint's frame
};

/// A bound vertex goes to sum over k of weights[k] world[joints[k]] inverse_bind[joints[k]] x.
struct SkinnedSoup {
    PolygonSoup soup;                                  ///< as bound; several primitives after each other
    std::vector<std::array<std::uint16_t, 4>> joints;  ///< #positions
    std::vector<std::array<double, 4>> weights;        ///< #positions, sum 1
    std::vector<SkinJoint> skeleton;
};

struct SkinResult {
    SkinnedSoup skin;
    std::optional<ReadError> error;
};

/// The first mesh of a glTF or GLB file that has a skin, with all its triangles; four joints a vertex at most.
/// Failures: in the result, as read_mesh_file's; E_FORMAT where nothing is skinned.
[[nodiscard]] SkinResult read_skinned_file(const std::filesystem::path& path, const ReadLimits& limits = {});

}  // namespace sqmap::io
