// Another program as a process of its own, within limits.
// Any number of threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::platform {

/// True where this system's programs can be started.
#ifdef __linux__
inline constexpr bool k_starts_programs = true;
#else
inline constexpr bool k_starts_programs = false;
#endif

/// The program on PATH; empty where it is not installed, or where this system's programs are not started. Folders relative to
/// the present one are not searched.
[[nodiscard]] std::string program_on_path(std::string_view name);

/// A new folder that no other user may enter. The destructor removes it with everything in it.
class PrivateFolder {
public:
    PrivateFolder();
    ~PrivateFolder();
    PrivateFolder(const PrivateFolder&) = delete;
    PrivateFolder& operator=(const PrivateFolder&) = delete;

    /// Empty where none could be made.
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

/// Limits of the child alone: seconds of CPU time, bytes of memory, bytes of a file.
struct ChildLimits {
    std::uint64_t seconds, memory, file;
};

/// A program, the folder to run it in, and the file `log` for its output.
struct Command {
    std::string program, folder, log;
    std::vector<std::string> arguments, environment;
    ChildLimits limits;
};

enum class ChildEnd {
    Exited,       ///< code: its exit status
    NotStarted,   ///< no process can be started
    TooLong,      ///< not done within three times the seconds, and ended
    TooMuchTime,  ///< more CPU time than the limit
    TooMuchFile,  ///< a file beyond the limit
    Crashed       ///< code: the signal
};
struct ChildResult {
    ChildEnd how = ChildEnd::NotStarted;
    int code = 0;
};
/// Returns when the process and its own children are gone.
[[nodiscard]] ChildResult run(Command command);

}  // namespace sqmap::platform
