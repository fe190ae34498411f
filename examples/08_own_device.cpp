// A device of one's own on the servo: the loop reads it every millisecond, computes a force, filters it and writes it.
#include <sqmap/device/servo.h>
#include <sqmap/sqmap.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

using namespace sqmap;

/// A motor on a slide that a hand pushes down, made up: replace read, write and zero by calls of your hardware.
class Slide final : public device::Device {
public:
    Slide()
    {
        capabilities_.name = "slide";
        capabilities_.simulated = true;
        capabilities_.force_out = true;
        capabilities_.max_force = 3;
    }
    const device::Capabilities& capabilities() const noexcept override { return capabilities_; }
    bool read(device::Sample& sample) noexcept override
    {
        sample.time = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
        ++sample.sequence;
        height_ = std::max(height_ - 2e-5, -0.002);
        sample.poses[0].translation = {0, 0, height_};
        return true;
    }
    bool write(std::span<const haptic::Wrench> wrenches) noexcept override
    {
        force_ = wrenches[0].force.z;
        return true;
    }
    void zero() noexcept override { force_ = 0; }

private:
    device::Capabilities capabilities_;
    double height_ = 0.01;           // m
    std::atomic<double> force_ = 0;  // N; zero() may be called by any thread
};

int main()
{
    Slide slide;
    // A floor at height zero of 500 N/m. Runs on the servo's thread: it must not wait, allocate or throw.
    const device::TickFunction floor = [](void*, const device::TickInput& in, std::span<haptic::Wrench> wrenches) noexcept {
        wrenches[0].force = {0, 0, 500 * std::max(0.0, -in.sample.poses[0].translation.z)};
        return 0u;
    };
    device::Servo servo(slide, {}, floor, nullptr);
    device::ServoTick last;
    while (last.tick < 2000) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        servo.newest(last);
    }
    std::printf("%.1f N commanded, %.1f N sent\n", last.commanded[0].force.z, last.sent[0].force.z);
}
