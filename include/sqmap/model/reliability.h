// Models that say of themselves that their approximate layers may not be relied on.
// Plain data: any number of threads.
#pragma once

#include "sqmap/model/model.h"

namespace sqmap::model {

/// Bake found points farther than 0.5 % of R_max from the surface on the wrong side of it.
[[nodiscard]] constexpr bool has_wrong_verdicts(const Measured& m) { return m.missed + m.false_contacts > 0; }

/// Largest 99th percentile of the depth error with which layer 3 gives verdicts, percent of R_max.
inline constexpr double k_max_depth_p99 = 0.5;
/// Layers below the exact one are for pictures, not for verdicts: Layer::Auto and the page take the exact layer.
[[nodiscard]] constexpr bool is_doubtful(const Measured& m) { return has_wrong_verdicts(m) || m.depth_p99 > k_max_depth_p99; }

}  // namespace sqmap::model
