// DAE, 3MF and FBX: Debian's program assimp makes a GLB file of them, in a process of its own and within limits. Its library is
// not linked: what a broken file does to it, it does to that process alone.
#include "parse.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <iterator>
#include <vector>

namespace sqmap::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* k_cure = "open the mesh in a modelling program and save it as GLB, OBJ, PLY or STL";
constexpr const char *k_converted = "mesh.glb", *k_log = "log";

/// A new folder that nobody else may enter; gone with everything in it at the end of the scope.
class PrivateFolder {
public:
    PrivateFolder()
    {
        std::error_code status;
        std::string name = (fs::temp_directory_path(status) / "sqmap-XXXXXX").string();
        if (status || ::mkdtemp(name.data()) == nullptr)
            fail_limit("assimp", "no temporary folder can be made for it", "set TMPDIR to a folder that can be written");
        path_ = name;
    }
    ~PrivateFolder()
    {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    PrivateFolder(const PrivateFolder&) = delete;
    PrivateFolder& operator=(const PrivateFolder&) = delete;

    [[nodiscard]] const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

/// Of a link: what it leads to.
bool is_file(const fs::path& path)
{
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
}

/// The program on PATH; empty where it is not installed. Folders relative to the present one are not searched.
std::string program_on_path(std::string_view name)
{
    const char* variable = std::getenv("PATH");
    std::string_view left = variable != nullptr ? variable : "/usr/local/bin:/usr/bin:/bin";
    while (!left.empty()) {
        const std::string_view folder = left.substr(0, left.find(':'));
        left.remove_prefix(std::min(folder.size() + 1, left.size()));
        std::string candidate = std::string(folder) + "/" + std::string(name);
        if (folder.starts_with('/') && ::access(candidate.c_str(), X_OK) == 0 && is_file(candidate)) return candidate;
    }
    return {};
}

struct ChildLimits {
    rlim_t seconds, memory, file;
};

/// What the child needs; made before the fork, after which nothing may allocate.
struct Command {
    std::string program, folder, log;
    std::vector<std::string> arguments, environment;
    ChildLimits limits;
};

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

/// In the child: only what is safe between fork and exec.
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

/// Whether the process ended before the deadline.
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

/// The status of waitpid, or nothing where the time was up and the process and its own children were ended.
std::optional<int> run(Command command)
{
    const std::vector<char*> arguments = null_terminated(command.arguments), environment = null_terminated(command.environment);
    const pid_t child = ::fork();
    if (child < 0) fail_limit("assimp", "no process can be started for it", "end other programs");
    if (child == 0) become(command, arguments.data(), environment.data());
    ::setpgid(child, child);  // both do it: neither knows who comes first
    const bool ended = ends_within(child, std::chrono::seconds(3 * command.limits.seconds));
    ::kill(-child, SIGKILL);
    int status = 0;
    pid_t waited = 0;
    do waited = ::waitpid(child, &status, 0);
    while (waited < 0 && errno == EINTR);
    return ended && waited == child ? std::optional(status) : std::nullopt;
}

std::string first_bytes(const fs::path& path, std::size_t count)
{
    std::string text(count, '\0');
    std::ifstream stream(path, std::ios::binary);
    stream.read(text.data(), static_cast<std::streamsize>(count));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    return text;
}

/// What the program itself said went wrong.
std::string complaint(const fs::path& log)
{
    const std::string text = first_bytes(log, 1 << 16);
    std::size_t from = text.rfind("ERROR");
    if (from == std::string::npos) from = text.rfind('\n', text.size() - std::min<std::size_t>(text.size(), 2)) + 1;
    std::string line;
    for (const char c : text.substr(from, text.find('\n', from) - from).substr(0, 200)) line += c >= ' ' && c <= '~' ? c : '?';
    return line.empty() ? "it gave no reason" : line;
}

void check_status(std::optional<int> status, const fs::path& folder, const ChildLimits& limits)
{
    const std::string seconds = std::to_string(limits.seconds) + " s";
    if (!status) fail_limit("assimp", "it did not end within three times " + seconds, k_cure);
    if (WIFSIGNALED(*status)) {
        const int signal = WTERMSIG(*status);
        if (signal == SIGXCPU || signal == SIGKILL) fail_limit("assimp", "it took more than " + seconds + " of CPU time", k_cure);
        if (signal == SIGXFSZ) fail_limit("assimp", "it wrote more than " + std::to_string(limits.file) + " bytes", k_cure);
        fail_format("assimp", "it crashed on this file (signal " + std::to_string(signal) + ")");
    }
    if (WEXITSTATUS(*status) != 0 || !is_file(folder / k_converted))
        fail_format("assimp", "it cannot read this file: " + complaint(folder / k_log));
}

/// A file that is none of its kind is refused without starting a program.
void check_start(std::string_view text, MeshFormat format)
{
    const std::string_view start = text.substr(0, 4096);
    if (format == MeshFormat::Dae && start.find("<COLLADA") == std::string_view::npos)
        fail_format("byte 0", "a DAE file is XML that starts with <COLLADA>");
    if (format == MeshFormat::ThreeMf && !start.starts_with("PK\x03\x04"))
        fail_format("byte 0", "a 3MF file is a zip archive, which starts with PK");
    if (format == MeshFormat::Fbx && start.find("FBX") == std::string_view::npos)
        fail_format("byte 0", "an FBX file says so in its first line");
}

}  // namespace

PolygonSoup read_through_assimp(std::span<const std::byte> bytes, MeshFormat format, const ReadLimits& limits)
{
    check_start({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, format);
    const std::string program = program_on_path("assimp");
    if (program.empty())
        throw ReadFailure{{"E_FORMAT", "file",
                           std::string(format_name(format)) + " is read through the program assimp, which is not installed",
                           std::string("install it (Debian: apt-get install assimp-utils), or ") + k_cure}};
    const PrivateFolder folder;
    const std::string name = format == MeshFormat::Dae ? "mesh.dae" : format == MeshFormat::ThreeMf ? "mesh.3mf" : "mesh.fbx";
    std::ofstream input(folder.path() / name, std::ios::binary);
    input.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    input.close();
    if (!input) fail_limit("assimp", "its temporary folder is full", "set TMPDIR to a folder with more space");

    const rlim_t size = bytes.size(), file = std::min<rlim_t>(limits.max_bytes, (rlim_t{64} << 20) + 32 * size);
    const ChildLimits child{limits.max_seconds, (rlim_t{1} << 30) + 64 * size, file};
    const char* path = std::getenv("PATH");
    // Transformed by the program: a bound skin's own nodes would not move it, and these hold units and axes.
    const auto status = run({program,
                             folder.path(),
                             folder.path() / k_log,
                             {"assimp", "export", name, k_converted, "-fglb2", "-ptv"},
                             {std::string("PATH=") + (path != nullptr ? path : ""), "LC_ALL=C", "HOME=" + folder.path().string(),
                              "TMPDIR=" + folder.path().string()},
                             child});
    check_status(status, folder.path(), child);

    std::error_code ignored;
    const std::uintmax_t converted = fs::file_size(folder.path() / k_converted, ignored);
    check_byte_limit("assimp", ignored ? 0 : converted, limits);
    const std::string glb = first_bytes(folder.path() / k_converted, ignored ? 0 : converted);
    try {
        return read_gltf(std::as_bytes(std::span(glb)), {}, limits);
    } catch (ReadFailure& failure) {
        failure.error.element += " of what assimp made of it";
        throw;
    }
}

}  // namespace sqmap::io
