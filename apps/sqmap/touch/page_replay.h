// sqmap replay of what the page of sqmap view has recorded.
#pragma once

#include "sqmap/device/trace.h"
#include "touch/replayed.h"

namespace sqmap::app {

/// Tells whether the page has written a recording.
[[nodiscard]] bool is_of_page(const device::TraceHeader& header);

/// As replay of the program's own recordings: computes the forces of every tick again. Models are found by their content among
/// arguments.models, without these among the .sqmap files beside the recording. rows: prints the ticks that differ. computed:
/// receives the recomputed trace; may be null. Threads share nothing.
/// @throw BadTouch, device::TraceError, io::ModelFileError
[[nodiscard]] Replayed replay_page(const ReplayArguments& arguments, bool rows, Comparison* computed);

}  // namespace sqmap::app
