// Another program as the device, over UDP: it sends poses and receives wrenches. The messages: docs/devices.md.
#pragma once

#include "sqmap/device/device.h"

#include <cstdint>
#include <memory>
#include <string>

namespace sqmap::device {

/// UDP port on which a network device listens by default, and the version of its protocol.
inline constexpr std::uint16_t k_network_port = 47710;
inline constexpr std::uint32_t k_network_version = 1;

/// Options of open_network.
struct NetworkOptions {
    std::string address =
        "127.0.0.1";  ///< IPv4 to listen on; any client that reaches it may move the tool and receives its forces
    std::uint16_t port = k_network_port;
    double wait = 10;  ///< s to wait for a client's hello and first pose
};

/// Listens, waits for a client's hello and first pose, and gives a device with the capabilities that the client reports.
/// A thread of the device's own receives and answers.
/// One client at a time: another is refused until the first says goodbye or is silent for a second. Each pose is answered at
/// once with the newest wrench, so the force that answers a pose comes with the answer to the next.
/// @throw DeviceError if the address cannot be listened on, or no client came.
[[nodiscard]] std::unique_ptr<Device> open_network(const NetworkOptions& options);

}  // namespace sqmap::device
