// A recording as a picture: depth, force, torque and CPU time over time.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sqmap::app {

/// Forces of the same ticks computed otherwise, to draw beside the recorded ones.
struct Comparison {
    std::string name;                                ///< of what they are compared with
    std::vector<double> depth{}, force{}, torque{};  ///< a tick each: m, N, N m; of the zone that feels most
};

/// Reads a trace and writes an SVG of four strips. A column of the picture that holds several ticks shows their least and most.
/// other: drawn beside what was recorded; as long as the trace. Null: none.
/// @throw device::TraceError, io::ModelFileError
void plot_trace(const std::filesystem::path& trace, const std::filesystem::path& svg, const Comparison* other = nullptr);

/// @throw BadTouch for a name that another kind of picture would have, io::ModelFileError for a folder that is not there; empty
/// is none.
void check_plot_name(const std::filesystem::path& svg);

}  // namespace sqmap::app
