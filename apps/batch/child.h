// Runs work in a process of its own, within limits. A crash, an endless loop or a full memory ends that process alone.
#pragma once

#include "batch/descriptor.h"

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace sqmap::batch {

/// Limits of a process.
struct Caps {
    std::uint32_t seconds = 300;                    ///< of CPU time; three times that, and 10 s, by the clock
    bool is_long = false;                           ///< true: only the clock limits it, which renew_deadline sets back
    std::uint64_t memory = std::uint64_t{4} << 30;  ///< bytes of address space beyond the driver's own
    std::uint64_t output = std::uint64_t{1} << 30;  ///< bytes of any file that it writes
};

/// How a process ended.
enum class Ending : std::uint8_t {
    Done,
    Timeout,
    Memory,
    Output,
    Crash,
    Killed,  ///< by somebody else: the driver may try again
};

struct Ended {
    Ending ending = Ending::Done;
    std::string reason;  ///< for people; the same on every machine
    double cpu_seconds = 0, wall_seconds = 0;
    std::uint64_t peak_bytes = 0;
};

/// A process that the driver has started and not waited for yet. The destructor ends it.
class Child {
public:
    /// Runs in the process: channel is a socket to the driver, output a file in memory that the driver reads afterwards.
    using Work = std::function<void(int channel, int output)>;

    /// @throw std::system_error where no process can be started
    Child(const Work& work, const Caps& caps);
    ~Child();
    Child(Child&&) = default;
    Child& operator=(Child&&) = delete;

    [[nodiscard]] int handle() const { return handle_.get(); }  ///< readable once it has ended
    [[nodiscard]] int channel() const { return channel_.get(); }
    [[nodiscard]] int output() const { return output_.get(); }
    [[nodiscard]] std::chrono::steady_clock::time_point deadline() const { return deadline_; }
    /// Moves the deadline: time is counted anew from now.
    void renew_deadline();

    /// Ends it because its deadline has passed.
    void stop();
    /// @pre it has ended, or stop() was called
    [[nodiscard]] Ended wait();

private:
    struct Process {
        pid_t id = -1;
        Process() = default;
        Process(Process&& other) noexcept : id(other.id) { other.id = -1; }
    };
    [[nodiscard]] Ended judged(int status) const;

    Caps caps_;
    Process process_;
    Descriptor handle_, channel_, output_;
    std::chrono::steady_clock::time_point start_, deadline_;
    bool stopped_ = false;
};

/// Writes all of the text; false where that fails.
[[nodiscard]] bool write_all(int fd, std::string_view text);

/// In a child: ends the process because its output is full.
[[noreturn]] void end_for_output();

}  // namespace sqmap::batch
