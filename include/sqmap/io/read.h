// Mesh files to polygon soups. Every size is checked against the bytes that are there before anything is allocated.
// Any number of threads, on files of their own.
#pragma once

#include "sqmap/math/vec.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::io {

/// Polygons as read: nothing is promised about indices, coordinates or topology.
struct PolygonSoup {
    std::vector<Vec3d> positions;
    std::vector<std::uint32_t> polygon_offsets{0};  ///< #polygons + 1: polygon i is indices[offsets[i] .. offsets[i+1])
    std::vector<std::int64_t> indices;              ///< zero-based, already resolved when the file counts from the end
};

/// Limits of a reader.
struct ReadLimits {
    std::uint64_t max_bytes = std::uint64_t{2} << 30;  ///< size of the file
    std::uint64_t max_faces = 20'000'000;              ///< polygons in it, instances counted
    std::uint32_t max_seconds = 60;                    ///< CPU time of a program that converts it; three times that by the clock
};

/// Mesh files that are read.
enum class MeshFormat { Off, Obj, Stl, Ply, Gltf, Glb, Dae, ThreeMf, Fbx };

/// "OFF", "OBJ", "STL", "PLY", "glTF", "GLB", "DAE", "3MF" or "FBX".
[[nodiscard]] const char* format_name(MeshFormat format);

/// A limit that a file is beyond and that a caller may raise.
enum class Raisable : std::uint8_t { None, MaxBytes, MaxFaces };

/// The words of every door for a path at which there is no file, and the cure.
inline constexpr const char *k_no_file = "no such file", *k_no_file_cure = "check the path";

/// Why a file is not read.
struct ReadError {
    std::string code;  ///< E_FILE, E_FORMAT, E_TRUNCATED or E_LIMIT
    std::string
        element;  ///< where, in the file's own terms: "line 12", "byte 84", "accessor 3", "header"; "assimp"; the path of E_FILE
    std::string message;  ///< the finding and the expectation
    std::string cure;     ///< the user's remedy
    Raisable limit{};     ///< raising this limit of ReadLimits helps, too
};

/// Contents of a mesh file, or the reason why it is not read.
struct ReadResult {
    PolygonSoup soup;                  ///< empty after an error
    std::optional<MeshFormat> format;  ///< as recognised, also after most errors
    std::optional<ReadError> error;
};

/// Reads a mesh file: OFF, OBJ, STL (text and binary), PLY (text and binary of both byte orders), glTF and GLB; DAE, 3MF and FBX
/// where the program assimp is on PATH (Debian: assimp-utils), which then runs in a process with limits: DAE comes out in metres
/// with y up, the others in units and axes of their own.
/// The name's extension names the format and the content must agree; without a known one the content decides.
/// A byte-order mark of UTF-8 and blank lines before the first are passed over. Only geometry is read. PLY: faces and triangle
/// strips; values of a line beyond its header's properties are passed over. GLB: chunks need no padding. glTF: triangles
/// of the default scene, each node's transform applied (a skinned mesh as bound). Indices and coordinates are passed on as they
/// are, out of range or not finite: judging them is the work of mesh::admit. Failures: in the result, never thrown. E_FILE: there
/// is none that can be read; E_FORMAT: not such a file; E_TRUNCATED: it ends too early, or declares more than its bytes can hold;
/// E_LIMIT: above the limits. Memory: below 64 MB
/// + 64 times the file's size. Cost: linear.
[[nodiscard]] ReadResult read_mesh_file(const std::filesystem::path& path, const ReadLimits& limits = {});

/// The same on bytes in memory; buffers beside a glTF file are out of reach. name: the file's, whose extension has to name one of
/// these formats.
[[nodiscard]] ReadResult read_mesh_bytes(std::span<const std::byte> bytes, const std::filesystem::path& name,
                                         const ReadLimits& limits = {});
/// The same with the format given.
[[nodiscard]] ReadResult read_mesh_bytes(std::span<const std::byte> bytes, MeshFormat format, const ReadLimits& limits = {});

/// The files that a glTF file names as its buffers and that are there, in its order; read_mesh_file reads no others. Empty for
/// bytes that are no glTF file: reading says why. folder: the file's own.
[[nodiscard]] std::vector<std::filesystem::path> buffers_beside(std::span<const std::byte> gltf,
                                                                const std::filesystem::path& folder);

}  // namespace sqmap::io
