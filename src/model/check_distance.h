// Checks the arrays that signed distances read.
#pragma once

#include "sqmap/model/parse.h"

namespace sqmap::model {

/// Checks the arrays of distances of a view whose triangles and pieces are already checked. Cost: linear in the arrays.
[[nodiscard]] ParseStatus check_distance(const ModelView& view) noexcept;

}  // namespace sqmap::model
