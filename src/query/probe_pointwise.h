// A probe job run one point at a time, where the kernels have no answer.
#pragma once

#include "query/probe/probe_job.h"

namespace sqmap::query {

/// How far out options move a model's surface at most, model units.
[[nodiscard]] float offset_reach(const model::ModelView& model, const QueryOptions& options) noexcept;

/// Answers as the kernel does, one point at a time: for models without a locator, and for a surface that options move out.
/// Cost: a sphere test a cluster and part; for each point of a near cluster a query_point.
ProbeResult run_probe_pointwise(const ProbeJob& job, const QueryOptions& options) noexcept;

/// True where a job is computed point by point: the locator knows nothing of a surface that has moved, or there is none.
[[nodiscard]] bool goes_by_points(const ProbeJob& job, const QueryOptions& options) noexcept;
/// Layer Exact: candidate lists of the locator; point by point without one, or where options move the surface.
[[nodiscard]] ProbeResult run_exact_layer(const ProbeJob& job, const QueryOptions& options) noexcept;

}  // namespace sqmap::query
