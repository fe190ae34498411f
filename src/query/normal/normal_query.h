// The layered query on the paper's own maps.
#pragma once

#include "query/model_contact.h"
#include "sqmap/query/options.h"

namespace sqmap::query {

/// Layers One to Gate for a finite point. @pre the model's parts have normal maps.
[[nodiscard]] ModelContact query_normal(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept;

/// See distance_along_projection; model space.
[[nodiscard]] bool distance_along_normal(const model::ModelView& model, std::uint32_t part, Vec3f point, Layer layer,
                                         float& distance) noexcept;

}  // namespace sqmap::query
