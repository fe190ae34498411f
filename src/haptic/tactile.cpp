#include "sqmap/haptic/tactile.h"

#include "sqmap/math/assert.h"
#include "tactile_kernels.h"

#include <algorithm>
#include <cmath>

namespace sqmap::haptic {

TactileResult TactilePad::tick(const TactileTick& tick, const TactileOptions& options, std::span<Taxel> taxels) noexcept
{
    SQMAP_ASSERT(taxels.size() == size());
    std::fill(taxels.begin(), taxels.end(), Taxel{});
    TactileResult result;
    if (!is_finite(tick.pose) || !is_finite(tick.touched.pose) || !std::isfinite(tick.dt)) {
        has_last_ = false;
        result.status = query::k_not_finite;
        return result;
    }
    const Pose relative = compose(inverse(tick.touched.pose), tick.pose);  // pad's frame -> the model's
    const bool slips = has_last_ && tick.dt > 0;
    const query::Body touched{tick.touched.model, nullptr, {}}, pad{nullptr, &probe_, relative};
    const query::ProbeResult found = query::query_probe(touched, pad, options.query, contacts_);
    result.contacts = found.contacts;
    result.status = found.status;
    add_forces({options, relative, last_, slips ? 1 / tick.dt : 0, points_, normals_}, found.written(contacts_), taxels, result);
    last_ = relative;
    has_last_ = true;
    return result;
}

}  // namespace sqmap::haptic
