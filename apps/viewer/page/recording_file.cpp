// A worker of a browser has no files to write traces to.
#include "viewer/server/touch/recording_file.h"

#include "sqmap/device/trace.h"

namespace sqmap::viewer {
namespace {

[[noreturn]] void refuse()
{
    throw device::TraceError("recordings with their poses are saved and opened by sqmap view; here there is the table");
}

}  // namespace

std::string recording_text(const Recording& /*recording*/) { refuse(); }
RecordingFile read_recording(const std::string& /*text*/, const std::string& /*name*/) { refuse(); }

}  // namespace sqmap::viewer
