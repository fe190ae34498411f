// Baked bodies for tests of pairs and scenes: a model, its vertices as a probe, and poses.
#pragma once

#include "sqmap/query/pair.h"
#include "support/parsed.h"

#include <cmath>

namespace sqmap::test {

/// A mesh with its model and its probe; bodies point at it, so it stays where it is.
struct Solid {
    explicit Solid(const mesh::Mesh& m) : mesh(m), parsed(m), view(parsed.view()), probe(m.vertices, m.triangles) {}
    Solid(const Solid&) = delete;
    Solid& operator=(const Solid&) = delete;
    [[nodiscard]] query::Body at(const sqmap::Pose& pose = {}) const { return {&view, &probe, pose}; }

    const mesh::Mesh mesh;
    const Parsed parsed;  // frames ask for a model in one blob
    const model::ModelView view;
    const query::Probe probe;
};

inline sqmap::Pose shifted(Vec3d by) { return {{}, by}; }

/// Rodrigues' formula; axis of unit length, angle in radians.
inline Mat3d rotation_about(Vec3d axis, double angle)
{
    const double c = std::cos(angle), s = std::sin(angle);
    Mat3d m;
    for (int k = 0; k < 3; ++k) {
        Vec3d e{};
        e[k] = 1;
        const Vec3d column = c * e + s * cross(axis, e) + ((1 - c) * dot(axis, e)) * axis;
        for (int i = 0; i < 3; ++i) m.row[i][k] = column[i];
    }
    return m;
}

inline sqmap::Pose random_pose(Random& random, double reach)
{
    return {rotation_about(random.direction(), random.between(0, 3.14)), reach * random.in_box({-1, -1, -1}, {1, 1, 1})};
}

}  // namespace sqmap::test
