// The frame query's inner part, one entry for every instruction set.
#pragma once

#include "query/probe/probe_job.h"

namespace sqmap::query {

/// The widest the machine has.
ProbeResult run_probe(const ProbeJob& job) noexcept;

}  // namespace sqmap::query
