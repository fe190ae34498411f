// A path: the poses of the probe in the object's frame, one a frame, in units of the setting (setting.h).
#pragma once

#include "sqmap/math/pose.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace sqmap::bench {

/// Reads a CSV with the header r00,r01,r02,r10,...,r22,tx,ty,tz and a pose a row.
/// @throw BenchError that names the line: no such file, another header, not twelve finite numbers, rows that are not a
/// rotation within 1e-4, no row at all.
[[nodiscard]] std::vector<Pose> read_path(const std::filesystem::path& path);

/// The same format as text, seven significant digits.
[[nodiscard]] std::string path_text(std::span<const Pose> poses);

}  // namespace sqmap::bench
