// Recordings of the servo, a row a tick, that replay to the bit. The format: docs/trace-format.md.
#pragma once

#include "sqmap/device/device.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sqmap::device {

/// A trace that cannot be read or written; what() names file and line and says what to do. Thread safety: a value.
class TraceError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Version of the trace format.
inline constexpr int k_trace_version = 1;

/// The recording's setting: a zone count, and all that a replay needs, as key and value, in order; a key may repeat.
struct TraceHeader {
    std::size_t zones = 1;
    std::vector<std::pair<std::string, std::string>> fields{};  ///< a key has no blank, neither has a line break

    /// The first value of key.
    [[nodiscard]] std::optional<std::string> find(std::string_view key) const;
};

/// How the forces of a tick were computed; bits.
enum TraceInput : std::uint32_t {
    k_trace_measured_twist = 1,  ///< with the device's twists, not with differences of poses
    k_trace_degraded = 2,        ///< from the last tangent planes
    k_trace_idle = 4,            ///< nothing was computed: there is no reading yet, or the device is gone
};

/// One tick. Arrays hold as many zones as the header says; the rest is not stored.
struct TraceRow {
    double time = 0;             ///< s since the first tick
    double dt = 0;               ///< s, the step that the forces were computed with
    std::uint64_t sequence = 0;  ///< of the device's reading
    std::uint32_t buttons = 0;
    std::uint32_t input = 0;  ///< bits of TraceInput
    double cpu = 0;           ///< s of the servo's own CPU time in this tick; the one column that a replay does not repeat
    std::uint32_t contacts = 0;
    double depth = 0;          ///< m, the deepest contact of all zones
    std::uint32_t status = 0;  ///< bits of the force algorithm
    std::uint32_t filter = 0;  ///< bits of the safety filter
    std::array<Pose, k_max_zones> poses{};
    std::array<Twist, k_max_zones> twists{};     ///< zero where the device measures none
    std::array<Wrench, k_max_zones> computed{};  ///< by the force algorithm
    std::array<Wrench, k_max_zones> sent{};      ///< to the device, behind the safety filter
};

/// Equal to the bit in everything but cpu (any NaN equals any other). Any thread.
[[nodiscard]] bool same_bits(const TraceRow& a, const TraceRow& b, std::size_t zones) noexcept;
/// Names of the columns in which they differ, separated by blanks; empty where same_bits. Any thread.
[[nodiscard]] std::string differences(const TraceRow& a, const TraceRow& b, std::size_t zones);

/// Checks that a TraceWriter could write to a path; leaves no file. @throw TraceError if not
void check_recording(const std::filesystem::path& path);

/// Writes a trace. Rows go to PATH.recording, which becomes PATH on finish(): PATH is never partly there, and a recording that
/// is killed keeps all but its last moments under the other name, which a reader takes too. A PATH that exists and is no
/// regular file (a pipe) is written to in place.
/// Thread safety: one thread pushes (the servo's); dropped() by any thread; a thread of the writer's own writes the file.
/// finish() and destruction after the last push.
class TraceWriter {
public:
    /// @throw TraceError where the file cannot be made, or an earlier recording that was cut short lies there.
    TraceWriter(const std::filesystem::path& path, const TraceHeader& header);
    /// Without finish(), writes the pushed rows and leaves them under the temporary name.
    ~TraceWriter();
    TraceWriter(const TraceWriter&) = delete;
    TraceWriter& operator=(const TraceWriter&) = delete;

    /// For the servo: wait-free, no allocation. False when the writer is a ring (k_ring rows) behind: the row is dropped.
    bool push(const TraceRow& row) noexcept;
    /// For programs without a clock to keep: waits for room in the ring. Returns once the row is there, or nothing can be
    /// written.
    void push_wait(const TraceRow& row);
    /// Rows that push() had to drop.
    [[nodiscard]] std::uint64_t dropped() const noexcept;
    /// Writes what is left and the end line, and gives the file its name.
    /// @throw TraceError where the disk is full or the file cannot be renamed.
    void finish();

    /// Capacity of the ring: how many rows may wait to be written.
    static constexpr std::size_t k_ring = 2048;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Reads a trace row by row: the memory does not grow with the file. Thread safety: one thread at a time.
class TraceReader {
public:
    /// @throw TraceError: no such file, not a trace, another version, a column that is missing or unknown.
    explicit TraceReader(const std::filesystem::path& path);
    ~TraceReader();
    TraceReader(const TraceReader&) = delete;
    TraceReader& operator=(const TraceReader&) = delete;

    /// Read by the constructor.
    [[nodiscard]] const TraceHeader& header() const noexcept;
    /// False at the end. A last row without its line break is left out: the recording was cut short in it.
    /// @throw TraceError naming the line.
    bool next(TraceRow& row);
    /// After next() returned false: the recording was ended by finish().
    [[nodiscard]] bool complete() const noexcept;
    /// Line of the row that next() returned last.
    [[nodiscard]] std::size_t line() const noexcept;
    /// Rows that were dropped while recording, as the end line has it.
    [[nodiscard]] std::uint64_t dropped() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace sqmap::device
