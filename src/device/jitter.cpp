#include "device/jitter.h"

#include "clock.h"
#include "sqmap/math/assert.h"

#include <pthread.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace sqmap::device {

namespace {

std::string first_line(const char* path)
{
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
}

long long limit(__rlimit_resource_t resource)
{
    rlimit l{};
    if (getrlimit(resource, &l) != 0 || l.rlim_cur == RLIM_INFINITY) return -1;
    return static_cast<long long>(l.rlim_cur);
}

}  // namespace

double quantile(const std::vector<double>& sorted, double p)
{
    SQMAP_ASSERT(!sorted.empty());
    const double rank = std::ceil(p * static_cast<double>(sorted.size()));
    return sorted[static_cast<std::size_t>(std::clamp(rank, 1., static_cast<double>(sorted.size()))) - 1];
}

std::optional<Jitter> measure_jitter(const JitterOptions& options)
{
    if (!(options.seconds >= 0.1 && options.seconds <= 3600) || !(options.period >= 1e-4 && options.period <= 0.02) ||
        options.priority < 0 || options.priority > 99)
        throw std::invalid_argument("jitter: 0.1 to 3600 seconds, a period of 0.1 to 20 ms, a priority of 0 to 99");
    const std::int64_t period = std::llround(options.period * 1e9);
    std::vector<double> late(static_cast<std::size_t>(std::llround(options.seconds / options.period)), 0.);
    bool granted = true;
    std::thread([&] {
        if (options.priority > 0) {
            const sched_param param{options.priority};
            granted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param) == 0;
            if (!granted) return;
        }
        std::int64_t next = clock_ns() + period;
        for (double& l : late) {
            sleep_until(next);
            l = static_cast<double>(clock_ns() - next) * 1e-9;
            next += period;  // every deadline counts: those that one long sleep misses are late too
        }
    }).join();
    if (!granted) return {};
    std::sort(late.begin(), late.end());
    Jitter j;
    j.ticks = late.size();
    j.p50 = quantile(late, 0.5);
    j.p99 = quantile(late, 0.99);
    j.p999 = quantile(late, 0.999);
    j.max = late.back();
    j.late = static_cast<std::uint64_t>(late.end() - std::upper_bound(late.begin(), late.end(), options.period));
    return j;
}

Machine machine()
{
    Machine m;
    utsname u{};
    if (uname(&u) == 0) {
        m.kernel = u.release;
        const std::string version = u.version;
        for (const char* kind : {"PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT"})
            if (m.preemption.empty() && version.find(kind) != std::string::npos) m.preemption = kind;
    }
    if (first_line("/sys/kernel/realtime") == "1") m.preemption = "PREEMPT_RT";
    m.governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
    m.processors = static_cast<int>(std::thread::hardware_concurrency());
    std::ifstream cpus("/proc/cpuinfo");
    for (std::string line; std::getline(cpus, line);)
        if (line.rfind("flags", 0) == 0) {
            m.virtual_machine = (line + ' ').find(" hypervisor ") != std::string::npos;
            break;
        }
    m.rt_priority = limit(RLIMIT_RTPRIO);
    m.memory_lock = limit(RLIMIT_MEMLOCK);
    double load[1];
    if (getloadavg(load, 1) == 1) m.load = load[0];
    return m;
}

Holds judge(const Jitter& j)
{
    const double share = j.ticks > 0 ? static_cast<double>(j.late) / static_cast<double>(j.ticks) : 1;
    if (share < 0.001 && j.p999 <= 0.5e-3) return Holds::Steadily;
    return share < 0.01 ? Holds::Mostly : Holds::Not;
}

std::vector<std::string> advice(const Machine& m, const Jitter& plain, const std::optional<Jitter>& fifo, const char* priority)
{
    std::vector<std::string> list;
    const Jitter& best = fifo && fifo->late <= plain.late ? *fifo : plain;
    const std::string take_fifo = std::string("run the servo with SCHED_FIFO: ") + priority;
    if (judge(best) == Holds::Steadily) {
        if (&best != &plain && judge(plain) != Holds::Steadily) list.push_back(take_fifo);
        return list;
    }
    if (!fifo)
        list.push_back(
            "real-time priority was not granted: add \"@realtime - rtprio 95\" and \"@realtime - memlock unlimited\" to "
            "/etc/security/limits.d/realtime.conf, put yourself into that group (groupadd -f realtime; usermod -aG realtime "
            "USER), log "
            "in again, measure again");
    else
        list.push_back(take_fifo);
    if (m.load > 0.7 * m.processors)
        list.push_back("the machine is busy: close what works in the background, or give it more processors");
    if (m.preemption != "PREEMPT_RT")
        list.push_back(
            "use a kernel with PREEMPT_RT (Debian: linux-image-rt-amd64): others make a thread wait for the kernel's own work");
    if (!m.governor.empty() && m.governor != "performance")
        list.push_back("keep the processor's clock up: cpupower frequency-set -g performance (now: " + m.governor + ")");
    if (m.virtual_machine)
        list.push_back("this is a virtual machine, whose host decides when it runs: drive a device from a real one");
    if (m.processors > 1) list.push_back("keep a processor for the servo: isolcpus=, or a cpuset, and its interrupts elsewhere");
    return list;
}

}  // namespace sqmap::device
