// A small setting that bench tests race on.
#pragma once

#include "make_path.h"
#include "setting.h"
#include "sqmap/mesh/shapes.h"

#include <memory>
#include <vector>

namespace sqmap::test {

/// An egg that touches a ring.
inline std::unique_ptr<bench::Setting> egg_on_ring()
{
    return std::make_unique<bench::Setting>(
        mesh::torus({.major_radius = 1, .minor_radius = 0.3, .major_segments = 48, .minor_segments = 16}),
        mesh::ellipsoid({1, 0.8, 0.6}, 3));
}

inline std::vector<Pose> short_path(const bench::Setting& setting, double depth, std::uint32_t frames = 20)
{
    return bench::sliding_path(setting, {.depth = depth, .frames = frames, .field_samples = 48});
}

/// Brute force: signed distance of every probe vertex at a pose.
inline std::vector<double> signed_distances(const bench::Setting& setting, const Pose& pose)
{
    std::vector<double> out;
    for (const Vec3d& v : setting.probe.vertices) {
        const Vec3d p = apply(pose, v);
        const double d = setting.solid.closest_boundary(p).distance;
        out.push_back(setting.solid.inside(p) ? -d : d);
    }
    return out;
}

}  // namespace sqmap::test
