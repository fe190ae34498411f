#include "sqmap/query/probe.h"

#include "query/dispatch/run_probe.h"
#include "query/layer.h"
#include "query/probe/probe_job.h"
#include "query/probe_pointwise.h"

namespace sqmap::query {

ProbeResult query_probe(const Body& touched, const Body& collider, const QueryOptions& options,
                        std::span<Contact> contacts) noexcept
{
    if (touched.model == nullptr || collider.probe == nullptr) return {};
    if (touched.model->answers != nullptr) return touched.model->answers->probe(touched, collider, options, contacts);
    const ProbeJob job(touched, collider, options, contacts);
    if (!job.finite) return {0, k_not_finite, 0, {}};
    ProbeResult result = job.layer == Layer::Exact      ? run_exact_layer(job, options)
                         : goes_by_points(job, options) ? run_probe_pointwise(job, options)
                                                        : run_probe(job);
    if (lacks_exact(job.model, options)) result.status |= k_no_exact;
    return result;
}

}  // namespace sqmap::query
