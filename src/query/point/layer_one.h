// Layer One of one point: the kernel of probes with one lane.
#pragma once

#include "query/point/model_point.h"

namespace sqmap::query {

/// By the superquadrics of all parts; model space. @pre the point is finite and not far off
[[nodiscard]] ModelContact query_layer_one(const model::ModelView& model, Vec3f point) noexcept;

}  // namespace sqmap::query
