// SpaceNavigator and its kin through libspnav and the daemon spacenavd: six axes in, no force out.
#include "device/families.h"
#include "device/threaded.h"
#include "sqmap/math/rotation.h"

#include <poll.h>
#include <spnav.h>

#include <algorithm>
#include <atomic>

namespace sqmap::device {
namespace {

// libspnav keeps one connection a process.
std::atomic<bool> connected_somewhere{false};

struct Settings {
    double speed = 0.1;  ///< m/s at full deflection
    double turn = 1.5;   ///< rad/s at full deflection
};

constexpr double k_full = 350;  // counts at full deflection with spacenavd's default sensitivity

class Spacenav final : public ThreadedDevice {
public:
    explicit Spacenav(const Settings& settings) : settings_(settings)
    {
        if (connected_somewhere.exchange(true)) throw DeviceError("spacenav: already open in this program");
        if (spnav_open() == -1) {
            connected_somewhere = false;
            throw DeviceError("spacenav: no daemon answers\n  cure: start spacenavd (Debian: package spacenavd)");
        }
        capabilities_ = {.name = "SpaceNavigator (spacenavd)", .rotates_in = true};
        start([this] { run(); });
        wait_for_sample(1);
    }
    ~Spacenav() override
    {
        stop();
        if (open_) spnav_close();
        connected_somewhere = false;
    }

private:
    void run()
    {
        double last = now();
        while (!stopping()) {
            if (!open_) {
                reconnect();
                last = now();
                continue;
            }
            pollfd wait{spnav_fd(), POLLIN | POLLRDHUP, 0};
            ::poll(&wait, 1, 1);
            if ((wait.revents & (POLLHUP | POLLRDHUP | POLLERR | POLLNVAL)) != 0) {
                spnav_close();
                open_ = false;
                motion_ = {};
                sample_.buttons = 0;
                channel_.lose();
                continue;
            }
            spnav_event event;
            for (int i = 0; i < 64 && spnav_poll_event(&event) != 0; ++i) take(event);
            const double time = now();
            if (time - last < 0.5e-3) continue;  // an event in between: the next millisecond has it
            move(time - last);
            last = time;
            sample_.time = time;
            channel_.publish(sample_);
        }
    }

    void reconnect()
    {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        if (now() - tried_ < 0.5) return;
        tried_ = now();
        open_ = spnav_open() != -1;
    }

    void take(const spnav_event& event)
    {
        if (event.type == SPNAV_EVENT_MOTION) {
            // The daemon's z points away from the user, ours towards the user.
            const spnav_event_motion& m = event.motion;
            const auto share = [](int counts) { return std::clamp(counts / k_full, -1.0, 1.0); };
            motion_.linear = settings_.speed * Vec3d{share(m.x), share(m.y), -share(m.z)};
            motion_.angular = settings_.turn * Vec3d{share(m.rx), share(m.ry), -share(m.rz)};
        } else if (event.type == SPNAV_EVENT_BUTTON && event.button.bnum >= 0 && event.button.bnum < 32) {
            const std::uint32_t bit = 1u << event.button.bnum;
            sample_.buttons = event.button.press != 0 ? sample_.buttons | bit : sample_.buttons & ~bit;
        }
    }

    /// Deflection is speed: the knob springs back, the tool stays.
    void move(double dt)
    {
        dt = std::min(dt, 0.05);
        Pose& pose = sample_.poses[0];
        pose.translation += dt * motion_.linear;
        pose.rotation = orthonormal(rotation_by(dt * motion_.angular) * pose.rotation);  // products of rotations drift
        sample_.twists[0] = motion_;
        sample_.has_twist = true;
    }

    Settings settings_;
    bool open_ = true;
    double tried_ = 0;
    Twist motion_{};
    Sample sample_{};
};

}  // namespace

void list_spacenav(std::vector<DeviceListing>& list)
{
    DeviceListing entry{
        "spacenav", Presence::Absent, "spacenavd does not answer", {.name = "SpaceNavigator", .rotates_in = true}};
    if (connected_somewhere.exchange(true)) {
        entry.state = "open in this program";
        entry.presence = Presence::Here;
    } else {
        if (spnav_open() != -1) {
            entry.presence = Presence::Here;
            entry.state = "spacenavd answers";
            spnav_close();
        }
        connected_somewhere = false;
    }
    list.push_back(std::move(entry));
}

std::unique_ptr<Device> open_spacenav(const DeviceSpec& spec)
{
    spec.allow({"speed", "turn"});
    spec.only_named();
    return std::make_unique<Spacenav>(Settings{spec.number("speed", 0.1, 1e-4, 10), spec.number("turn", 1.5, 1e-3, 100)});
}

}  // namespace sqmap::device
