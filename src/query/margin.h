// Surfaces that a margin moves out, measured from the triangles.
#pragma once

#include "query/model_contact.h"
#include "sqmap/query/options.h"

namespace sqmap::query {

/// Answers as query_point does, with positions and lengths in model space: query_in_model, and where the margin is proven a free
/// point that is less than the margin from the triangles is in contact with the surface that the margin moves out.
[[nodiscard]] ModelContact query_with_margin(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;

}  // namespace sqmap::query
