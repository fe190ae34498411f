// Layer One of one point: the kernel of probes with one lane.
#pragma once

#include "query/model_contact.h"
#include "sqmap/model/model.h"

namespace sqmap::query {

/// By the superquadrics of all parts; model space. @pre the point is finite and not far off
[[nodiscard]] ModelContact query_layer_one(const model::ModelView& model, Vec3f point) noexcept;

}  // namespace sqmap::query
