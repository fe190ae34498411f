// The servo and who watches it. Nothing here asks how fast it is: what is waited for may take as long as a busy machine needs.
#include "sqmap/device/servo.h"

#include "device/own_process.h"
#include "sqmap/device/simulated.h"

#include <gtest/gtest.h>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <new>
#include <stdexcept>
#include <thread>
#include <vector>

namespace sqmap::device {
namespace {

using namespace std::chrono_literals;

/// Up to half a minute for something to come true.
template <class Condition>
bool wait_for(Condition&& condition)
{
    for (int i = 0; i < 30000; ++i) {
        if (condition()) return true;
        std::this_thread::sleep_for(1ms);
    }
    return false;
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Keeps what it was told last.
class Listener final : public Device {
public:
    Listener()
    {
        capabilities_.zones = 2;
        capabilities_.max_force = 3;
        capabilities_.continuous_force = 3;
        capabilities_.max_torque = 1;
    }
    [[nodiscard]] const Capabilities& capabilities() const noexcept override { return capabilities_; }
    bool read(Sample& sample) noexcept override
    {
        if (!plugged) return false;
        sample.time = now();
        ++sample.sequence;
        sample.resumes = resumes;
        return true;
    }
    void report(std::uint32_t filter) noexcept override { reported = filter; }
    bool write(std::span<const Wrench> wrenches) noexcept override
    {
        force = norm(wrenches[0].force);
        if (force > largest) largest = force.load();
        ++writes;
        return plugged;
    }
    void zero() noexcept override
    {
        force = 0;
        ++zeros;
    }

    std::atomic<double> force{0}, largest{0};
    std::atomic<std::uint64_t> writes{0}, zeros{0};
    std::atomic<bool> plugged{true};
    std::atomic<std::uint32_t> reported{0}, resumes{0};

private:
    Capabilities capabilities_;
};

/// Nothing for a few ticks, so that the filter engages, then a newton.
std::uint32_t newton(void*, const TickInput& input, std::span<Wrench> wrenches) noexcept
{
    if (input.tick % 1000 < 20) return 7;
    for (Wrench& w : wrenches) w.force = {0, 0, 1};
    return 8;
}

constexpr ServoOptions k_quiet{.signals = false};

TEST(Servo, RunsTicksFiltersThemAndHandsOnEveryOne)
{
    Listener device;
    Servo servo(device, k_quiet, newton, nullptr);
    std::vector<std::uint64_t> ticks;
    std::uint64_t newest = 0, wrong = 0;
    ServoTick tick;
    EXPECT_TRUE(wait_for([&] {
        while (servo.next(tick)) {
            ticks.push_back(tick.tick);
            const double largest = norm(tick.sent[1].force);
            wrong += largest > 1 || tick.zones != 2 || !(tick.dt > 0) || tick.sent[2].force.z != 0;
            wrong += tick.status != (tick.tick % 1000 < 20 ? 7u : 8u);
        }
        if (servo.newest(tick)) {
            wrong += tick.tick <= newest;
            newest = tick.tick;
        }
        // All of the force takes half a second without a stall: too much for a busy machine.
        return device.force > 0 && ticks.size() > 100;
    }));
    EXPECT_EQ(wrong, 0u);
    ASSERT_GT(ticks.size(), 100u);
    for (std::size_t i = 0; i < ticks.size() && servo.counters().dropped == 0; ++i) ASSERT_EQ(ticks[i], i + 1);
}

TEST(Servo, StopIsZeroAtOnceAndHoldsUntilResume)
{
    Listener device;
    Servo servo(device, k_quiet, newton, nullptr);
    ASSERT_TRUE(wait_for([&] { return device.force > 0.5; }));
    servo.stop();
    std::uint64_t writes = device.writes;
    ASSERT_TRUE(wait_for([&] { return device.writes > writes + 3; }));
    device.largest = 0;
    writes = device.writes;
    ASSERT_TRUE(wait_for([&] { return device.writes > writes + 50; }));
    EXPECT_EQ(device.largest, 0);
    servo.resume();
    EXPECT_TRUE(wait_for([&] { return device.force > 0.5; }));
}

TEST(Servo, AFaultIsReportedToTheDeviceWhereTheUserResumesToo)
{
    Listener device;
    std::atomic<bool> broken{false};
    const auto tick = [](void* context, const TickInput& input, std::span<Wrench> wrenches) noexcept {
        const std::uint32_t status = newton(nullptr, input, wrenches);
        if (*static_cast<std::atomic<bool>*>(context)) wrenches[0].force.x = std::nan("");
        return status;
    };
    Servo servo(device, k_quiet, tick, &broken);
    ASSERT_TRUE(wait_for([&] { return device.force > 0.5; }));
    EXPECT_EQ(device.reported >> 16, 0u);
    broken = true;
    EXPECT_TRUE(wait_for([&] { return (device.reported >> 16 & haptic::k_fault_not_finite) != 0; }));
    broken = false;
    device.largest = 0;
    const std::uint64_t writes = device.writes;
    ASSERT_TRUE(wait_for([&] { return device.writes > writes + 50; }));
    EXPECT_EQ(device.largest, 0) << "until the user acts";
    ++device.resumes;
    EXPECT_TRUE(wait_for([&] { return device.force > 0.5 && device.reported >> 16 == 0; }));
}

TEST(Servo, WithADeadMansSwitchNobodyHoldsThereIsNoForce)
{
    Listener device;
    Servo servo(device, {.signals = false, .safety = {.dead_man = true}}, newton, nullptr);
    ASSERT_TRUE(wait_for([&] { return device.writes > 100; }));
    EXPECT_EQ(device.largest, 0);
    servo.hold(true);
    EXPECT_TRUE(wait_for([&] { return device.force > 0.5; }));
    servo.hold(false);
    EXPECT_TRUE(wait_for([&] { return device.force == 0; }));
}

/// A tick that hangs until it is let go.
struct Hanging {
    explicit Hanging(const Listener& d) : device(d) {}
    const Listener& device;
    std::atomic<bool> hang{false}, hanging{false};
    std::atomic<double> force{0};  ///< that was on when it began to hang
};
std::uint32_t hanging_tick(void* context, const TickInput& input, std::span<Wrench> wrenches) noexcept
{
    Hanging& h = *static_cast<Hanging*>(context);
    while (h.hang) {
        if (!h.hanging) h.force = h.device.force.load();
        h.hanging = true;
        std::this_thread::sleep_for(1ms);
    }
    h.hanging = false;
    return newton(nullptr, input, wrenches);
}

TEST(Servo, TheWatchdogZeroesWhileATickHangsAndTheServoEngagesAnew)
{
    Listener device;
    Hanging hanging(device);
    Servo servo(device, k_quiet, hanging_tick, &hanging);
    ASSERT_TRUE(wait_for([&] { return device.force > 0.5; }));
    hanging.hang = true;
    ASSERT_TRUE(wait_for([&] { return hanging.hanging.load(); }));
    EXPECT_GT(hanging.force, 0.0) << "hangs with force on";
    EXPECT_TRUE(wait_for([&] { return device.force == 0; })) << "only the watchdog can do this";
    EXPECT_GE(servo.counters().watchdog, 1u);
    device.largest = 0;
    const std::uint64_t writes = device.writes;
    hanging.hang = false;
    ASSERT_TRUE(wait_for([&] { return device.writes > writes + 5; }));
    EXPECT_EQ(device.largest, 0) << "what was answered before it hung is not sent";
}

TEST(Servo, ATickThatTakesTooLongMakesTheNextOneDegraded)
{
    Listener device;
    static std::atomic<std::uint64_t> wrong, degraded;
    wrong = degraded = 0;
    Servo servo(
        device, k_quiet,
        [](void*, const TickInput& input, std::span<Wrench>) noexcept -> std::uint32_t {
            static bool slow = false;
            if (slow && !input.degraded) ++wrong;
            if (input.degraded) ++degraded;
            slow = input.tick % 5 == 0;
            if (slow) {
                const double until = now() + 0.003;
                while (now() < until) {
                }
            }
            return 0;
        },
        nullptr);
    ASSERT_TRUE(wait_for([&] { return servo.counters().ticks > 60; }));
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(degraded, 5u);
    EXPECT_GE(servo.counters().overruns, 5u);
    EXPECT_GE(servo.counters().missed, 10u) << "no burst to catch up";
}

TEST(Servo, AnUnpluggedDeviceGetsNothingButZero)
{
    Listener device;
    Servo servo(device, k_quiet, newton, nullptr);
    ASSERT_TRUE(wait_for([&] { return device.force > 0.5; }));
    device.plugged = false;
    EXPECT_TRUE(wait_for([&] { return device.force == 0; }));
    ServoTick tick;
    EXPECT_TRUE(wait_for([&] { return servo.newest(tick) && !tick.connected; }));
}

TEST(Servo, ItsEndIsZero)
{
    Listener device;
    {
        Servo servo(device, k_quiet, newton, nullptr);
        ASSERT_TRUE(wait_for([&] { return device.force > 0.5; }));
    }
    EXPECT_EQ(device.force, 0);
    const std::uint64_t writes = device.writes;
    std::this_thread::sleep_for(10ms);
    EXPECT_EQ(device.writes, writes);
}

TEST(Servo, RefusesWhatTheFilterRefusesAndSaysWhy)
{
    Listener device;
    const auto reason = [&](const ServoOptions& options) -> std::string {
        try {
            Servo servo(device, options, newton, nullptr);
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_NE(reason({.safety = {.force_limit = 0}}).find("more than zero"), std::string::npos);
    EXPECT_NE(reason({.safety = {.force_limit = 4}}).find("than the device holds"), std::string::npos);
    EXPECT_NE(reason({.period = 1}), "");
    EXPECT_NE(reason({.priority = 99}), "");
    EXPECT_EQ(device.writes, 0u);
}

TEST(Servo, DrivesASimulatedDeviceThroughFaultsToZero)
{
    for (const char* fault : {"nan", "frozen", "unplugged"}) {
        MotorRecord motors;
        SimulatedDevice device({.motors = &motors});
        Servo servo(device, k_quiet, newton, nullptr);
        ASSERT_TRUE(wait_for([&] { return motors.force > 0.5; })) << fault;
        if (*fault == 'n') device.poison(true);
        if (*fault == 'f') device.freeze(true);
        if (*fault == 'u') device.unplug();
        EXPECT_TRUE(wait_for([&] { return motors.force == 0; })) << fault;
        EXPECT_LE(motors.max_force, 1 + 1e-9) << fault;
    }
}

// ---- The end of the process

/// Memory that a child shares with the test.
template <class T>
class SharedWith {
public:
    SharedWith() : at_(new (mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) T) {}
    ~SharedWith() { munmap(at_, sizeof(T)); }
    SharedWith(const SharedWith&) = delete;
    SharedWith& operator=(const SharedWith&) = delete;
    T* operator->() const { return at_; }
    T& operator*() const { return *at_; }

private:
    T* at_;
};

/// A child that runs work; forked before any thread is there.
template <class Work>
pid_t child_that(Work&& work)
{
    const pid_t child = fork();
    if (child == 0) {
        alarm(60);  // never outlives a test that went wrong
        work();
        _exit(0);
    }
    return child;
}

int status_of(pid_t child)
{
    int status = 0;
    waitpid(child, &status, 0);
    return status;
}

void drive_until_the_end(MotorRecord& motors)
{
    SimulatedDevice device({.motors = &motors});
    Servo servo(device, {}, newton, nullptr);
    for (;;) pause();
}

TEST(ServoProcess, SigtermAndSigintZeroTheDeviceThenEndTheProcess)
{
    for (const int signal : {SIGTERM, SIGINT}) {
        SharedWith<MotorRecord> motors;
        const pid_t child = child_that([&] { drive_until_the_end(*motors); });
        ASSERT_TRUE(wait_for([&] { return motors->force > 0.5; }));
        const std::uint64_t zeros = motors->zeros;
        kill(child, signal);
        const int status = status_of(child);
        EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal) << status;
        EXPECT_EQ(motors->force, 0);
        EXPECT_GT(motors->zeros, zeros);
    }
}

std::atomic<bool> g_interrupted{false};

TEST(ServoProcess, AProgramsOwnHandlerStillRunsAfterTheDeviceWasZeroed)
{
    SharedWith<MotorRecord> motors;
    const pid_t child = child_that([&] {
        std::signal(SIGINT, [](int) { g_interrupted = true; });
        SimulatedDevice device({.motors = &*motors});
        Servo servo(device, {}, newton, nullptr);
        while (!g_interrupted) std::this_thread::sleep_for(1ms);
        _exit(motors->force == 0 ? 42 : 43);
    });
    ASSERT_TRUE(wait_for([&] { return motors->force > 0.5; }));
    kill(child, SIGINT);
    const int status = status_of(child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 42) << status;
}

TEST(ServoProcess, TerminateAndExitZeroTheDevice)
{
    for (const bool terminate : {true, false}) {
        SharedWith<MotorRecord> motors;
        const pid_t child = child_that([&] {
            // Never destroyed, as in a program that leaves in a hurry.
            static SimulatedDevice* const device = new SimulatedDevice({.motors = &*motors});
            static Servo* const servo = new Servo(*device, {}, newton, nullptr);
            (void)servo;
            while (!(motors->force > 0.5)) std::this_thread::sleep_for(1ms);
            if (terminate) std::terminate();
            std::exit(0);
        });
        const int status = status_of(child);
        EXPECT_TRUE(terminate ? WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT : WIFEXITED(status)) << status;
        EXPECT_GT(motors->max_force, 0.5);
        EXPECT_GT(motors->zeros, 0u);
        EXPECT_EQ(motors->force, 0);
    }
}

struct Kept {
    MotorRecord motors;
    Mechanism mechanism{};
};
std::unique_ptr<Device> open_kept(void* context)
{
    Kept& kept = *static_cast<Kept*>(context);
    return std::make_unique<SimulatedDevice>(SimulatedOptions{.mechanism = kept.mechanism, .motors = &kept.motors});
}

void drive_kept(Kept& kept, double timeout)
{
    const std::unique_ptr<Device> device = keep_in_own_process(open_kept, &kept, {.timeout = timeout});
    Servo servo(*device, {}, newton, nullptr);
    for (;;) pause();
}

TEST(ServoProcess, WhenTheProgramIsKilledTheKeeperLetsTheDeviceGo)
{
    for (const int signal : {SIGKILL, SIGSTOP}) {
        SharedWith<Kept> kept;
        kept->mechanism.timeout = 1000;  // the keeper alone
        const pid_t child = child_that([&] { drive_kept(*kept, 0.02); });
        ASSERT_TRUE(wait_for([&] { return kept->motors.force > 0.5; }));
        kill(child, signal);
        EXPECT_TRUE(wait_for([&] { return kept->motors.force == 0; }));
        std::this_thread::sleep_for(50ms);
        EXPECT_EQ(kept->motors.force, 0) << "and it stays so";
        EXPECT_LE(kept->motors.max_force, 1 + 1e-9);
        RecordProperty(signal == SIGKILL ? "let_go_ms_after_sigkill" : "let_go_ms_after_sigstop",
                       std::to_string(1e3 * (kept->motors.let_go - kept->motors.last_write)));
        if (signal == SIGSTOP) kill(child, SIGKILL);
        EXPECT_EQ(WTERMSIG(status_of(child)), SIGKILL);
    }
}

TEST(ServoProcess, TheDevicesOwnTimeOutActsWhenNobodyElseDoes)
{
    SharedWith<Kept> kept;
    const pid_t child = child_that([&] { drive_kept(*kept, 0.1); });  // a keeper five times as patient as the device
    ASSERT_TRUE(wait_for([&] { return kept->motors.force > 0.5; }));
    kill(child, SIGSTOP);
    EXPECT_TRUE(wait_for([&] { return kept->motors.force == 0; }));
    // In the device's own time, whatever the machine is busy with: 20 ms and the tick in which it is noticed.
    EXPECT_LE(kept->motors.let_go - kept->motors.last_write, 0.0221);
    kill(child, SIGKILL);
    status_of(child);
}

TEST(Keeper, HandsThroughWhatTheDeviceSaysAndThrowsWhatItThrows)
{
    {
        Kept kept;
        const std::unique_ptr<Device> device = keep_in_own_process(open_kept, &kept);
        const Capabilities& c = device->capabilities();
        EXPECT_TRUE(c.simulated && c.force_out && c.rotates_in && !c.rumble_out);
        EXPECT_EQ(c.max_force, Mechanism{}.max_force);
        EXPECT_GT(c.continuous_force, 10 * c.max_force) << "no motors that heat";
        EXPECT_EQ(c.resolution, Mechanism{}.resolution);
        EXPECT_EQ(c.coulomb_friction, Mechanism{}.coulomb_friction);
        EXPECT_EQ(c.damping, Mechanism{}.damping);
        EXPECT_EQ(c.rate, 1000);
        EXPECT_EQ(c.delay, 2e-3) << "the device's own tick and the keeper's";
        EXPECT_NE(c.name.find("simulated"), std::string::npos);
        Sample sample;
        EXPECT_TRUE(wait_for([&] { return device->read(sample) && sample.sequence > 5; }));
    }
    try {
        (void)keep_in_own_process([](void*) -> std::unique_ptr<Device> { throw std::runtime_error("not plugged in"); }, nullptr);
        FAIL();
    } catch (const std::runtime_error& e) {
        EXPECT_STREQ(e.what(), "not plugged in");
    }
    EXPECT_THROW((void)keep_in_own_process(open_kept, nullptr, {.timeout = 1}), std::invalid_argument);
}

}  // namespace
}  // namespace sqmap::device
