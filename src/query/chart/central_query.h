// The layered query on the central map by an exhaustive search: for models without a locator, where a moved surface comes near a
// free point, and as the tests' oracle.
#pragma once

#include "query/model_contact.h"
#include "sqmap/query/options.h"

namespace sqmap::query {

/// Layers Two, Three and Gate for a finite point, by an exhaustive search; gate: k_L of Gate. @pre the model's parts have central
/// maps.
[[nodiscard]] ModelContact query_central(const model::ModelView& model, Vec3f point, Layer layer,
                                         std::uint32_t gate = k_gate) noexcept;

/// The same answer; where the maps' nearest surface is about as far as near says, sooner. near: model units.
[[nodiscard]] ModelContact query_central_near(const model::ModelView& model, Vec3f point, Layer layer, float near) noexcept;

/// How far a surface is moved out.
struct Offset {
    bool stored;  ///< by what is stored at the nearest surface point
    float least;  ///< at least by this, model units
};

/// Moves an answer out; a free point within the offset becomes a contact.
void apply_offset(const model::ModelView& model, Vec3f point, Layer layer, const Offset& move, ModelContact& contact) noexcept;

/// Replaces depth, normal and point of a contact by those of the smoothed map on the point's own ray.
void apply_smoothing(const model::ModelView& model, Vec3f point, ModelContact& contact) noexcept;

/// See distance_along_projection; model space.
[[nodiscard]] bool distance_along_central(const model::ModelView& model, std::uint32_t part, Vec3f point, Layer layer,
                                          float& distance) noexcept;

}  // namespace sqmap::query
