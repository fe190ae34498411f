// Writing a file so that it is never partly there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace sqmap::io {

/// Writes bytes through a temporary file beside path and a rename: a reader sees the old file or the new one. Symbolic
/// links are followed; what exists and is no regular file (a device, a pipe) is written to in place.
/// @throw ModelFileError where that cannot be done; nothing is left behind.
void replace_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace sqmap::io
