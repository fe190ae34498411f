// A worker of a browser reaches no haptic device: the pointer's simulated one is all there is.
#include "sqmap/device/open.h"

namespace sqmap::device {

std::vector<DeviceListing> list_devices() { return {}; }

std::unique_ptr<Device> open_device(std::string_view spec)
{
    throw DeviceError("a browser reaches no device '" + std::string(spec) + "': take sqmap view");
}

}  // namespace sqmap::device
