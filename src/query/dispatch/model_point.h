// The query of one point in model space.
#pragma once

#include "query/model_contact.h"
#include "sqmap/query/body.h"

namespace sqmap::query {

/// True so far from the model that float arithmetic on the distance may overflow.
[[nodiscard]] bool is_far_off(const model::ModelView& model, Vec3f point) noexcept;
/// Layer Exact, by superquadrics and triangles alone. options.layer: Exact. @pre model::has_exact(model), the point is finite
[[nodiscard]] ModelContact query_triangles(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;

/// Answers as query_point does, with positions and lengths in model space. Cost: see query_point.
[[nodiscard]] ModelContact query_in_model(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;

}  // namespace sqmap::query
