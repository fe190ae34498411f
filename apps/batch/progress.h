// Progress of a run: one line that is rewritten on a terminal, plain lines in a log, or JSON lines.
#pragma once

#include "batch/row.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace sqmap::batch {

enum class ProgressMode : std::uint8_t { Auto, Json, None };

class Progress {
public:
    Progress(ProgressMode mode, std::size_t items);

    /// Counts an item that has its result. seconds: CPU time, 0 for an item that shares its result. is_new: no earlier run had
    /// the result.
    void add(const Row& row, double seconds, bool is_new);
    /// Prints the state where the last one is old enough; the driver calls this every second.
    void refresh();
    void end();

private:
    void show(bool is_last);
    [[nodiscard]] std::string state() const;

    using Clock = std::chrono::steady_clock;
    ProgressMode mode_;
    bool is_terminal_;
    std::size_t items_, done_ = 0, baked_ = 0;
    std::map<std::string, std::size_t, std::less<>> counts_;
    Clock::time_point start_ = Clock::now(), last_ = start_;
};

}  // namespace sqmap::batch
