#include "sqmap/device/servo.h"

#include "clock.h"
#include "device/handover.h"
#include "servo_tick.h"

#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace sqmap::device {

namespace {

constexpr std::int64_t k_heartbeat = 20'000'000;  // ns that a heartbeat may be old
constexpr std::int64_t k_watch = 5'000'000;       // ns between two looks at it
constexpr std::int64_t k_settle = 200'000'000;    // ns that an ending process waits for its servos at most
constexpr std::int64_t k_look = 500'000;          // ns between two looks at `settled`
constexpr std::size_t k_max_servos = 8;

double seconds(std::int64_t ns) noexcept { return static_cast<double>(ns) * 1e-9; }

void count(std::atomic<std::uint64_t>& counter, std::uint64_t by = 1) noexcept
{
    counter.fetch_add(by, std::memory_order_relaxed);
}

}  // namespace

struct Servo::Work {
    Work(Device& d, const ServoOptions& o, TickFunction t, void* c)
        : device(d), options(o), period(std::llround(o.period * 1e9)), tick(d, o, t, c)
    {
    }

    void start();
    void end() noexcept;
    void halt() noexcept;
    void loop() noexcept;
    void watch() noexcept;
    static void halt_all() noexcept;
    static void leave_by_signal(int signal) noexcept;

    Device& device;
    const ServoOptions options;
    const std::int64_t period;

    // The servo's thread alone.
    TickWork tick;
    ServoTick now{};

    // Between threads.
    static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);
    std::atomic<bool> settled{false};  // the servo has seen `halted` and zeroed the device after its last write
    std::atomic<bool> quit{false}, halted{false}, stopped{false}, resumed{false}, restarted{false}, held{false};
    std::atomic<std::int64_t> heartbeat{0};
    std::atomic<std::uint64_t> ticks{0}, late{0}, missed{0}, overruns{0}, degraded{0}, watchdog{0}, dropped{0};
    std::atomic<double> worst_late{0};
    Newest<ServoTick> newest;
    Ring<ServoTick, 1024> ring;
    std::thread servo_thread, watchdog_thread;
};

// ---- All servos of the process, for signals, exit and terminate

namespace {

// The running servos: a signal handler, std::exit or std::terminate can reach them.
std::atomic<void*> g_servos[k_max_servos];
std::atomic<int> g_signal{0};  // the last signal that no watchdog has handled yet
std::once_flag g_handlers;
std::terminate_handler g_terminate = nullptr;
struct sigaction g_before_int, g_before_term;
std::atomic<bool> g_caught{false};  // our handlers are in place

static_assert(std::atomic<int>::is_always_lock_free && std::atomic<void*>::is_always_lock_free);

/// Only stores the signal: the watchdogs, awake every 5 ms, do the work that a handler may not do.
extern "C" void sqmap_note_signal(int signal) { g_signal.store(signal); }

void catch_signals()
{
    if (g_caught.exchange(true)) return;
    struct sigaction action = {};
    action.sa_handler = sqmap_note_signal;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, &g_before_int);
    sigaction(SIGTERM, &action, &g_before_term);
}

}  // namespace

void Servo::Work::halt() noexcept
{
    halted = true;
    device.zero();
}

/// Zeroes every device and waits until every servo has seen it: a servo that lost its core just before its write may still write.
/// Waits k_settle at most, since a tick may hang or call this itself.
void Servo::Work::halt_all() noexcept
{
    const auto each = [](auto&& f) {
        for (const std::atomic<void*>& servo : g_servos)
            if (void* work = servo.load()) f(*static_cast<Work*>(work));
    };
    each([](Work& work) { work.halt(); });
    for (const std::int64_t end = clock_ns() + k_settle; clock_ns() < end;) {
        bool settled = true;
        each([&](const Work& work) { settled = settled && work.settled; });
        if (settled) break;
        sleep_until(clock_ns() + k_look);
    }
    each([](Work& work) { work.halt(); });
}

