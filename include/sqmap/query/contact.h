// Contacts, as queries report them: witness point, normal and penetration depth.
// Plain data: any number of threads may read it.
#pragma once

#include "sqmap/math/vec.h"

#include <cstdint>

namespace sqmap::query {

/// Bits of the status of contacts and of results: what else happened while the query was answered.
enum Status : std::uint8_t {
    k_ok = 0,
    k_not_finite = 1,  ///< a point or pose is NaN or infinite: reported free, no contacts
    k_no_exact = 2,    ///< Layer::Exact (or an Auto that needs it) of a model baked without it, answered by Layer 3: bake with
                       ///< BakeOptions::exact
    k_no_surface = 4,  ///< inside, but no map knows the surface above: depth is 0 and normal zero, push nowhere
    k_full = 8,        ///< more contacts than fit, the rest is counted only: give a longer span or a workspace for more
    /// The contact lies where the mesh was closed or wrapped and the surface is made up. Layer Exact: the triangle was; layers
    /// Two and Three: one of those nearest to the locator's cell was.
    k_made_up = 16,
    k_coarse = 32,   ///< swept: a path needs more queries than allowed: raise SweptOptions::max_steps
    k_crowded = 64,  ///< skins: more than SkinWorkspace::k_max positions of the bound solid at one point: the rest was left out
    // 128 is paper::k_not_given, 256 query::k_no_triangles.
};

/// A point of a probe inside a body. Frame and units are those in which the query's poses were given.
struct Contact {
    Vec3f witness{};          ///< the nearest surface point, from the result's anchor (ProbeResult::position)
    Vec3f normal{};           ///< unit, outward
    float depth = 0;          ///< penetration depth, >= 0
    std::uint32_t index = 0;  ///< of the probe's point
    std::int16_t part = -1;   ///< of the touched body's model, that owns the witness point
    bool certain = false;     ///< the verdict is proven (by the map's bounds or by exact geometry), not approximated
    std::uint8_t status = k_ok;
};

}  // namespace sqmap::query
