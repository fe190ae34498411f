#include "device/channel.h"

#include "device/threaded.h"
#include "sqmap/math/rotation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace sqmap::device {

double now() noexcept
{
    using std::chrono::nanoseconds;
    const auto since = std::chrono::duration_cast<nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
    return static_cast<double>(since / 1'000'000'000) + 1e-9 * static_cast<double>(since % 1'000'000'000);
}

bool unit_rotation(double w, double x, double y, double z, Mat3d& rotation) noexcept
{
    const double length = std::sqrt(w * w + x * x + y * y + z * z);
    if (!(std::abs(length - 1) <= 1e-3)) return false;
    rotation = rotation_of(w / length, x / length, y / length, z / length);
    return true;
}

void Channel::publish(Sample sample) noexcept
{
    sample.sequence = ++sequence_;
    samples_.put(sample);
    alive_.store(true, std::memory_order_release);
}

bool Channel::read(Sample& sample) noexcept
{
    if (!alive_.load(std::memory_order_acquire)) return false;
    have_sample_ |= samples_.take();
    if (!have_sample_) return false;
    sample = samples_.value();
    const std::uint64_t spoilt = spoilt_.load(std::memory_order_acquire);
    if (spoilt != seen_spoilt_) sample.poses[0].translation.x = std::numeric_limits<double>::quiet_NaN();
    seen_spoilt_ = spoilt;
    return true;
}

bool Channel::write(std::span<const Wrench> wrenches) noexcept
{
    Packet packet;
    // Read first, so that any later zero() cancels this packet.
    packet.zeros = zeros_.load(std::memory_order_acquire);
    std::copy_n(wrenches.begin(), std::min(wrenches.size(), k_max_zones), packet.wrenches.begin());
    packet.time = now();
    packet.filter = reported_;
    packets_.put(packet);
    return alive_.load(std::memory_order_acquire);
}

const std::array<Wrench, k_max_zones>& Channel::output(double time) noexcept
{
    have_packet_ |= packets_.take();
    const Packet& packet = packets_.value();
    output_ = {};
    filter_ = packet.filter | haptic::k_acted_off;
    if (!have_packet_ || packet.zeros != zeros_.load(std::memory_order_acquire) || time - packet.time > k_wrench_timeout)
        return output_;
    filter_ = packet.filter;
    for (std::size_t i = 0; i < k_max_zones; ++i)
        if (is_finite(packet.wrenches[i].force) && is_finite(packet.wrenches[i].torque)) output_[i] = packet.wrenches[i];
    return output_;
}

}  // namespace sqmap::device
