// The frame query's inner part, one entry for every instruction set.
#pragma once

#include "frame_job.h"

namespace sqmap::query {

/// The widest the machine has.
FrameResult run_frame(const FrameJob& job) noexcept;

}  // namespace sqmap::query
