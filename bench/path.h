// A path: the poses of the probe in the object's frame, one a frame.
#pragma once

#include "sqmap/math/vec.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace sqmap::bench {

/// A probe vertex v stands at rotation v + translation in the object's frame; units of the setting (setting.h).
struct Pose {
    Mat3d rotation;
    Vec3d translation{};

    [[nodiscard]] Vec3d operator()(Vec3d v) const { return rotation * v + translation; }
};

/// Reads a CSV with the header r00,r01,r02,r10,...,r22,tx,ty,tz and a pose a row.
/// @throw BenchError that names the line: no such file, another header, not twelve finite numbers, rows that are not a
/// rotation within 1e-4, no row at all.
[[nodiscard]] std::vector<Pose> read_path(const std::filesystem::path& path);

/// The same format as text, seven significant digits.
[[nodiscard]] std::string path_text(std::span<const Pose> poses);

}  // namespace sqmap::bench
