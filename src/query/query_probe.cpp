#include "sqmap/query/probe.h"

#include "query/dispatch/run_probe.h"
#include "query/layer.h"
#include "query/probe/kept_probe.h"
#include "query/probe/probe_job.h"
#include "query/probe_pointwise.h"

namespace sqmap::query {

namespace {

/// kept: null where the caller keeps nothing.
ProbeResult answer(const Body& touched, const Body& collider, const QueryOptions& options, std::span<Contact> contacts,
                   KeptProbe* kept)
{
    if (touched.model == nullptr || collider.probe == nullptr) return {};
    if (touched.model->answers != nullptr) return touched.model->answers->probe(touched, collider, options, contacts);
    ProbeJob job(touched, collider, options, contacts);
    if (!job.finite) return {0, k_not_finite, 0, {}};
    if (kept != nullptr && !goes_by_points(job, options)) job.kept = kept->advance(job, *collider.probe);
    ProbeResult result = job.layer == Layer::Exact      ? run_exact_layer(job, options)
                         : goes_by_points(job, options) ? run_probe_pointwise(job, options)
                                                        : run_probe(job);
    if (lacks_exact(job.model, options)) result.status |= k_no_exact;
    return result;
}

}  // namespace

ProbeResult query_probe(const Body& touched, const Body& collider, const QueryOptions& options,
                        std::span<Contact> contacts) noexcept
{
    return answer(touched, collider, options, contacts, nullptr);
}

ProbeResult query_probe(const Body& touched, const Body& collider, const QueryOptions& options,
                        ProbeWorkspace& workspace) noexcept
{
    KeptProbe* const kept = KeptProbe::of(workspace);
    if (kept != nullptr) kept->reuse = {};
    return answer(touched, collider, options, KeptProbe::contacts_of(workspace), kept);
}

}  // namespace sqmap::query
