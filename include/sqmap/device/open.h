// Every device by name, as on a command line: those of this machine, and opening one. list_devices and open_device are in
// sqmap::hardware, which links what each family needs.
#pragma once

#include "sqmap/device/device.h"

#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sqmap::device {

/// "kind", "kind:first" or "kind:first,name=value,...", as on a command line.
struct DeviceSpec {
    std::string kind;
    std::string first;  ///< the argument without a name
    std::vector<std::pair<std::string, std::string>> options;

    /// The value of an option, or the default.
    [[nodiscard]] std::string text(std::string_view name, std::string_view otherwise) const;
    /// @throw DeviceError where it is given and no finite number in [min, max].
    [[nodiscard]] double number(std::string_view name, double otherwise, double min, double max) const;
    /// @throw DeviceError where it is given and no whole number in [min, max].
    [[nodiscard]] int whole(std::string_view name, int otherwise, int min, int max) const;
    /// The argument without a name as a whole number. @throw as whole
    [[nodiscard]] int index(int otherwise, int min, int max) const;
    /// @throw DeviceError where there is an argument without a name.
    void only_named() const;
    /// @throw DeviceError where an option is none of these.
    void allow(std::span<const std::string_view> names) const;
    /// @throw DeviceError if an option is none of these.
    void allow(std::initializer_list<std::string_view> names) const { allow(std::span(names.begin(), names.size())); }
};

/// @throw DeviceError for an empty kind, an empty argument, an option without a name or one given twice.
[[nodiscard]] DeviceSpec parse_spec(std::string_view text);

/// Availability of a device.
enum class Presence {
    Here,      ///< can be opened now
    Absent,    ///< supported by this build, but not there: unplugged, or its service does not run
    NotBuilt,  ///< this build has no support; the listing names the missing library
};

/// A line of `sqmap devices`.
struct DeviceListing {
    std::string spec;  ///< the argument of open_device
    Presence presence = Presence::Absent;
    std::string state;            ///< for people: the device found, or the missing part and how to get it
    Capabilities capabilities{};  ///< where known
};

/// Looks for every kind. Any thread, one at a time. Opens nothing that could move; waits up to about half a second for services.
/// No exceptions but bad_alloc.
[[nodiscard]] std::vector<DeviceListing> list_devices();

/// Opens the device of a spec, as list_devices gives it. Any thread, one at a time.
/// @throw DeviceError for a kind that does not exist, was not built in or is not there, or for wrong arguments.
[[nodiscard]] std::unique_ptr<Device> open_device(std::string_view spec);

}  // namespace sqmap::device
