// How far two closed meshes are apart: their nearest points with a certified bound, and whether they are nearer than a distance.
#pragma once

#include "sqmap/query/contacts.h"

#include <cstdint>

namespace sqmap::query {

/// The least distance of two solids. The frame and units of the bodies' poses.
struct Clearance {
    double distance = 0;    ///< of the witness points; 0 where the solids have a point in common
    double at_least = 0;    ///< the truth is between this and the distance: some 1e-14 of the sizes below it
    WitnessPair witness{};  ///< the nearest points; of solids that have a point in common one of these, twice
    std::uint32_t triangle_a = k_unnamed, triangle_b = k_unnamed;  ///< that hold them; k_unnamed where one solid is in the other
    std::uint16_t status = k_ok;                                   ///< bits of Status and ContactStatus
};

/// The least distance of a and b, whose probes have triangles: between any points of vertices, edges and faces, in double. One
/// within the other is found by their models; a body without a model has no inside. A pose that is not finite, or 1e150 away:
/// distance 0, k_not_finite; a probe without triangles: distance 0, k_no_triangles. Total, noexcept, no allocation, the same bits
/// on every instruction set; any number of threads.
/// @pre a.model, b.model came from model::parse
/// Cost: logarithmic as a rule; linear in the triangles that are as near as the nearest to 1e-6 of the sizes.
[[nodiscard]] Clearance clearance(const Body& a, const Body& b) noexcept;

/// True where the solids are at most this far apart, by the distance that clearance() would compute: it stops at the first two
/// triangles that are near enough. False for a pose that is not finite or 1e150 away, a probe without triangles, a distance below
/// zero or NaN. Cost: less than that of clearance, much less where the answer is clear.
[[nodiscard]] bool is_within(const Body& a, const Body& b, double distance) noexcept;

}  // namespace sqmap::query
