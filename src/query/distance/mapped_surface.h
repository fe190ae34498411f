// The surface nearest to a point of a model that was baked without its triangles: from its maps, so approximate.
#pragma once

#include "sqmap/math/vec.h"
#include "sqmap/model/model.h"

#include <cstdint>
#include <optional>

namespace sqmap::query {

/// A point of the surface as layer 3 has it, in model space.
struct MappedSurface {
    float distance = 0;  ///< from it to the queried point; below 0: that point is inside
    Vec3f gradient{};    ///< of the distance, unit
    Vec3f point{};
    std::int32_t part = -1;
};

/// Nothing where the maps know no surface. Inside the solid one query of layer 3; outside up to four searches of ten such
/// queries, each from another sample of the surface. The distance may be too large: a nearer sheet may have no sample.
[[nodiscard]] std::optional<MappedSurface> nearest_mapped_surface(const model::ModelView& model, Vec3f p);

}  // namespace sqmap::query
