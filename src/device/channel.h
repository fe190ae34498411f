// Carries poses from a device's thread, which may wait for hardware, to the servo, which may not, and wrenches back.
#pragma once

#include "device/handover.h"
#include "sqmap/device/device.h"
#include "sqmap/haptic/safety.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

namespace sqmap::device {

/// Monotonic clock, s: the time of samples.
[[nodiscard]] double now() noexcept;

/// A device sends no wrench older than this: its servo has stopped. The last line of defence, behind the safety filter's own.
inline constexpr double k_wrench_timeout = 0.020;

/// The exchange between one device and the servo. Wait-free, no allocation.
class Channel {
public:
    // For the device's own thread.
    /// A fresh reading; sets its sequence number.
    void publish(Sample sample) noexcept;
    /// Makes the servo's next read() give NaN once, even if a good pose has come since: the client sent an impossible pose.
    void spoil() noexcept { spoilt_.fetch_add(1, std::memory_order_acq_rel); }
    /// The device is gone: read and write answer false until the next publish.
    void lose() noexcept { alive_.store(false, std::memory_order_release); }
    /// The wrenches to exert now: the newest of each zone; zero after zero(), for a value that is not finite and for wrenches
    /// older than k_wrench_timeout.
    [[nodiscard]] const std::array<Wrench, k_max_zones>& output(double time) noexcept;
    /// The safety filter's report on the last output(); has k_acted_off if output() withheld the wrenches.
    [[nodiscard]] std::uint32_t filter() const noexcept { return filter_; }

    // For the servo: the functions of Device.
    bool read(Sample& sample) noexcept;
    void report(std::uint32_t filter) noexcept { reported_ = filter; }
    bool write(std::span<const Wrench> wrenches) noexcept;
    /// Any thread.
    void zero() noexcept { zeros_.fetch_add(1, std::memory_order_acq_rel); }

private:
    struct Packet {
        std::array<Wrench, k_max_zones> wrenches{};
        double time = 0;
        std::uint64_t zeros = 0;   ///< calls of zero() before it was written
        std::uint32_t filter = 0;  ///< the safety filter's report on the wrenches
    };
    Newest<Sample> samples_;
    Newest<Packet> packets_;
    std::array<Wrench, k_max_zones> output_{};
    std::uint32_t filter_ = haptic::k_acted_off;
    std::uint32_t reported_ = 0;  ///< the servo's
    std::uint64_t sequence_ = 0;
    bool have_sample_ = false, have_packet_ = false;
    std::atomic<bool> alive_{false};
    std::atomic<std::uint64_t> zeros_{0}, spoilt_{0};
    std::uint64_t seen_spoilt_ = 0;  ///< the servo's
};

}  // namespace sqmap::device
