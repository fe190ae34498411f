// The layered query on the central map, down to the exact layer.
#pragma once

#include "sqmap/query/query.h"

namespace sqmap::query {

/// Layers Two, Three, Exact and Auto for a finite point. @pre the model's parts have central maps.
[[nodiscard]] Contact query_central(const model::ModelView& model, Vec3f point, Layer layer) noexcept;

/// See distance_along_projection.
[[nodiscard]] bool distance_along_central(const model::ModelView& model, std::uint32_t part, Vec3f point, Layer layer, float& distance) noexcept;

}  // namespace sqmap::query
