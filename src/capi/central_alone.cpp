// libsqmap_query has no kernels for normal models, which are a third of the runtime, and opens none. The functions of
// sqmap::query here stand before those of the runtime's archive, so that the linker takes no such kernel.
#include "objects.h"
#include "query/normal/normal_job.h"
#include "sqmap/model/normal_map.h"

namespace sqmap::query {

ProbeResult run_normal(const NormalJob&) noexcept { return {}; }
ProbeResult run_normal_one_lane(const NormalJob&) noexcept { return {}; }
PartAnswer project(const NormalMapView&, Vec3f, const ProjectionOptions&) noexcept { return {}; }

}  // namespace sqmap::query

namespace sqmap::capi {

void refuse_unanswered(const model::ModelView& view)
{
    if (model::is_normal(view))
        throw Failure{SQMAP_E_MISSING, "model", "is of the normal projection, which libsqmap_query leaves out",
                      "link libsqmap, or bake it with the central projection"};
}

}  // namespace sqmap::capi
