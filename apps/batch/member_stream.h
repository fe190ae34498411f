// The members of one archive that a shard wants, as they come from the process that reads them.
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

/// An item of a shard with the bytes that were read of it, or why there are none.
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
    /// wanted: items by member.
    MemberStream(std::filesystem::path archive, std::map<std::string, std::size_t> wanted, const Options& options);

    /// Of the reading process; -1 when it has ended.
    [[nodiscard]] int channel() const { return child_ ? child_->channel() : -1; }
    [[nodiscard]] std::chrono::steady_clock::time_point deadline() const { return child_->deadline(); }
    /// Takes what the process has sent, or what follows from its end.
    void receive();
    /// The deadline has passed while members were awaited.
    void stop();
    /// Time that nobody waited for a member does not count.
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
