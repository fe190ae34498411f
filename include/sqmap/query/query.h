// The layered query (section 4.2): is a point inside the object, how deep, which way is out.
#pragma once

#include "sqmap/math/vec.h"
#include "sqmap/model/model.h"

#include <cstdint>
#include <span>

namespace sqmap::query {

/// What answers a query: each layer is slower than the one before it, and errs less.
enum class Layer : std::uint8_t {
    One,    ///< the superquadrics alone: errs towards contact
    Two,    ///< the locator's planes alone; in a model without a locator the base map
    Three,  ///< the locator's planes where they are the surface, else the refined map
    Exact,  ///< the mesh's own triangles
    Auto,   ///< the cheapest of the four whose stored error is within QueryOptions::tolerance, else Exact
    Gate,   ///< section 4.2 step 4, a part at a time: Three where the base map is sparse, else Two
};

/// k_L of section 4.2, its default: Layer 3 is worth its time while a part has fewer base samples than k_L times its
/// vertices.
inline constexpr std::uint32_t k_layer3_gate = 10;

/// What happened besides the answer; bits of Contact::status.
enum Status : std::uint8_t {
    k_ok = 0,
    k_not_finite = 1,  ///< the query point is NaN or infinite: reported free
    k_no_exact = 2,    ///< Layer::Exact (or an Auto that needs it) of a model baked without it: answered by Layer 3
    k_no_surface = 4,  ///< inside, but no map knows the surface above: depth is 0 and normal zero, push nowhere
};

/// Answer for one point, model space.
struct Contact {
    Vec3f point{};           ///< nearest surface point; the query point where free
    Vec3f normal{};          ///< unit, outward, at that surface point; zero where free
    float depth = 0;         ///< distance to the surface, >= 0; zero where free
    std::int32_t part = -1;  ///< part that the surface point belongs to; -1 where free
    bool contact = false;
    bool certain = false;  ///< the verdict is proven (by the map's bounds or by exact geometry), not approximated
    std::uint8_t status = k_ok;
};

/// Options of point and probe queries. offset and margin are for probes made of triangles, smoothing is for force.
struct QueryOptions {
    Layer layer = Layer::Three;
    double tolerance = 0;                       ///< of Layer::Auto: a depth error, the mesh's units; 0: always Exact
    std::uint32_t layer3_gate = k_layer3_gate;  ///< k_L of Layer::Gate; 0: never Layer 3
    bool first_only = false;                    ///< probes: stop at the first contact, a yes or no
    /// Move the surface out by the stored offset (eq. 12), so that faces do not tunnel (not layer One). Points are computed one
    /// by one: slower by an order of magnitude.
    bool offset = false;
    /// Share of R_max by which the surface is moved out everywhere, or by the offset where that is more. Central maps. As slow.
    float margin = 0;
    bool smoothing = false;  ///< points, all layers but One and Exact: depth and normal of the smoothed map
};

/// The layer that options stand for: Auto is resolved by the errors that bake measured (ModelView::measured), Exact of a model
/// without it is Three. Gate stays.
[[nodiscard]] Layer chosen_layer(const model::ModelView& model, const QueryOptions& options) noexcept;

/// One point. @pre model came from model::parse. Total, noexcept, no allocation.
/// In a model with a locator (and central maps, or layer Exact) the answer has the same bits as query_probe's of that position.
/// A free point is certain where its locator cell is free, and on layer Exact.
/// Cost: with a locator 0.1 to 1 microseconds; without one, a sphere and a box test a part, and where the point is inside, a
/// search bounded by the part's cells.
[[nodiscard]] Contact query_point(const model::ModelView& model, Vec3f point, Layer layer) noexcept;

/// The same with options. With offset or margin, points up to that far outside the surface are in contact too, and depth is
/// measured from the moved surface; with offset, margin or smoothing no verdict is called certain.
[[nodiscard]] Contact query_point(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;

/// A batch: contacts[i] answers points[i]. Returns the number of contacts.
/// @pre contacts.size() >= points.size(), else the rest is left out.
std::size_t query_points(const model::ModelView& model, std::span<const Vec3f> points, Layer layer,
                         std::span<Contact> contacts) noexcept;

/// The nearest point of the mesh's own triangles to a point on either side of them, sought downhill from a place of the surface
/// that a query found: what is near in space but not from there is not seen. depth is the distance and normal the triangle's own,
/// both zero and part -1 where nothing was found; contact says only that something was, not on which side the point is.
/// @pre model::has_exact(model)
/// Cost: two or three lists of 10 to 50 triangles.
[[nodiscard]] Contact nearest_surface(const model::ModelView& model, Vec3f point, const Contact& from) noexcept;

/// Distance to the surface along the projection at a point (eq. 35): the signed distance, model units, from the point
/// to the nearest crossing on its part's ray, positive outwards. False where the part's map has none on that ray.
[[nodiscard]] bool distance_along_projection(const model::ModelView& model, std::uint32_t part, Vec3f point, Layer layer,
                                             float& distance) noexcept;

}  // namespace sqmap::query
