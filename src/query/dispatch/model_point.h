// The query of one point in model space.
#pragma once

#include "query/model_contact.h"
#include "sqmap/query/options.h"

namespace sqmap::query {

/// Answers as query_point does, with positions and lengths in model space. Cost: see query_point.
[[nodiscard]] ModelContact query_in_model(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;

}  // namespace sqmap::query
