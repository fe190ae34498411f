// A probe job run by the kernels.
#pragma once

#include "query/probe/probe_job.h"

namespace sqmap::query {

/// By the kernel with the widest vectors that the machine has.
ProbeResult run_probe(const ProbeJob& job) noexcept;

}  // namespace sqmap::query
