// A servo without threads: its caller runs the ticks that are due, in bursts, in a time that advances by one period a tick.
#include "channel.h"
#include "servo_tick.h"

#include <algorithm>

namespace sqmap::device {
namespace {

constexpr double k_longest_burst = 0.05;  // s of ticks that are caught up

}  // namespace

struct Servo::Work {
    Work(Device& d, const ServoOptions& o, TickFunction t, void* c) : device(d), options(o), tick(d, o, t, c) {}

    /// True when a tick is due. Counts the ticks that lie more than a burst behind as missed.
    bool is_due() noexcept
    {
        const double behind = device::now() - next;
        if (behind > k_longest_burst) {
            const auto skipped = static_cast<std::uint64_t>((behind - k_longest_burst) / options.period);
            counters.missed += skipped;
            next += static_cast<double>(skipped) * options.period;
        }
        return behind >= 0;
    }

    void run() noexcept
    {
        const double begin = device::now();
        now.tick = ++counters.ticks;
        time += options.period;
        now.time = time;
        now.dt = options.period;
        now.late = 0;  // a burst is as late as its call: ticks within have no deadline of their own
        tick.run(now, acts);
        acts.resume = acts.restart = false;
        if (acts.stop) {
            now.sent.fill({});
            device.zero();
        }
        device.report(haptic::bits(now.safety));
        if (!device.write({now.sent.data(), tick.zones()})) now.connected = false;
        if (acts.stop) device.zero();
        now.cpu = device::now() - begin;
        if (now.cpu > options.budget * options.period) ++counters.overruns;
        next += options.period;
    }

    Device& device;
    const ServoOptions options;
    TickWork tick;
    ServoTick now{};
    TickActs acts{};
    ServoCounters counters{};
    double next = device::now(), time = next;  ///< s: due time of the next tick; time of the last
};

Servo::Servo(Device& device, const ServoOptions& options, TickFunction tick, void* context)
    : work_(std::make_unique<Work>(device, options, tick, context))
{
}

Servo::~Servo() { work_->device.zero(); }

void Servo::stop() noexcept
{
    work_->acts.stop = true;
    work_->device.zero();
}

void Servo::resume() noexcept
{
    work_->acts.stop = false;
    work_->acts.resume = true;
}

void Servo::hold(bool held) noexcept { work_->acts.held = held; }
void Servo::restart() noexcept { work_->acts.restart = true; }
ServoCounters Servo::counters() const noexcept { return work_->counters; }

bool Servo::newest(ServoTick& tick) noexcept
{
    bool any = false;
    while (next(tick)) any = true;
    return any;
}

bool Servo::next(ServoTick& tick) noexcept
{
    if (!work_->is_due()) return false;
    work_->run();
    tick = work_->now;
    return true;
}

}  // namespace sqmap::device
