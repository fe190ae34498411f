#include "sqmap/device/open.h"

#include "device/families.h"
#include "sqmap/device/path.h"
#include "sqmap/device/trace.h"

#include <utility>

namespace sqmap::device {

namespace {

constexpr double k_min_rate = 60, k_max_rate = 1e4;  // Hz: the range of the safety filter

std::unique_ptr<Device> open_path(const DeviceSpec& spec)
{
    spec.allow({"rate"});
    if (spec.first.empty()) throw DeviceError("path needs a file, as in path:poses.csv");
    return std::make_unique<PathDevice>("path " + spec.first, read_path(spec.first),
                                        spec.number("rate", 1000, k_min_rate, k_max_rate));
}

std::unique_ptr<Device> open_trace(const DeviceSpec& spec)
{
    spec.allow({"rate"});
    if (spec.first.empty()) throw DeviceError("trace needs a file, as in trace:recording.csv");
    try {
        TraceReader reader(spec.first);
        std::vector<Pose> poses;
        TraceRow row;
        const auto zones = static_cast<std::ptrdiff_t>(reader.header().zones);
        while (reader.next(row)) poses.insert(poses.end(), row.poses.begin(), row.poses.begin() + zones);
        return std::make_unique<PathDevice>("trace " + spec.first, std::move(poses),
                                            spec.number("rate", 1000, k_min_rate, k_max_rate), reader.header().zones);
    } catch (const TraceError& e) {
        throw DeviceError(e.what());
    }
}

struct Family {
    const char* kind;
    void (*list)(std::vector<DeviceListing>&);  ///< null: not built
    std::unique_ptr<Device> (*open)(const DeviceSpec&);
    const char* missing;  ///< how to get it built
};

/// The functions of a family; null if CMake did not find its library.
#define SQMAP_FAMILY(have, name) have ? list_##name : nullptr, have ? open_##name : nullptr

constexpr Family k_families[] = {
    {"sdl", SQMAP_FAMILY(SQMAP_HAVE_SDL, sdl), "SDL2 was not found at configure time (Debian: libsdl2-dev)"},
    {"spacenav", SQMAP_FAMILY(SQMAP_HAVE_SPACENAV, spacenav), "libspnav was not found at configure time (Debian: libspnav-dev)"},
    {"haply", SQMAP_FAMILY(SQMAP_HAVE_HAPLY, haply), "Boost.Beast was not found at configure time (Debian: libboost1.74-dev)"},
    {"openhaptics", SQMAP_FAMILY(SQMAP_HAVE_OPENHAPTICS, openhaptics),
     "OpenHaptics (HD/hd.h) was not found at configure time: 3D Systems gives it to owners"},
    {"forcedimension", SQMAP_FAMILY(SQMAP_HAVE_FORCE_DIMENSION, force_dimension),
     "the Force Dimension SDK (dhdc.h) was not found at configure time"},
    {"chai3d", SQMAP_FAMILY(SQMAP_HAVE_CHAI3D, chai3d), "CHAI3D (chai3d.h) was not found at configure time"},
};

}  // namespace

std::vector<DeviceListing> list_devices()
{
    std::vector<DeviceListing> list;
    const Capabilities played{.name = "path", .simulated = true, .rotates_in = true};
    list.push_back({"path:FILE", Presence::Here, "poses from a file, docs/devices.md", played});
    list.push_back({"trace:FILE", Presence::Here, "poses of a recording", played});
    list_network(list);
    for (const Family& family : k_families) {
        if (family.list == nullptr)
            list.push_back({family.kind, Presence::NotBuilt, family.missing, {}});
        else
            family.list(list);
    }
    return list;
}

std::unique_ptr<Device> open_device(std::string_view text)
{
    const DeviceSpec spec = parse_spec(text);
    if (spec.kind == "path") return open_path(spec);
    if (spec.kind == "trace") return open_trace(spec);
    if (spec.kind == "network") return open_network(spec);
    for (const Family& family : k_families) {
        if (spec.kind != family.kind) continue;
        if (family.open == nullptr) throw DeviceError(spec.kind + ": " + family.missing);
        return family.open(spec);
    }
    throw DeviceError("there is no device of kind '" + spec.kind + "': sqmap devices lists all");
}

}  // namespace sqmap::device
