#include "sqmap/query/probe.h"

#include "query/dispatch/probe_kernels.h"
#include "query/dispatch/probe_pointwise.h"
#include "query/exact/probe_exact.h"
#include "query/layer.h"
#include "query/normal/normal_job.h"
#include "query/probe/probe_job.h"

namespace sqmap::query {

ProbeResult query_probe(const Body& touched, const Body& collider, const QueryOptions& options,
                        std::span<Contact> contacts) noexcept
{
    if (touched.model == nullptr || collider.probe == nullptr) return {};
    const ProbeJob job(touched, collider, options, contacts);
    if (!job.finite) return {0, k_not_finite, 0, {}};
    ProbeResult result;
    if (model::is_normal(job.model) && job.layer != Layer::Exact) {
        result = run_normal({job, options});
    } else {
        // The locator knows nothing of a surface that has moved.
        const bool by_points = options.offset || options.margin > 0 || !is_located(job.model, job.layer);
        result =
            by_points ? run_probe_pointwise(job, options) : (job.layer == Layer::Exact ? run_probe_exact(job) : run_probe(job));
    }
    if (lacks_exact(job.model, options)) result.status |= k_no_exact;
    if (lacks_projection(job.model, options)) result.status |= k_not_given;
    return result;
}

}  // namespace sqmap::query
