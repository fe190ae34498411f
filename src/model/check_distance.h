// What signed distances read, checked.
#pragma once

#include "sqmap/model/parse.h"

namespace sqmap::model {

/// Of a view whose triangles and pieces are checked. Cost: linear in the arrays.
[[nodiscard]] ParseStatus check_distance(const ModelView& view) noexcept;

}  // namespace sqmap::model
