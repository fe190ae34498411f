// Writing triangle meshes as OBJ or OFF text.
// Any number of threads, on files of their own.
#pragma once

#include "sqmap/math/vec.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>

namespace sqmap::io {

/// Writes a mesh; the ending of the path, .obj or .off, chooses the format. Coordinates keep every bit (17 digits).
/// The file appears whole or not at all: it is written beside its place and renamed.
/// @throw std::invalid_argument for another ending
/// @throw std::runtime_error when the file cannot be written
void write_mesh(const std::filesystem::path& path, std::span<const Vec3d> vertices,
                std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace sqmap::io
