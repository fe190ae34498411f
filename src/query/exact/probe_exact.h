// The probe query of the exact layer, one entry for every instruction set.
#pragma once

#include "query/probe/probe_job.h"

namespace sqmap::query {

/// By the mesh's own triangles. @pre the model has a locator and the exact layer
ProbeResult run_probe_exact(const ProbeJob& job) noexcept;

}  // namespace sqmap::query
