// The work of a query of section 4.2: a probe's job, and the maps that answer it.
#pragma once

#include "query/dispatch/model_point.h"
#include "query/probe/probe_job.h"
#include "sqmap/paper/projection.h"

namespace sqmap::paper {

using query::Contact;
using query::k_no_surface;
using query::k_ok;
using query::Layer;
using query::ModelContact;
using query::Probe;
using query::ProbeJob;
using query::ProbeResult;

struct PaperJob {
    /// o: as the probe's job was made with. @pre the job's model is the view of a Reading
    PaperJob(const ProbeJob& job, const query::QueryOptions& o) noexcept;

    const ProbeJob& probe;
    const ModelView& model;  ///< whose maps answer
    ProjectionOptions options;
    bool smoothed_map, pruning;
};

/// Step 4 of section 4.2: Layer 3 is worth its time while the base grid has fewer samples than k_L times the vertices.
[[nodiscard]] bool reads_base_grid(const MapView& map, const ProjectionOptions& options) noexcept;

/// Layers One to Gate by the widest vectors that the machine has.
[[nodiscard]] ProbeResult run_paper(const PaperJob& job) noexcept;
/// The same template with one lane: the reference, and quicker for one point.
[[nodiscard]] ProbeResult run_one_lane(const PaperJob& job) noexcept;

}  // namespace sqmap::paper
