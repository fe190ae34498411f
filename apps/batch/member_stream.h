// Streams the members of one archive that a shard wants from the process that reads the archive.
#pragma once

#include "batch/members.h"

#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace sqmap::batch {

/// An item of a shard with the bytes of its mesh, or with the outcome that says why there are none.
struct Unpacked {
    std::size_t item = 0;
    std::string bytes;
    std::optional<Outcome> outcome;
};

class MemberStream {
public:
    struct Options {
        Caps caps;
        std::uint64_t max_bytes = 0;
    };
    /// wanted: the index of the item of each member.
    MemberStream(std::filesystem::path archive, std::map<std::string, std::size_t> wanted, const Options& options);

    /// The channel of the reading process; -1 when the process has ended.
    [[nodiscard]] int channel() const { return child_ ? child_->channel() : -1; }
    [[nodiscard]] std::chrono::steady_clock::time_point deadline() const { return child_->deadline(); }
    /// Reads what the process has sent. At the end of the process every member that is missing becomes an outcome.
    void receive();
    /// Ends the process, because the deadline has passed while the driver waited for a member.
    void stop();
    /// Starts the deadline anew: the time in which the driver did not wait for a member does not count.
    void renew_deadline();

    [[nodiscard]] bool is_over() const { return !child_ && ready_.empty(); }
    [[nodiscard]] std::deque<Unpacked>& ready() { return ready_; }

private:
    void take(const Frame& frame);
    void end();

    std::filesystem::path archive_;
    std::map<std::string, std::size_t> wanted_;  // not yet received
    Options options_;
    std::unique_ptr<Child> child_;
    Frames frames_;
    std::deque<Unpacked> ready_;
    std::string broken_;
};

}  // namespace sqmap::batch
