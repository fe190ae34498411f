// What the query of section 4.2 works on: a probe's job and the options of the paper's maps.
#pragma once

#include "query/probe/probe_job.h"
#include "sqmap/query/normal_projection.h"

namespace sqmap::query {

struct NormalJob {
    /// o: as the probe's job was made with.
    NormalJob(const ProbeJob& job, const QueryOptions& o) noexcept;

    const ProbeJob& probe;  ///< of a normal model
    ProjectionOptions options;
    bool smoothing, pruning;
};

/// Step 4 of section 4.2: Layer 3 is worth its time while the base grid has fewer samples than k_L times the vertices.
[[nodiscard]] bool reads_base_grid(const NormalMapView& map, const ProjectionOptions& options) noexcept;

/// Layers One to Gate by the widest vectors that the machine has.
[[nodiscard]] ProbeResult run_normal(const NormalJob& job) noexcept;
/// The same template with one lane: the reference, and quicker for one point.
[[nodiscard]] ProbeResult run_normal_one_lane(const NormalJob& job) noexcept;

}  // namespace sqmap::query
