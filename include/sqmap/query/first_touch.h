// First touch in motion: when a point meets a triangle, an edge an edge, a moving body another one. Never late.
#pragma once

#include "sqmap/query/body.h"

#include <cstdint>

namespace sqmap::query {

/// A point on a straight path at a steady rate: at `from` at time 0, at `to` at time 1.
struct MovingPoint {
    Vec3d from{}, to{};
};

/// Which distance counts as touching, and until when.
struct TouchOptions {
    double separation = 0;  ///< touching: at most this far apart; the points' units, >= 0
    double until = 1;       ///< what touches first after this time need not be found
};

/// The first touch of two features.
struct Touch {
    bool touches = false;
    double time = 1;  ///< not after the first touch, at most 1e-9 before it where the features do not pass at grazing distance
};

/// A point against the triangle a, b, c, all of them moving. Conservative in floating point: a touch is never missed nor reported
/// late. Where double cannot tell, numbers of twice its digits do; features that pass within 1e-28 of the largest coordinate are
/// reported as touching, and so is what is not decided after 4,096 divisions of the time, at the time that was reached then. A
/// coordinate that is not finite: touches at time 0. Total, noexcept. Pure: any number of threads.
[[nodiscard]] Touch first_touch(const MovingPoint& point, const MovingPoint (&triangle)[3],
                                const TouchOptions& options = {}) noexcept;
/// An edge against an edge; the same.
[[nodiscard]] Touch first_touch(const MovingPoint (&a)[2], const MovingPoint (&b)[2], const TouchOptions& options = {}) noexcept;

/// The first touch of two bodies.
struct BodyTouch {
    bool touches = false;
    double time = 1;           ///< share of the motion, not after the first touch
    std::uint16_t status = 0;  ///< bits of Status and ContactStatus
};

/// When b, which moves from its pose to another one as between() says, touches a, which rests: with any of its vertices, edges or
/// faces. Bodies that touch at the beginning, or of which one begins within the other's model, touch at time 0. Never late; early
/// by at most a thousandth of the motion where the surfaces approach at 8 degrees or steeper. A pose that is not finite,
/// or frames 1e150 or more apart: touches at time 0, status k_not_finite. Without triangles in both probes nothing is tested,
/// status k_no_triangles. Total, noexcept, no allocation; any number of threads.
/// @pre rotations are proper; models came from model::parse
/// Cost: the motion is divided so that arcs are straight within that thousandth; for each piece what is near is tested.
[[nodiscard]] BodyTouch first_touch(const Body& a, const Body& b, const Pose& to) noexcept;

/// The same of two bodies that both move, each from its pose to another one as between() says. The motion is that of b as a sees
/// it.
[[nodiscard]] BodyTouch first_touch(const Body& a, const Pose& to_a, const Body& b, const Pose& to_b) noexcept;

}  // namespace sqmap::query
