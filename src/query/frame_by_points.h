// A frame asked one point at a time: what the kernel does not do.
#pragma once

#include "frame_job.h"

namespace sqmap::query {

/// How far out the stored offset (eq. 12) moves a model's surface at most, model units.
[[nodiscard]] float offset_reach(const model::ModelView& model) noexcept;

/// As the kernel, by query_point: for layer One, for models without a locator, and with offset for the moved surface.
/// Cost: a sphere test a cluster and part; for each point of a near cluster a query_point.
FrameResult run_frame_by_points(const FrameJob& job, bool offset) noexcept;

}  // namespace sqmap::query
