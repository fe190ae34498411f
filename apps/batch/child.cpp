// The process is a fork of the driver. Starting the program anew would cost twelve milliseconds of CPU time for its libraries; a
// fork costs one. The driver has a single thread, so the fork may allocate memory.
#include "batch/child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <new>
#include <system_error>

namespace sqmap::batch {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int k_memory = 101, k_output = 102, k_failed = 103;  // exit codes
constexpr int k_channel = 3, k_output_file = 4;

Clock::duration patience(const Caps& caps) { return std::chrono::seconds(std::uint64_t{3} * caps.seconds + 10); }

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

rlim_t address_space()
{
    std::ifstream in("/proc/self/statm");
    rlim_t pages = 0;
    in >> pages;
    return pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

void limit(__rlimit_resource resource, rlim_t soft, rlim_t hard)
{
    rlimit now{};
    ::getrlimit(resource, &now);
    const rlimit values{std::min(soft, now.rlim_max), std::min(hard, now.rlim_max)};
    if (::setrlimit(resource, &values) != 0) ::_exit(k_failed);
}

/// Makes the system end this process, and not the driver, where the machine runs out of memory.
void go_first() { std::ofstream("/proc/self/oom_score_adj") << 1000; }

/// Prepares the new process: sets limits and signals, and closes all files of the driver but two.
void enter(pid_t driver, const Caps& caps, int channel, int output)
{
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != driver) ::_exit(k_failed);  // the driver died before PDEATHSIG was set
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGPIPE}) ::signal(signal, SIG_DFL);
    ::signal(SIGXFSZ, SIG_IGN);  // a full file is a failed write
    go_first();
    std::set_new_handler([] { ::_exit(k_memory); });
    if (!caps.is_long) limit(RLIMIT_CPU, caps.seconds, caps.seconds + 1);
    limit(RLIMIT_AS, address_space() + caps.memory, address_space() + caps.memory);
    limit(RLIMIT_FSIZE, caps.output, caps.output);
    limit(RLIMIT_CORE, 0, 0);
    const int kept = ::fcntl(channel, F_DUPFD, 10), kept_output = ::fcntl(output, F_DUPFD, 10);
    const int nothing = ::open("/dev/null", O_RDWR);
    if (kept < 0 || kept_output < 0 || nothing < 0) ::_exit(k_failed);
    for (const int fd : {0, 1, 2}) ::dup2(nothing, fd);
    ::dup2(kept, k_channel);
    ::dup2(kept_output, k_output_file);
    ::close_range(k_output_file + 1, ~0U, 0);
}

double seconds_of(const timeval& time) { return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6; }

}  // namespace

Child::Child(const Work& work, const Caps& caps) : caps_(caps)
{
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) fail("no channel to a process");
    channel_ = Descriptor(ends[0]);
    const Descriptor other(ends[1]);
    output_ = Descriptor(::memfd_create("sqmap-batch", MFD_CLOEXEC));
    if (!output_) fail("no file in memory");
    const pid_t driver = ::getpid();
    start_ = Clock::now();
    deadline_ = start_ + patience(caps);
    process_.id = ::fork();
    if (process_.id < 0) fail("no process can be started");
    if (process_.id == 0) {
        enter(driver, caps, other.get(), output_.get());
        try {
            work(k_channel, k_output_file);
        } catch (...) {
            ::_exit(k_failed);
        }
        ::_exit(0);
    }
    ::setpgid(process_.id, process_.id);  // driver and process both do it, since neither knows who comes first
    handle_ = Descriptor(static_cast<int>(::syscall(SYS_pidfd_open, process_.id, 0)));
    if (!handle_) fail("no handle of a process");
}

Child::~Child()
{
    if (process_.id < 0) return;
    ::kill(-process_.id, SIGKILL);
    ::kill(process_.id, SIGKILL);
    while (::waitpid(process_.id, nullptr, 0) < 0 && errno == EINTR) {
    }
}

void Child::renew_deadline() { deadline_ = Clock::now() + patience(caps_); }

void Child::stop()
{
    stopped_ = true;
    ::kill(process_.id, SIGKILL);
}

Ended Child::judged(int status) const
{
    const std::string time = std::to_string(caps_.seconds) + " s of CPU time";
    if (stopped_) return {.ending = Ending::Timeout, .reason = "it did not end within three times " + time};
    if (WIFSIGNALED(status)) {
        const int signal = WTERMSIG(status);
        if (signal == SIGXCPU) return {.ending = Ending::Timeout, .reason = "it took more than " + time};
        if (signal == SIGKILL || signal == SIGTERM || signal == SIGINT || signal == SIGHUP)
            return {.ending = Ending::Killed, .reason = "it was killed, by somebody or for want of memory in the machine"};
        return {.ending = Ending::Crash, .reason = "it ended by signal " + std::to_string(signal)};
    }
    switch (WEXITSTATUS(status)) {
        case 0:
            return {.ending = Ending::Done, .reason = ""};
        case k_memory:
            return {.ending = Ending::Memory, .reason = "it took more than " + std::to_string(caps_.memory) + " bytes of memory"};
        case k_output:
            return {.ending = Ending::Output, .reason = "it wrote more than " + std::to_string(caps_.output) + " bytes"};
        default:
            return {.ending = Ending::Crash, .reason = "it ended with exit code " + std::to_string(WEXITSTATUS(status))};
    }
}

Ended Child::wait()
{
    int status = 0;
    rusage used{};
    while (::wait4(process_.id, &status, 0, &used) < 0 && errno == EINTR) {
    }
    ::kill(-process_.id, SIGKILL);  // ends what the process has started and left
    process_.id = -1;
    Ended out = judged(status);
    out.cpu_seconds = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
    out.wall_seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    out.peak_bytes = static_cast<std::uint64_t>(used.ru_maxrss) * 1024;
    return out;
}

bool write_all(int fd, std::string_view text)
{
    while (!text.empty()) {
        const ssize_t n = ::write(fd, text.data(), text.size());
        if (n > 0)
            text.remove_prefix(static_cast<std::size_t>(n));
        else if (n == 0 || errno != EINTR)
            return false;
    }
    return true;
}

void end_for_output() { ::_exit(k_output); }

}  // namespace sqmap::batch