void Servo::Work::start()
{
    std::call_once(g_handlers, [] {
        std::atexit([] { halt_all(); });
        g_terminate = std::set_terminate([] {
            halt_all();
            if (g_terminate != nullptr) g_terminate();
            std::abort();
        });
    });
    if (options.signals) catch_signals();
    bool entered = false;
    for (std::atomic<void*>& servo : g_servos) {
        void* none = nullptr;
        if (servo.compare_exchange_strong(none, this)) {
            entered = true;
            break;
        }
    }
    if (!entered) throw std::invalid_argument("at most 8 servos run at a time");
    if (options.lock_memory && mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
        throw std::system_error(errno, std::generic_category(), "memory cannot be locked (ulimit -l)");

    heartbeat = clock_ns();
    const auto give = [](std::thread& thread, int priority) {
        if (priority <= 0) return;
        const sched_param param{priority};
        if (const int error = pthread_setschedparam(thread.native_handle(), SCHED_FIFO, &param))
            throw std::system_error(error, std::generic_category(), "SCHED_FIFO is not granted (ulimit -r; see sqmap rtcheck)");
    };
    watchdog_thread = std::thread([this] { watch(); });
    give(watchdog_thread, options.priority > 0 ? options.priority + 1 : 0);
    servo_thread = std::thread([this] { loop(); });
    give(servo_thread, options.priority);
}

void Servo::Work::end() noexcept
{
    halted = true;
    device.zero();
    quit = true;
    if (servo_thread.joinable()) servo_thread.join();
    settled = true;  // it writes no more, so halt_all() need not wait for it
    if (watchdog_thread.joinable()) watchdog_thread.join();
    device.zero();
    for (std::atomic<void*>& servo : g_servos) {
        void* self = this;
        servo.compare_exchange_strong(self, nullptr);
    }
}

void Servo::Work::loop() noexcept
{
    std::int64_t next = clock_ns(), last = next - period;
    bool overran = false;
    while (!quit) {
        const std::int64_t begin = clock_ns(), cpu = clock_ns(CLOCK_THREAD_CPUTIME_ID);
        heartbeat = begin;
        const std::int64_t behind = begin - next;
        now.tick = ticks.fetch_add(1, std::memory_order_relaxed) + 1;
        now.time = seconds(begin);
        now.dt = seconds(begin - last);
        now.late = seconds(std::max<std::int64_t>(behind, 0));
        last = begin;
        if (behind > period) count(late);
        if (now.late > worst_late.load(std::memory_order_relaxed)) worst_late.store(now.late, std::memory_order_relaxed);
        now.degraded = overran || behind > period;
        if (now.degraded) count(degraded);

        tick.run(
            now,
            {.held = held, .stop = stopped || halted, .resume = resumed.exchange(false), .restart = restarted.exchange(false)});

        // A tick that took longer than the watchdog allows must not undo the watchdog's zero.
        const std::int64_t answered = clock_ns();
        if (halted || stopped || answered - begin > k_heartbeat) {
            now.sent.fill({});
            device.zero();
        }
        device.report(haptic::bits(now.safety));
        if (!device.write({now.sent.data(), tick.zones()})) now.connected = false;
        if (halted || stopped) {
            device.zero();
            if (halted) settled = true;
        }

        const std::int64_t done = clock_ns();
        now.cpu = seconds(clock_ns(CLOCK_THREAD_CPUTIME_ID) - cpu);
        overran = static_cast<double>(done - begin) > options.budget * static_cast<double>(period);
        if (overran) count(overruns);
        newest.put(now);
        if (!ring.push(now)) count(dropped);
        heartbeat = done;

        next += period;
        if (done > next) {  // missed ticks are counted, not made up in a burst
            const std::int64_t skipped = (done - next) / period + 1;
            count(missed, static_cast<std::uint64_t>(skipped));
            next += skipped * period;
        }
        sleep_until(next);
    }
}

void Servo::Work::watch() noexcept
{
    std::int64_t next = clock_ns();
    bool silent = false;
    while (!quit) {
        if (clock_ns() - heartbeat.load() > k_heartbeat) {
            device.zero();
            restarted = true;  // if the tick returns, the filter engages anew
            if (!silent) count(watchdog);
            silent = true;
        } else {
            silent = false;
        }
        if (const int signal = options.signals ? g_signal.exchange(0) : 0) leave_by_signal(signal);
        next = std::max(next + k_watch, clock_ns());
        sleep_until(next);
    }
}

/// Zeroes every device and hands the signal to its earlier handler.
void Servo::Work::leave_by_signal(int signal) noexcept
{
    halt_all();
    if (!g_caught.exchange(false)) return;
    sigaction(SIGINT, &g_before_int, nullptr);
    sigaction(SIGTERM, &g_before_term, nullptr);
    kill(getpid(), signal);
}

Servo::Servo(Device& device, const ServoOptions& options, TickFunction tick, void* context)
{
    work_ = std::make_unique<Work>(device, options, tick, context);
    try {
        work_->start();
    } catch (...) {
        work_->end();
        throw;
    }
}

Servo::~Servo() { work_->end(); }

void Servo::stop() noexcept
{
    work_->stopped = true;
    work_->device.zero();
}

void Servo::resume() noexcept
{
    work_->stopped = false;
    work_->resumed = true;
}

void Servo::hold(bool held) noexcept { work_->held = held; }
void Servo::restart() noexcept { work_->restarted = true; }

ServoCounters Servo::counters() const noexcept
{
    const Work& w = *work_;
    return {.ticks = w.ticks,
            .late = w.late,
            .missed = w.missed,
            .overruns = w.overruns,
            .degraded = w.degraded,
            .watchdog = w.watchdog,
            .dropped = w.dropped,
            .worst_late = w.worst_late};
}

bool Servo::newest(ServoTick& tick) noexcept
{
    if (!work_->newest.take()) return false;
    tick = work_->newest.value();
    return true;
}

bool Servo::next(ServoTick& tick) noexcept { return work_->ring.pop(tick); }

}  // namespace sqmap::device
