// Numbers of uploads that a page has taken back.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <mutex>

namespace sqmap::viewer {

/// The newest of them: an order may come before the file that it is about. All functions may be called by any thread.
class Cancellations {
public:
    void add(std::uint32_t upload)
    {
        const std::lock_guard lock(mutex_);
        newest_.push_back(upload);
        if (newest_.size() > k_kept) newest_.pop_front();
    }
    /// 0 is no upload.
    [[nodiscard]] bool has(std::uint32_t upload) const
    {
        const std::lock_guard lock(mutex_);
        return upload != 0 && std::find(newest_.begin(), newest_.end(), upload) != newest_.end();
    }

private:
    static constexpr std::size_t k_kept = 256;
    mutable std::mutex mutex_;
    std::deque<std::uint32_t> newest_;
};

}  // namespace sqmap::viewer
