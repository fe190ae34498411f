#include "touch/run.h"

#include "device/handover.h"

#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>

namespace sqmap::app {
namespace {

std::atomic<bool> interrupted{false};
extern "C" void interrupt(int) { interrupted = true; }

double thread_cpu()
{
    timespec t{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// True once Enter was pressed, where there is somebody to press it.
bool entered()
{
    pollfd in{STDIN_FILENO, POLLIN, 0};
    char text[64];
    return ::isatty(STDIN_FILENO) == 1 && ::poll(&in, 1, 0) > 0 && ::read(STDIN_FILENO, text, sizeof text) > 0;
}

/// Findings of a tick that the servo's own record of it lacks.
struct TickForces {
    std::uint64_t tick = 0;
    std::uint32_t contacts = 0, input = 0;
    double depth = 0, device_depth = 0;
};

struct ServoTouch {
    ServoTouch(TouchSetup& touched, std::size_t zone_count) : setup(touched), zones(zone_count) {}

    TouchSetup& setup;
    std::size_t zones;
    device::TraceRow row{};
    device::Ring<TickForces, 2048> forces{};
};

std::uint32_t servo_tick(void* context, const device::TickInput& input, std::span<haptic::Wrench> wrenches) noexcept
{
    ServoTouch& f = *static_cast<ServoTouch*>(context);
    f.row.dt = input.dt;
    f.row.poses = input.sample.poses;
    f.row.twists = input.sample.twists;
    f.row.input =
        (input.sample.has_twist ? device::k_trace_measured_twist : 0u) | (input.degraded ? device::k_trace_degraded : 0u);
    f.setup.step(f.row);
    std::copy_n(f.row.computed.begin(), std::min(f.zones, wrenches.size()), wrenches.begin());
    std::copy_n(f.setup.pushes().begin(), std::min(f.zones, input.pushes.size()), input.pushes.begin());
    (void)f.forces.push({input.tick, f.row.contacts, f.row.input, f.row.depth, f.setup.device_depth()});
    return f.row.status;
}

}  // namespace

void catch_interrupts()
{
    struct sigaction action {};
    action.sa_handler = interrupt;
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
}

Totals play(device::Device& path, TouchSetup& setup, const haptic::SafetyOptions& safety, const RunOptions& options)
{
    const device::Capabilities& capabilities = path.capabilities();
    const std::size_t zones = capabilities.zones;
    haptic::SafetyFilter filter(device::safety_limits(capabilities, 1 / capabilities.rate), safety);
    if (filter.setup_status() != haptic::SetupStatus::Ok) throw BadTouch(haptic::describe(filter.setup_status()));
    Totals totals;
    device::Sample sample;
    device::TraceRow row;
    row.dt = 1 / capabilities.rate;
    // As many ticks as a script of so many seconds has.
    const double ticks = std::round(options.seconds * capabilities.rate);
    while (!interrupted && static_cast<double>(totals.ticks) < ticks && path.read(sample)) {
        const double begin = thread_cpu();
        row.sequence = sample.sequence;
        row.time = static_cast<double>(sample.sequence - 1) / capabilities.rate;
        row.poses = sample.poses;
        setup.step(row);
        const haptic::SafetyReport report = filter.tick({.time = row.time,
                                                         .sample_time = row.time,
                                                         .sequence = sample.sequence,
                                                         .poses = {row.poses.data(), zones},
                                                         .commanded = {row.computed.data(), zones},
                                                         .pushes = setup.pushes()},
                                                        {row.sent.data(), zones});
        row.filter = haptic::bits(report);
        row.cpu = thread_cpu() - begin;
        path.write({row.sent.data(), zones});
        totals.add(row, zones, setup.device_depth());
        if (options.writer != nullptr) options.writer->push_wait(row);
    }
    totals.counted = filter.counters();
    return totals;
}

Totals run_servo(device::Device& device, TouchSetup& setup, const device::ServoOptions& servo_options, const RunOptions& options)
{
    const std::size_t zones = device.capabilities().zones;
    const auto servo_touch = std::make_unique<ServoTouch>(setup, zones);
    Totals totals;
    {
        device::Servo servo(device, servo_options, servo_tick, servo_touch.get());
        device::ServoTick tick;
        TickForces newest;  // that was popped: of this tick or of a later one
        std::optional<double> begin;
        bool more = true;
        std::uint32_t reported = 0, reported_inside = 0;
        while (more) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            if (entered()) servo.resume();
            while (more && servo.next(tick)) {
                // Ticks come in order on both ways; one that only one of them holds was idle, or dropped by the other. A device
                // may go while a tick runs: what was computed for it counts.
                while (newest.tick < tick.tick && servo_touch->forces.pop(newest)) {
                }
                const bool ran = newest.tick == tick.tick, idle = !ran && (!tick.connected || tick.sample.sequence == 0);
                const TickForces forces = ran ? newest : TickForces{.tick = tick.tick, .input = device::k_trace_idle};
                if (!begin) begin = tick.time;
                device::TraceRow row{.time = tick.time - *begin,
                                     .dt = tick.dt,
                                     .sequence = tick.sample.sequence,
                                     .buttons = tick.sample.buttons,
                                     .input = forces.input,
                                     .cpu = tick.cpu,
                                     .contacts = forces.contacts,
                                     .depth = forces.depth,
                                     .status = tick.status,
                                     .filter = haptic::bits(tick.safety),
                                     .poses = tick.sample.poses,
                                     .computed = tick.commanded,
                                     .sent = tick.sent};
                if (tick.sample.has_twist) row.twists = tick.sample.twists;
                totals.add(row, zones, forces.device_depth);
                totals.counted = tick.counted;
                if (tick.safety.faults != 0 && reported == 0)
                    std::fprintf(stderr, "  no force from %.3f s on: %s%s\n", row.time, reasons(tick.safety.faults).c_str(),
                                 ::isatty(STDIN_FILENO) == 1 ? "; Enter goes on" : "");
                reported = tick.safety.faults;
                if (const std::uint32_t more_inside = tick.safety.waiting & ~reported_inside; more_inside != 0) {
                    reported_inside |= more_inside;
                    for (std::size_t z = 0; z < zones; ++z)
                        if ((more_inside >> z & 1) != 0)
                            std::fprintf(stderr, "  %s is inside an object at %.3f s: no force until it is lifted out once\n",
                                         zone_name(z, zones, options.glove).c_str(), row.time);
                }
                totals.gone = !tick.connected;
                if (!ran && !idle)
                    ++totals.unknown;
                else if (options.writer != nullptr)
                    options.writer->push_wait(row);
                more = row.time < options.seconds;
            }
            more = more && !interrupted;
        }
        totals.servo = servo.counters();
    }
    return totals;
}

}  // namespace sqmap::app
