// A program with a device of its own: the servo drives it, a trace records it. It links threads and nothing else.
#include <sqmap/device/path.h>
#include <sqmap/device/servo.h>
#include <sqmap/device/trace.h>

#include <chrono>
#include <cstdio>
#include <thread>

int main()
{
    std::vector<sqmap::Pose> poses(100000);
    sqmap::device::PathDevice device("a path", poses, 1000);
    sqmap::device::ServoTick tick;
    {
        sqmap::device::Servo servo(
            device, {}, [](void*, const sqmap::device::TickInput&, std::span<sqmap::haptic::Wrench>) noexcept { return 7u; },
            nullptr);
        while (!servo.next(tick)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    sqmap::device::TraceWriter writer("consumer.csv", {});
    writer.push_wait({.time = 0.5, .status = tick.status});
    writer.finish();
    sqmap::device::TraceReader reader("consumer.csv");
    sqmap::device::TraceRow row;
    const bool read = reader.next(row);
    std::printf("read %d, time %g, status %u\n", read, row.time, row.status);
    return read && row.time == 0.5 && row.status == 7 ? 0 : 1;
}
