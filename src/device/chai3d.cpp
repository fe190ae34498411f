// Any device that CHAI3D drives. Compiled against declarations of ours in the tests; not tried on hardware.
#include "device/families.h"
#include "device/threaded.h"

#include <chai3d.h>

namespace sqmap::device {
namespace {

class Chai3d final : public ThreadedDevice {
public:
    explicit Chai3d(unsigned index)
    {
        if (!handler_.getDevice(device_, index) || !device_->open())
            throw DeviceError("chai3d: there is no device " + std::to_string(index));
        device_->calibrate();
        device_->enableForces(true);
        const chai3d::cHapticDeviceInfo info = device_->getSpecifications();
        capabilities_ = {.name = info.m_manufacturerName + " " + info.m_modelName + " (CHAI3D)",
                         .rotates_in = info.m_sensedRotation,
                         .force_out = info.m_actuatedPosition,
                         .torque_out = info.m_actuatedRotation,
                         .max_force = info.m_maxLinearForce,
                         .max_torque = info.m_maxAngularTorque};
        start([this] { run(); });
        if (wait_for_sample(2)) return;
        close();
        throw DeviceError("chai3d: the device gives no reading");
    }
    ~Chai3d() override { close(); }

private:
    void close() noexcept
    {
        stop();
        device_->setForceAndTorqueAndGripperForce(chai3d::cVector3d(0, 0, 0), chai3d::cVector3d(0, 0, 0), 0);
        device_->enableForces(false);
        device_->close();
    }

    void run()
    {
        while (!stopping()) {
            chai3d::cVector3d p, v, w;
            chai3d::cMatrix3d r;
            unsigned int buttons = 0;
            const bool good = device_->getPosition(p) && (!capabilities_.rotates_in || device_->getRotation(r));
            const bool moving = device_->getLinearVelocity(v) && (!capabilities_.rotates_in || device_->getAngularVelocity(w));
            (void)device_->getUserSwitches(buttons);
            const double time = now();
            if (good) {
                Sample sample;
                sample.time = time;
                sample.poses[0].translation = {p(0), p(1), p(2)};
                if (capabilities_.rotates_in)
                    for (int i = 0; i < 3; ++i) sample.poses[0].rotation.row[i] = {r(i, 0), r(i, 1), r(i, 2)};
                sample.twists[0] = {{v(0), v(1), v(2)}, {w(0), w(1), w(2)}};
                sample.has_twist = moving;
                sample.buttons = buttons;
                channel_.publish(sample);
            } else {
                channel_.lose();
            }
            const Wrench& out = channel_.output(time)[0];
            if (!device_->setForceAndTorqueAndGripperForce(chai3d::cVector3d(out.force.x, out.force.y, out.force.z),
                                                           chai3d::cVector3d(out.torque.x, out.torque.y, out.torque.z), 0) ||
                !good)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            else
                // Some of CHAI3D's drivers return at once: without a pause this loop would take a whole core.
                std::this_thread::sleep_for(std::chrono::microseconds(250));
        }
    }

    chai3d::cHapticDeviceHandler handler_;
    chai3d::cGenericHapticDevicePtr device_;
};

}  // namespace

void list_chai3d(std::vector<DeviceListing>& list)
{
    chai3d::cHapticDeviceHandler handler;
    const unsigned count = handler.getNumDevices();
    list.push_back({"chai3d",
                    count > 0 ? Presence::Here : Presence::Absent,
                    std::to_string(count) + " devices found by CHAI3D",
                    {.name = "CHAI3D", .rotates_in = true, .force_out = true}});
}

std::unique_ptr<Device> open_chai3d(const DeviceSpec& spec)
{
    spec.allow({});
    return std::make_unique<Chai3d>(static_cast<unsigned>(spec.index(0, 0, 64)));
}

}  // namespace sqmap::device
