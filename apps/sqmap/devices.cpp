// sqmap devices: what there is on this machine to touch with.
#include "commands.h"
#include "device/hand.h"
#include "sqmap/device/open.h"
#include "sqmap/device/simulated.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <memory>
#include <utility>

namespace sqmap::app {
namespace {

const char* word(device::Presence presence)
{
    switch (presence) {
        case device::Presence::Here:
            return "here";
        case device::Presence::Absent:
            return "absent";
        case device::Presence::NotBuilt:
            break;
    }
    return "not built";
}

/// Devices that sqmap touch makes itself, because they need the model.
std::vector<device::DeviceListing> paths_over_models()
{
    device::Capabilities path{.name = "path"};
    path.simulated = path.rotates_in = true;
    device::Capabilities simulated = device::capabilities_of(device::Mechanism{}, 1);
    simulated.simulated = true;
    std::vector<device::DeviceListing> list;
    for (const char* const script : {"press", "tap", "slide", "circle"})
        list.push_back({script, device::Presence::Here, "a scripted path over the model", path});
    list.push_back({"simulated:SCRIPT", device::Presence::Here, "a simulated mechanism in a simulated hand", simulated});
    simulated.zones = device::k_glove_zones;
    list.push_back({"glove", device::Presence::Here, "five fingertips and a palm of a simulated hand", simulated});
    return list;
}

std::string output(const device::Capabilities& c)
{
    std::string out = c.torque_out ? "force and torque" : c.force_out ? "force" : c.rumble_out ? "rumble" : "none";
    char limit[48];
    if ((c.force_out || c.torque_out) && c.max_force > 0) {
        std::snprintf(limit, sizeof limit, ", at most %.3g N", c.max_force);
        out += limit;
    }
    return out;
}

}  // namespace

void add_devices(CommandLine& line)
{
    const auto json = std::make_shared<bool>(false);
    Command command = line.add("devices", "List the devices to touch with: what is here, its rate and its limits");
    command.flag("--json", *json, "Answer as JSON");
    command.footer("Pass the first column to sqmap touch --device. Exit code: 0 listed, 64 wrong usage, 70 internal error.");
    command.run([json] {
        std::vector<device::DeviceListing> list = paths_over_models();
        for (device::DeviceListing& entry : device::list_devices()) list.push_back(std::move(entry));
        if (*json) {
            nlohmann::ordered_json out = nlohmann::ordered_json::array();
            for (const device::DeviceListing& d : list)
                out.push_back({{"device", d.spec},
                               {"presence", word(d.presence)},
                               {"state", d.state},
                               {"simulated", d.capabilities.simulated},
                               {"zones", d.capabilities.zones},
                               {"rate", d.capabilities.rate},
                               {"force", d.capabilities.force_out},
                               {"torque", d.capabilities.torque_out},
                               {"rumble", d.capabilities.rumble_out},
                               {"max_force", d.capabilities.max_force},
                               {"max_torque", d.capabilities.max_torque}});
            std::printf("%s\n", out.dump(2).c_str());
        } else {
            for (const device::DeviceListing& d : list) {
                std::printf("%-20s %-9s  %s\n", d.spec.c_str(), word(d.presence), d.state.c_str());
                if (d.presence == device::Presence::Here)
                    std::printf("%-20s %-9s  %s%g Hz; output: %s\n", "", "", d.capabilities.simulated ? "no hardware; " : "",
                                d.capabilities.rate, output(d.capabilities).c_str());
            }
        }
        return 0;
    });
}

}  // namespace sqmap::app
