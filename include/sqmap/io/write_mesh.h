// Writing triangle meshes: still ones as OBJ or OFF text, still and moving ones as glTF 2.0 in one binary file (GLB).
// Any number of threads, on files of their own.
#pragma once

#include "sqmap/math/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::io {

/// Writes a mesh; the ending of the path, .obj or .off, chooses the format. Coordinates keep every bit (17 digits).
/// The file appears whole or not at all: it is written beside its place and renamed.
/// @throw std::invalid_argument for another ending
/// @throw std::runtime_error when the file cannot be written
void write_mesh(const std::filesystem::path& path, std::span<const Vec3d> vertices,
                std::span<const std::array<std::uint32_t, 3>> triangles);

/// A texture of lengths along a surface's inward normal, in the extras of its material: "displacementTexture" with an index and
/// a scale. Grey times scale (below 0: inwards) metres along the normal lead to another surface where alpha is not zero.
struct DisplacementTexture {
    std::string name;
    std::string png;   ///< bytes of the file
    double scale = 0;  ///< m
};

/// Pose of a body at a time: x_world = rotation x + translation.
struct RigidKey {
    Mat3d rotation{};  ///< proper
    Vec3d translation{};
};

/// A mesh that stands still, moves as one, or deforms. Metres, y up, as glTF has it.
struct MovingMesh {
    std::string name;
    std::vector<Vec3d> positions;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::array<float, 3> colour{0.8f, 0.8f, 0.8f};  ///< linear light
    float opacity = 1;
    bool two_sided = false;
    bool flat = false;                                        ///< without normals: viewers shade each triangle by its own
    std::vector<Vec3d> normals{};                             ///< empty (the means of the triangles' normals), or one a position
    std::vector<std::array<float, 2>> texture_coordinates{};  ///< empty, or one a position
    std::optional<DisplacementTexture> displacement{};        ///< needs texture coordinates
    std::string group{};           ///< name of the node under which the mesh's node hangs; empty: the scene itself
    std::string extras{};          ///< JSON text that the node carries; empty: none
    std::vector<double> times{};   ///< s, ascending: of the keys or shapes below
    std::vector<RigidKey> keys{};  ///< empty, or one a time
    std::vector<std::vector<Vec3d>>
        shapes{};  ///< empty, or one a time, each of positions.size() positions: morph targets, blended in between
};

/// One node a mesh, one a group, and one animation, "motion", of all meshes that move.
/// @throw std::invalid_argument for sizes that do not match, times that do not ascend, numbers that are not finite, no mesh
[[nodiscard]] std::vector<std::byte> glb_bytes(std::span<const MovingMesh> meshes);
/// Writes the same to a file, which appears whole or not at all. @throw std::invalid_argument as glb_bytes does
/// @throw ModelFileError when the file cannot be written
void write_glb(const std::filesystem::path& path, std::span<const MovingMesh> meshes);

}  // namespace sqmap::io
