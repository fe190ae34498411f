// The frame query's inner part, one entry for every instruction set.
#pragma once

#include "probe_job.h"

namespace sqmap::query {

/// The widest the machine has.
ProbeResult run_probe(const ProbeJob& job) noexcept;
/// By the mesh's own triangles. @pre the model has a locator and the exact layer
ProbeResult run_probe_exact(const ProbeJob& job) noexcept;

}  // namespace sqmap::query
