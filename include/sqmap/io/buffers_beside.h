// Which other files a mesh file is read from, for who keeps results by content.
// Any number of threads, on files of their own.
#pragma once

#include "sqmap/io/read.h"

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

namespace sqmap::io {

/// The files that a glTF file names as its buffers and that are there, in its order; read_mesh_file reads no others. Empty for
/// bytes that are no glTF file: reading says why. folder: the file's own.
[[nodiscard]] std::vector<std::filesystem::path> buffers_beside(std::span<const std::byte> gltf,
                                                                const std::filesystem::path& folder);

}  // namespace sqmap::io
