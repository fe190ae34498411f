// A program that opens devices by name: it links whatever the families need.
#include <sqmap/device/open.h>

#include <cstdio>

int main()
{
    for (const sqmap::device::DeviceListing& entry : sqmap::device::list_devices())
        std::printf("%s: %s\n", entry.spec.c_str(), entry.state.c_str());
    try {
        (void)sqmap::device::open_device("no such kind");
    } catch (const sqmap::device::DeviceError& e) {
        std::printf("%s\n", e.what());
        return 0;
    }
    return 1;
}
