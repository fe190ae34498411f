// Which triangles a cure made up: those that fill holes and gaps, where nothing of the input stood.
// Pure functions: any number of threads.
#pragma once

#include "sqmap/model/model.h"

namespace sqmap::model {

/// False of every triangle of a model that was neither closed nor wrapped. @pre has_exact(view) and the triangle exists
[[nodiscard]] bool is_made_up(const ModelView& view, std::size_t triangle) noexcept;

}  // namespace sqmap::model
