// The faces of a surface turned alike, joined into shells where they touch, and turned outward.
#pragma once

#include "sqmap/math/vec.h"
#include "surface.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// The treatment of a region with one side only, a Moebius strip: it is left alone, or turned as though it were torn.
enum class OneSided { Refused, Torn };

/// Turns faces so that neighbours over two-faced edges agree; in each region the smaller number of faces is turned.
struct Orientation {
    std::vector<std::uint32_t> region;  ///< per face: connected over two-faced edges; the least face of it
    std::uint32_t turned_count = 0;
    std::optional<std::uint32_t> conflict;  ///< a face that cannot agree with its neighbours
};
Orientation orient(Surface& surface, OneSided one_sided = OneSided::Refused);

/// Partner of every side 3 * face + k: the side of another face it is joined to, k_none at a boundary.
struct Pairing {
    std::vector<std::uint32_t> mate;
    std::optional<EdgeUse> unpaired;  ///< first edge with more than two faces whose faces do not pair up
};
/// Joins two-faced edges, and at edges with more faces those with solid between them, so that shells that only touch
/// come apart. @pre orient() was called.
Pairing paired(const Surface& surface, const Orientation& orientation);

/// Gives every fan of faces around a vertex its own copy of it; returns the number of copies made.
std::uint32_t split_fans(Surface& surface, const std::vector<std::uint32_t>& mate);

/// Component of every face under the pairing: the least face of it.
std::vector<std::uint32_t> components(std::size_t face_count, const std::vector<std::uint32_t>& mate);

/// Shells turned outward: all of them where their sum is inside out, then each that is inside out without lying in the
/// solid of the others. Shells that do lie there are cavities.
struct Shells {
    std::uint32_t turned_count = 0;  ///< faces
    std::uint32_t cavity_count = 0;
};
/// @pre closed; component: of every face. points: near the origin, about unit size.
Shells turn_outward(Surface& surface, std::span<const Vec3d> points, const std::vector<std::uint32_t>& component);

/// Six times the signed volume under a face, seen from the origin.
double six_volumes(std::span<const Vec3d> points, const Triangle& t);

}  // namespace sqmap::mesh
