// Writing a file so that it is never partly there.
// Any number of threads, on files of their own.
#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <span>

namespace sqmap::io {

/// Writes bytes through a temporary file beside path and a rename: a reader sees the old file or the new one. Symbolic
/// links are followed; what exists and is no regular file (a device, a pipe) is written to in place.
/// @throw ModelFileError where that cannot be done; nothing is left behind.
void replace_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// Long work calls this before it starts. Throws ModelFileError where output's folder is missing, or where output is one of the
/// other files that are read or written; empty paths and devices are passed over.
void check_output(const std::filesystem::path& output, std::initializer_list<std::filesystem::path> others);

}  // namespace sqmap::io
