// A thread for what takes longer than a picture: baking, fields, maps.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace sqmap::viewer {

inline constexpr int k_max_jobs = 16;

/// Thrown by a job that ends early because its worker quits.
struct Cancelled {};

/// Does one job after the other. All functions may be called by any thread. Where there are no threads (WebAssembly) jobs wait
/// until somebody calls do_next().
class Worker {
public:
    /// trouble: told of a job that threw, by the worker's thread.
    explicit Worker(std::function<void(const std::string&)> trouble);
    ~Worker() { finish(); }
    void work(std::function<void()> job);
    bool do_next();  ///< on the caller's thread; false where none waits
    void finish();   ///< after the job at hand; the others are forgotten
    [[nodiscard]] bool busy() const noexcept { return waiting_ >= k_max_jobs; }
    [[nodiscard]] bool quits() const noexcept { return quit_; }

private:
    void toil();

    std::function<void(const std::string&)> trouble_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> jobs_;
    std::atomic<bool> quit_{false};
    std::atomic<int> waiting_{0};
    std::thread thread_;
};

}  // namespace sqmap::viewer
