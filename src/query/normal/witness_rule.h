// What overlapping parts say about one point, part after part.
#pragma once

#include "sqmap/query/normal_projection.h"

#include <cstdint>

namespace sqmap::query {

/// A point is in contact if a part claims it and no part that holds it proves it free. The surface that is nearest, by the
/// distance to its tangent plane, gives depth and normal; caps, where a ray starts inside the solid, give none.
struct WitnessRule {
    CombinedAnswer combined;
    PartAnswer nearest;    ///< of the claims with a surface; valid with combined.has_surface
    bool is_held = false;  ///< some superquadric holds the point

    /// False: the answer proves the point free, whatever other parts say.
    [[nodiscard]] bool add(std::int32_t part, const PartAnswer& answer) noexcept;
};

}  // namespace sqmap::query
