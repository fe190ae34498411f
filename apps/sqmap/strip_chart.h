// A recording as a picture: depth, force, torque and CPU time over time.
#pragma once

#include <filesystem>

namespace sqmap::app {

/// Reads a trace and writes an SVG of four strips. A column of the picture that holds several ticks shows their least and most.
/// @throw device::TraceError, io::ModelFileError
void plot_trace(const std::filesystem::path& trace, const std::filesystem::path& svg);

/// @throw BadTouch for a name that another kind of picture would have; empty is none.
void check_plot_name(const std::filesystem::path& svg);

}  // namespace sqmap::app
