#include "device/own_process.h"

#include "clock.h"
#include "device/handover.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <system_error>

namespace sqmap::device {

namespace {

constexpr std::int64_t k_millisecond = 1'000'000;  // ns

void sleep_for(std::int64_t ns) noexcept { sleep_until(clock_ns() + ns); }

struct Wrenches {
    std::array<Wrench, k_max_zones> of{};
    std::uint64_t zeros = 0;   // zero() calls before this write
    std::uint32_t filter = 0;  // the safety filter's report
};

enum State : int { k_opening, k_open, k_failed };

/// Memory that both processes share. Everything in it is lock-free.
struct Shared {
    std::atomic<int> state{k_opening};
    std::array<char, 256> text{};  // the device's name, or why it could not be opened
    Capabilities reported;         // its name stays empty: a longer one would be memory of one process
    Newest<Sample> samples;
    Newest<Wrenches> wrenches;
    std::atomic<std::int64_t> last_write{0};
    std::atomic<std::uint64_t> zeros{0};
    std::atomic<bool> gone{false}, quit{false};
};

void set_text(Shared& shared, const char* text) { std::snprintf(shared.text.data(), shared.text.size(), "%s", text); }

class KeptDevice final : public Device {
public:
    KeptDevice(Shared* shared, pid_t keeper, Capabilities capabilities)
        : shared_(shared), keeper_(keeper), capabilities_(std::move(capabilities))
    {
    }
    ~KeptDevice() override
    {
        KeptDevice::zero();
        shared_->quit = true;
        // A second to zero and close the device; a keeper that hangs in it is ended, and the device's own time-out acts.
        for (int i = 0; i < 1000 && waitpid(keeper_, nullptr, WNOHANG) == 0; ++i) {
            sleep_for(k_millisecond);
            if (i < 999) continue;
            kill(keeper_, SIGKILL);
            waitpid(keeper_, nullptr, 0);
        }
        munmap(shared_, sizeof(Shared));
    }
    KeptDevice(const KeptDevice&) = delete;
    KeptDevice& operator=(const KeptDevice&) = delete;

    [[nodiscard]] const Capabilities& capabilities() const noexcept override { return capabilities_; }
    bool read(Sample& sample) noexcept override
    {
        if (shared_->gone) return false;
        if (shared_->samples.take()) latest_ = shared_->samples.value();
        sample = latest_;
        return true;
    }
    void report(std::uint32_t filter) noexcept override { reported_ = filter; }
    bool write(std::span<const Wrench> wrenches) noexcept override
    {
        if (shared_->gone) return false;
        Wrenches w;
        w.filter = reported_;
        w.zeros = shared_->zeros.load();
        std::copy_n(wrenches.begin(), std::min(wrenches.size(), k_max_zones), w.of.begin());
        shared_->wrenches.put(w);
        shared_->last_write = clock_ns();
        return true;
    }
    void zero() noexcept override { ++shared_->zeros; }

private:
    Shared* shared_;
    pid_t keeper_;
    Capabilities capabilities_;
    Sample latest_{};
    std::uint32_t reported_ = 0;
};

/// The keeper's loop; ends when the program has ended.
void keep(Shared& shared, Device& device, const OwnProcessOptions& options, pid_t program) noexcept
{
    const std::int64_t timeout = std::llround(options.timeout * 1e9), period = std::llround(options.period * 1e9);
    const std::size_t zones = std::min(device.capabilities().zones, k_max_zones);
    Sample sample;
    std::uint64_t zeroed = 0;
    while (getppid() == program && !shared.quit) {
        const bool here = device.read(sample);
        if (here) shared.samples.put(sample);
        shared.gone = !here;  // a lost device may come back
        const bool fresh = shared.wrenches.take();
        const std::uint64_t zeros = shared.zeros.load();
        // A wrench written before the last zero() does not count.
        const bool current = shared.wrenches.value().zeros == zeros && clock_ns() - shared.last_write.load() < timeout;
        if (!current || zeros != zeroed) {
            device.zero();
            zeroed = zeros;
        }
        if (current && fresh) {
            device.report(shared.wrenches.value().filter);
            if (!device.write({shared.wrenches.value().of.data(), zones})) shared.gone = true;
        }
        sleep_for(period);
    }
    device.zero();
}

[[noreturn]] void keeper_process(Shared& shared, OpenDevice open, void* context, const OwnProcessOptions& options,
                                 pid_t program) noexcept
{
    // An interrupt from the keyboard goes to both processes, and this one must outlive the other.
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE}) std::signal(signal, SIG_IGN);
    try {
        const std::unique_ptr<Device> device = open(context);
        if (device == nullptr) throw std::runtime_error("no device");
        Capabilities c = device->capabilities();
        set_text(shared, c.name.c_str());
        c.name = {};
        shared.reported = c;
        shared.state = k_open;
        keep(shared, *device, options, program);
    } catch (const std::exception& e) {
        set_text(shared, e.what());
        shared.state = k_failed;
    }
    _exit(0);
}

}  // namespace

std::unique_ptr<Device> keep_in_own_process(OpenDevice open, void* context, const OwnProcessOptions& options)
{
    if (!(options.timeout >= 1e-3 && options.timeout <= 0.1) || !(options.period >= 1e-4 && options.period <= 0.01))
        throw std::invalid_argument("a keeper's time-out is 1 to 100 ms, its period 0.1 to 10 ms");
    void* memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::system_error(errno, std::generic_category(), "no shared memory for a device's keeper");
    Shared* shared = new (memory) Shared;
    const pid_t program = getpid(), keeper = fork();
    if (keeper < 0) {
        const int error = errno;
        munmap(memory, sizeof(Shared));
        throw std::system_error(error, std::generic_category(), "no process for a device's keeper");
    }
    if (keeper == 0) keeper_process(*shared, open, context, options, program);

    const std::int64_t until = clock_ns() + std::llround(options.wait * 1e9);
    while (shared->state == k_opening && clock_ns() < until && waitpid(keeper, nullptr, WNOHANG) == 0) sleep_for(k_millisecond);
    if (shared->state != k_open) {
        const std::string why = shared->state == k_failed ? shared->text.data() : "the device did not open in time";
        shared->quit = true;
        if (shared->state == k_opening) kill(keeper, SIGKILL);
        waitpid(keeper, nullptr, 0);
        munmap(memory, sizeof(Shared));
        throw std::runtime_error(why);
    }
    Capabilities capabilities = shared->reported;
    capabilities.name = std::string(shared->text.data()) + ", in a process of its own";
    capabilities.delay += options.period;
    return std::make_unique<KeptDevice>(shared, keeper, std::move(capabilities));
}

}  // namespace sqmap::device
