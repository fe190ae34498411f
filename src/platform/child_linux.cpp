#include "child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>

namespace sqmap::platform {
namespace {

namespace fs = std::filesystem;

std::vector<char*> null_terminated(std::vector<std::string>& texts)
{
    std::vector<char*> out;
    for (std::string& t : texts) out.push_back(t.data());
    out.push_back(nullptr);
    return out;
}

void limit(__rlimit_resource resource, rlim_t soft, rlim_t hard)
{
    const rlimit values{soft, hard};
    if (::setrlimit(resource, &values) != 0) ::_exit(127);
}

/// Runs in the child: only calls that are safe between fork and exec.
[[noreturn]] void become(const Command& command, char* const* arguments, char* const* environment)
{
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const int signal : {SIGXFSZ, SIGXCPU, SIGPIPE}) ::signal(signal, SIG_DFL);
    sigset_t none;
    ::sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    limit(RLIMIT_CPU, command.limits.seconds, command.limits.seconds + 1);
    limit(RLIMIT_AS, command.limits.memory, command.limits.memory);
    limit(RLIMIT_FSIZE, command.limits.file, command.limits.file);
    limit(RLIMIT_CORE, 0, 0);
    const int input = ::open("/dev/null", O_RDONLY), log = ::open(command.log.c_str(), O_WRONLY | O_CREAT | O_EXCL, 0600);
    if (input < 0 || log < 0 || ::chdir(command.folder.c_str()) != 0 || ::dup2(input, 0) < 0 || ::dup2(log, 1) < 0 ||
        ::dup2(log, 2) < 0)
        ::_exit(127);
    ::close_range(3, ~0U, 0);
    ::execve(command.program.c_str(), arguments, environment);
    ::_exit(127);
}

/// True if the process ended before the deadline.
bool ends_within(pid_t child, std::chrono::seconds time)
{
    const auto handle = static_cast<int>(::syscall(SYS_pidfd_open, child, 0));
    if (handle < 0) return false;
    const auto deadline = std::chrono::steady_clock::now() + time;
    int ready = 0;
    do {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
        pollfd wanted{handle, POLLIN, 0};
        ready = left.count() <= 0 ? 0 : ::poll(&wanted, 1, static_cast<int>(left.count()));
    } while (ready < 0 && errno == EINTR);
    ::close(handle);
    return ready > 0;
}

ChildResult meaning_of(int status)
{
    if (!WIFSIGNALED(status)) return {ChildEnd::Exited, WEXITSTATUS(status)};
    const int signal = WTERMSIG(status);
    if (signal == SIGXCPU || signal == SIGKILL) return {ChildEnd::TooMuchTime, signal};
    return {signal == SIGXFSZ ? ChildEnd::TooMuchFile : ChildEnd::Crashed, signal};
}

}  // namespace

std::string program_on_path(std::string_view name)
{
    const char* variable = std::getenv("PATH");
    std::string_view left = variable != nullptr ? variable : "/usr/local/bin:/usr/bin:/bin";
    while (!left.empty()) {
        const std::string_view folder = left.substr(0, left.find(':'));
        left.remove_prefix(std::min(folder.size() + 1, left.size()));
        std::string candidate = std::string(folder) + "/" + std::string(name);
        std::error_code ignored;
        if (folder.starts_with('/') && ::access(candidate.c_str(), X_OK) == 0 && fs::is_regular_file(candidate, ignored))
            return candidate;
    }
    return {};
}

PrivateFolder::PrivateFolder()
{
    std::error_code status;
    std::string name = (fs::temp_directory_path(status) / "sqmap-XXXXXX").string();
    if (!status && ::mkdtemp(name.data()) != nullptr) path_ = name;
}

PrivateFolder::~PrivateFolder()
{
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
}

ChildResult run(Command command)
{
    // Made before the fork, after which nothing may allocate.
    const std::vector<char*> arguments = null_terminated(command.arguments), environment = null_terminated(command.environment);
    const pid_t child = ::fork();
    if (child < 0) return {};
    if (child == 0) become(command, arguments.data(), environment.data());
    ::setpgid(child, child);  // both processes do it, since either may run first
    const bool ended = ends_within(child, std::chrono::seconds(3 * command.limits.seconds));
    ::kill(-child, SIGKILL);
    int status = 0;
    pid_t waited = 0;
    do waited = ::waitpid(child, &status, 0);
    while (waited < 0 && errno == EINTR);
    if (!ended || waited != child) return {ChildEnd::TooLong, 0};
    return meaning_of(status);
}

}  // namespace sqmap::platform
