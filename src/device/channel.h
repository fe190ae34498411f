// Between the thread of a device, which may wait for hardware, and the servo, which may not: poses one way, wrenches the other.
#pragma once

#include "sqmap/device/device.h"
#include "sqmap/device/handover.h"
#include "sqmap/haptic/safety.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

namespace sqmap::device {

/// Monotonic clock, s: the time of samples.
[[nodiscard]] double now() noexcept;

/// A wrench this old is not sent any more: the servo has stopped. The last line of defence, behind the safety filter's own.
inline constexpr double k_wrench_timeout = 0.020;

/// What one device and the servo exchange. Wait-free, no allocation.
class Channel {
public:
    // For the device's own thread.
    /// A fresh reading; sets its sequence number.
    void publish(Sample sample) noexcept;
    /// The user's pose was none: the servo reads it once, also where a good one has come since.
    void spoil() noexcept { spoilt_.fetch_add(1, std::memory_order_acq_rel); }
    /// The device is gone: read and write answer false until the next publish.
    void lose() noexcept { alive_.store(false, std::memory_order_release); }
    /// What the device shall exert now: the newest wrench a zone, or none where zero() came since, where it is not finite, or
    /// where it is older than k_wrench_timeout.
    [[nodiscard]] const std::array<Wrench, k_max_zones>& output(double time) noexcept;
    /// What the safety filter did to what output() gave last; k_acted_off where that was cut.
    [[nodiscard]] std::uint32_t filter() const noexcept { return filter_; }

    // For the servo: what Device asks for.
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
        std::uint32_t filter = 0;  ///< what was told of it
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
