// Models that say of themselves that their approximate layers may not be relied on.
// Plain data: any number of threads.
#pragma once

#include "sqmap/model/model.h"

namespace sqmap::model {

/// Bake found points farther than 0.5 % of R_max from the surface on the wrong side of it: layers below the exact one are for
/// pictures, not for verdicts. Layer::Auto and the page then take the exact layer.
[[nodiscard]] constexpr bool is_doubtful(const Measured& m) { return m.missed + m.false_contacts > 0; }

}  // namespace sqmap::model
