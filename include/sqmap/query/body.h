// A solid where it is: what all queries are about.
#pragma once

#include "sqmap/math/pose.h"
#include "sqmap/query/options.h"

#include <cstdint>
#include <span>

namespace sqmap::query {

class Probe;
struct Contact;
struct ModelContact;
struct ProbeResult;

/// A solid in the frame that the caller chooses: its model is touched, its probe touches. Both are about the same mesh, in its
/// frame and units, and outlive the body. Either may be missing: ground without a probe, a cloud of points without a model.
///
/// Contacts come back in the frame in which the poses are given: the world's where the touched body's pose is set; the touched
/// mesh's own where it is left out and the collider's pose is relative to it. Plain data; any number of threads may read it.
struct Body {
    const model::ModelView* model = nullptr;  ///< from model::parse
    const Probe* probe = nullptr;             ///< the mesh's vertices, or other points of its surface
    Pose pose{};                              ///< mesh frame -> the caller's. @pre its rotation is proper (not checked)
};

/// How a library with maps of its own answers queries of its models (ModelView::answers), as sqmap::paper does; what the core
/// answers from superquadrics and triangles alone it goes on to answer. Functions are total and noexcept, and allocate nothing.
struct Answers {
    /// See query_probe. @pre both are there
    ProbeResult (*probe)(const Body& touched, const Body& collider, const QueryOptions& options,
                         std::span<Contact> contacts) noexcept;
    /// See query_point; model space.
    ModelContact (*point)(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;
    /// See distance_along_projection; model space. False where the map has none.
    bool (*along)(const model::ModelView& model, std::uint32_t part, Vec3f point, Layer layer, float& distance) noexcept;
    /// How far options move the surface out at most, model units.
    float (*reach)(const model::ModelView& model, const QueryOptions& options) noexcept;
    std::uint8_t no_distance;  ///< status of a signed distance where the model has no tree of bounds
};

/// Holds all of a body; the frame and units of its pose. Radius 0 where it has neither model nor probe.
[[nodiscard]] Sphere sphere_of(const Body& body) noexcept;
/// How far options move the body's surface out at most; the mesh's units.
[[nodiscard]] double reach_of(const Body& body, const QueryOptions& options) noexcept;

}  // namespace sqmap::query
