// A device whose input and output wait for hardware: its own thread does that, the servo sees a channel.
#pragma once

#include "device/channel.h"
#include "sqmap/device/device.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>
#include <utility>

namespace sqmap::device {

class ThreadedDevice : public Device {
public:
    ThreadedDevice(const ThreadedDevice&) = delete;
    ThreadedDevice& operator=(const ThreadedDevice&) = delete;
    [[nodiscard]] const Capabilities& capabilities() const noexcept final { return capabilities_; }
    bool read(Sample& sample) noexcept final { return channel_.read(sample); }
    void report(std::uint32_t filter) noexcept final { channel_.report(filter); }
    bool write(std::span<const Wrench> wrenches) noexcept final { return channel_.write(wrenches); }
    void zero() noexcept final { channel_.zero(); }

protected:
    ThreadedDevice() = default;
    /// Derived classes call stop() in their own destructors, before the members that the thread uses are destroyed.
    ~ThreadedDevice() override = default;

    template <class Loop>
    void start(Loop loop)
    {
        thread_ = std::thread(std::move(loop));
    }
    void stop() noexcept
    {
        stopping_ = true;
        if (thread_.joinable()) thread_.join();
    }
    [[nodiscard]] bool stopping() const noexcept { return stopping_; }
    /// Waits until the thread has published a first sample, for this long at most. False if it has not.
    bool wait_for_sample(double seconds) noexcept
    {
        const double end = now() + seconds;
        Sample sample;
        while (!channel_.read(sample)) {
            if (now() > end) return false;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return true;
    }

    Channel channel_;
    Capabilities capabilities_;  ///< written before the device is handed out, never again

private:
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

/// The rotation of a quaternion of nearly unit length (within a thousandth), made unit. False for any other.
[[nodiscard]] bool unit_rotation(double w, double x, double y, double z, Mat3d& rotation) noexcept;

}  // namespace sqmap::device
