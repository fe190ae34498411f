// Paths of the project's own: a probe that slides over an object while it turns.
#pragma once

#include "path.h"
#include "setting.h"

#include <cstdint>
#include <vector>

namespace sqmap::bench {

struct PathOptions {
    double depth = 0.01;  ///< of the deepest probe vertex, units of the setting (the object's diagonal); below zero: a gap
    std::uint32_t frames = 1000;
    std::uint32_t field_samples = 128;  ///< along each axis, of the distances that lead the probe
};

/// The probe circles the object on a slow figure, turning as it goes, pushed along the line through the object's centre until
/// its deepest vertex is as deep as asked, as a distance field sees it: past the centre where a hole is on the way. Where it
/// slips off a limb it jumps.
/// @throw BenchError where a pose never gets so deep.
/// Deterministic: the same meshes and options give the same path. Cost: below a second plus the field.
[[nodiscard]] std::vector<Pose> sliding_path(const Setting& setting, const PathOptions& options);

}  // namespace sqmap::bench
