// The families of devices. All but the network need something besides this project: each is compiled where CMake found that.
#pragma once

#include "sqmap/device/open.h"

#include <memory>
#include <vector>

namespace sqmap::device {

// list_x appends what there is of a family, at least one entry; open_x throws DeviceError.
void list_network(std::vector<DeviceListing>& list);
[[nodiscard]] std::unique_ptr<Device> open_network(const DeviceSpec& spec);  ///< network[:ADDRESS][,port=,wait=]
void list_sdl(std::vector<DeviceListing>& list);
[[nodiscard]] std::unique_ptr<Device> open_sdl(const DeviceSpec& spec);
void list_spacenav(std::vector<DeviceListing>& list);
[[nodiscard]] std::unique_ptr<Device> open_spacenav(const DeviceSpec& spec);
void list_haply(std::vector<DeviceListing>& list);
[[nodiscard]] std::unique_ptr<Device> open_haply(const DeviceSpec& spec);
void list_openhaptics(std::vector<DeviceListing>& list);
[[nodiscard]] std::unique_ptr<Device> open_openhaptics(const DeviceSpec& spec);
void list_force_dimension(std::vector<DeviceListing>& list);
[[nodiscard]] std::unique_ptr<Device> open_force_dimension(const DeviceSpec& spec);
void list_chai3d(std::vector<DeviceListing>& list);
[[nodiscard]] std::unique_ptr<Device> open_chai3d(const DeviceSpec& spec);

}  // namespace sqmap::device
