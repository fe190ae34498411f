// The frame query's inner part, one entry for every instruction set.
#pragma once

#include "frame_job.h"

namespace sqmap::query {

/// The widest the machine has.
FrameResult run_frame(const FrameJob& job) noexcept;
/// By the mesh's own triangles. @pre the model has a locator and the exact layer
FrameResult run_frame_exact(const FrameJob& job) noexcept;

}  // namespace sqmap::query
