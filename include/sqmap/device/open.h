// Every device by name: those of this machine, and opening one. In sqmap::hardware, which links what each family needs.
#pragma once

#include "sqmap/device/spec.h"

#include <memory>
#include <string_view>
#include <vector>

namespace sqmap::device {

/// Looks for every kind. Any thread, one at a time. Opens nothing that could move; waits up to about half a second for services.
/// No exceptions but bad_alloc.
[[nodiscard]] std::vector<DeviceListing> list_devices();

/// Opens the device of a spec, as list_devices gives it. Any thread, one at a time.
/// @throw DeviceError for a kind that does not exist, was not built in or is not there, or for wrong arguments.
[[nodiscard]] std::unique_ptr<Device> open_device(std::string_view spec);

}  // namespace sqmap::device
