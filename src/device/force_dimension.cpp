// Force Dimension omega, delta, sigma and Novint Falcon through the DHD SDK. Compiled against declarations of ours in the tests;
// not tried on hardware.
#include "device/families.h"
#include "device/threaded.h"

#include <dhdc.h>

namespace sqmap::device {
namespace {

class ForceDimension final : public ThreadedDevice {
public:
    explicit ForceDimension(int index) : id_(static_cast<char>(dhdOpenID(static_cast<char>(index))))
    {
        if (id_ < 0) throw DeviceError(std::string("forcedimension: ") + dhdErrorGetLastStr());
        const char* const name = dhdGetSystemName(id_);
        capabilities_ = {.name = std::string(name != nullptr ? name : "device") + " (Force Dimension)",
                         .rotates_in = dhdHasWrist(id_),
                         .force_out = true,
                         .torque_out = dhdHasActiveWrist(id_)};
        // Brakes: the motors damp while no force is commanded, also when this program dies.
        dhdEnableForce(DHD_ON, id_);
        start([this] { run(); });
        if (wait_for_sample(2)) return;
        close();
        throw DeviceError("forcedimension: the device gives no reading");
    }
    ~ForceDimension() override { close(); }

private:
    void close() noexcept
    {
        stop();
        dhdSetForceAndTorqueAndGripperForce(0, 0, 0, 0, 0, 0, 0, id_);
        dhdEnableForce(DHD_OFF, id_);
        dhdClose(id_);
    }

    void run()
    {
        while (!stopping()) {
            double p[3] = {}, r[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, v[3] = {}, w[3] = {};
            const bool good = dhdGetPositionAndOrientationFrame(&p[0], &p[1], &p[2], r, id_) >= 0 &&
                              dhdGetLinearVelocity(&v[0], &v[1], &v[2], id_) >= 0;
            const bool turning = dhdGetAngularVelocityRad(&w[0], &w[1], &w[2], id_) >= 0;
            const double time = now();
            if (good) {
                Sample sample;
                sample.time = time;
                sample.poses[0].translation = {p[0], p[1], p[2]};
                for (int i = 0; i < 3; ++i) sample.poses[0].rotation.row[i] = {r[i][0], r[i][1], r[i][2]};
                sample.twists[0] = {{v[0], v[1], v[2]}, {w[0], w[1], w[2]}};
                sample.has_twist = turning || !capabilities_.rotates_in;
                sample.buttons = dhdGetButtonMask(id_);
                channel_.publish(sample);
            } else {
                channel_.lose();
            }
            const Wrench& out = channel_.output(time)[0];
            // The SDK itself waits for the device: this loop runs as fast as that answers.
            if (dhdSetForceAndTorqueAndGripperForce(out.force.x, out.force.y, out.force.z, out.torque.x, out.torque.y,
                                                    out.torque.z, 0, id_) < 0 ||
                !good)
                dhdSleep(0.001);
        }
    }

    char id_;
};

}  // namespace

void list_force_dimension(std::vector<DeviceListing>& list)
{
    const int count = dhdGetDeviceCount();
    list.push_back({"forcedimension",
                    count > 0 ? Presence::Here : Presence::Absent,
                    std::to_string(count > 0 ? count : 0) + " devices plugged in",
                    {.name = "Force Dimension", .rotates_in = true, .force_out = true}});
}

std::unique_ptr<Device> open_force_dimension(const DeviceSpec& spec)
{
    spec.allow({});
    return std::make_unique<ForceDimension>(spec.index(-1, -1, 64));
}

}  // namespace sqmap::device
