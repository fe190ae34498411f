// Messages of Haply's service, read and written apart from the socket that carries them.
#pragma once

#include "sqmap/device/device.h"

#include <string>
#include <string_view>

namespace sqmap::device {

/// Contents of one message of the service.
struct HaplyMessage {
    bool valid = false;      ///< the text was a JSON object; else nothing else counts
    std::string device_id;   ///< the Inverse3's; empty if the message has none
    bool has_state = false;  ///< sample holds a reading
    Sample sample{};         ///< position, velocity, orientation and buttons; no time, no sequence
};

/// wanted: the device to look for; empty: the first one. Never throws but bad_alloc, whatever the text is.
[[nodiscard]] HaplyMessage read_haply(std::string_view text, const std::string& wanted);

/// The command that asks for a force, N, and for the next state.
[[nodiscard]] std::string haply_force(const std::string& device_id, Vec3d force);

}  // namespace sqmap::device
