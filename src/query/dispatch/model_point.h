// The query of one point in model space.
#pragma once

#include "query/model_contact.h"
#include "sqmap/query/body.h"

namespace sqmap::query {

/// True so far from the model that float arithmetic on the distance may overflow.
[[nodiscard]] bool is_far_off(const model::ModelView& model, Vec3f point) noexcept;
/// Layer Exact, by superquadrics and triangles alone. options.layer: Exact. @pre model::has_exact(model), the point is finite
[[nodiscard]] ModelContact query_triangles(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;

/// Answers as query_point does, with positions and lengths in model space; free points are not tested against a margin that is
/// proven (is_margin_proven). Cost: see query_point.
[[nodiscard]] ModelContact query_in_model(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;

/// Layer Three by the maps of a model without a locator, as query_in_model answers, but for made-up surface. near: the distance
/// of the surface by another source; where the maps agree with it the search is shorter, and what another map shows nearer by
/// mistake is missed. Model space.
/// @pre the point is finite, the model has central maps
[[nodiscard]] ModelContact query_unlocated_near(const model::ModelView& model, Vec3f point, float near) noexcept;

}  // namespace sqmap::query
