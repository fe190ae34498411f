// 3D Systems Touch and Phantom through OpenHaptics. Compiled against declarations of ours in the tests; not tried on hardware.
#include "device/families.h"
#include "device/threaded.h"

#include <HD/hd.h>

#include <cmath>

namespace sqmap::device {
namespace {

constexpr double k_mm = 1e-3;

class OpenHaptics final : public ThreadedDevice {
public:
    explicit OpenHaptics(const std::string& name)
    {
        handle_ = hdInitDevice(name.empty() ? HD_DEFAULT_DEVICE : name.c_str());
        if (HD_DEVICE_ERROR(hdGetError()))
            throw DeviceError("openhaptics: no device '" + name + "'\n  cure: check it with the maker's own test program");
        hdMakeCurrentDevice(handle_);
        hdEnable(HD_FORCE_OUTPUT);
        // Second to our own filter: the maker's limits stay on.
        hdEnable(HD_MAX_FORCE_CLAMPING);
        HDdouble force = 0, continuous = 0;
        HDint dof = 3;
        hdGetDoublev(HD_NOMINAL_MAX_FORCE, &force);
        hdGetDoublev(HD_NOMINAL_MAX_CONTINUOUS_FORCE, &continuous);
        hdGetIntegerv(HD_OUTPUT_DOF, &dof);
        const char* const model = hdGetString(HD_DEVICE_MODEL_TYPE);
        capabilities_ = {.name = std::string(model != nullptr ? model : "device") + " (OpenHaptics)",
                         .rotates_in = true,
                         .force_out = true,
                         .torque_out = dof == 6,
                         .max_force = force,
                         .continuous_force = continuous};
        callback_ = hdScheduleAsynchronous(tick, this, HD_MAX_SCHEDULER_PRIORITY);
        hdStartScheduler();
        if (!HD_DEVICE_ERROR(hdGetError()) && wait_for_sample(2)) return;
        close();
        throw DeviceError("openhaptics: the scheduler does not run or the device gives no reading");
    }
    ~OpenHaptics() override { close(); }

private:
    void close() noexcept
    {
        hdStopScheduler();
        hdUnschedule(callback_);
        hdDisableDevice(handle_);  // forces off
    }

    /// By the maker's own servo thread, a thousand times a second.
    static HDCallbackCode HDCALLBACK tick(void* self)
    {
        static_cast<OpenHaptics*>(self)->exchange();
        return HD_CALLBACK_CONTINUE;
    }

    void exchange() noexcept
    {
        hdMakeCurrentDevice(handle_);
        hdBeginFrame(handle_);
        HDdouble t[16] = {};  // column-major, mm
        HDint buttons = 0;
        hdGetDoublev(HD_CURRENT_TRANSFORM, t);
        hdGetIntegerv(HD_CURRENT_BUTTONS, &buttons);
        const double time = now();
        Sample sample;
        sample.time = time;
        sample.poses[0] = {{{{t[0], t[4], t[8]}, {t[1], t[5], t[9]}, {t[2], t[6], t[10]}}}, k_mm * Vec3d{t[12], t[13], t[14]}};
        sample.buttons = static_cast<std::uint32_t>(buttons);
        const Wrench& w = channel_.output(time)[0];
        const HDdouble force[3] = {w.force.x, w.force.y, w.force.z};
        hdSetDoublev(HD_CURRENT_FORCE, force);
        if (capabilities_.torque_out) {
            const HDdouble torque[3] = {1e3 * w.torque.x, 1e3 * w.torque.y, 1e3 * w.torque.z};  // mN m
            hdSetDoublev(HD_CURRENT_TORQUE, torque);
        }
        hdEndFrame(handle_);
        // Single errors, such as warm motors or too much force, pass; ten in a row mean that the device is gone.
        if (HD_DEVICE_ERROR(hdGetError()))
            ++errors_;
        else
            errors_ = 0;
        if (errors_ < 10)
            channel_.publish(sample);
        else
            channel_.lose();
    }

    HHD handle_ = HD_INVALID_HANDLE;
    HDSchedulerHandle callback_{};
    int errors_ = 0;
};

}  // namespace

void list_openhaptics(std::vector<DeviceListing>& list)
{
    list.push_back({"openhaptics",
                    Presence::Here,
                    "built in; whether a device is plugged in shows when it is opened",
                    {.name = "OpenHaptics", .rotates_in = true, .force_out = true}});
}

std::unique_ptr<Device> open_openhaptics(const DeviceSpec& spec)
{
    spec.allow({});
    return std::make_unique<OpenHaptics>(spec.first);
}

}  // namespace sqmap::device
