// A solid where it is: what all queries are about.
#pragma once

#include "sqmap/math/pose.h"
#include "sqmap/query/options.h"

namespace sqmap::query {

class Probe;

/// A solid in the frame that the caller chooses: its model is touched, its probe touches. Both are about the same mesh, in its
/// frame and units, and outlive the body. Either may be missing: ground without a probe, a cloud of points without a model.
///
/// Contacts come back in the frame in which the poses are given: the world's where the touched body's pose is set; the touched
/// mesh's own where it is left out and the collider's pose is relative to it. Plain data; any number of threads may read it.
struct Body {
    const model::ModelView* model = nullptr;  ///< from model::parse
    const Probe* probe = nullptr;             ///< the mesh's vertices, or other points of its surface
    Pose pose{};                              ///< mesh frame -> the caller's. @pre its rotation is proper
};

/// Holds all of a body; the frame and units of its pose. Radius 0 where it has neither model nor probe.
[[nodiscard]] Sphere sphere_of(const Body& body) noexcept;
/// How far options move the body's surface out at most; the mesh's units.
[[nodiscard]] double reach_of(const Body& body, const QueryOptions& options) noexcept;

}  // namespace sqmap::query
