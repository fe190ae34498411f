#include "viewer/server/jobs/worker.h"

namespace sqmap::viewer {

Worker::Worker(std::function<void(const std::string&)> trouble) : trouble_(std::move(trouble))
{
#ifndef __EMSCRIPTEN__
    thread_ = std::thread([this] { toil(); });
#endif
}

void Worker::work(std::function<void()> job)
{
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
    ++waiting_;
    wake_.notify_one();
}

void Worker::finish()
{
    {
        const std::lock_guard lock(mutex_);
        quit_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
    jobs_.clear();  // what they hold may have threads of its own that tell the server things
}

bool Worker::do_next()
{
    std::function<void()> job;
    {
        const std::lock_guard lock(mutex_);
        if (quit_ || jobs_.empty()) return false;
        job = std::move(jobs_.front());
        jobs_.pop_front();
    }
    try {
        job();
    } catch (const Cancelled&) {
    } catch (const std::exception& e) {
        if (!quit_) trouble_(e.what());
    }
    --waiting_;
    return true;
}

void Worker::toil()
{
    while (!quit_) {
        while (do_next()) {
        }
        std::unique_lock lock(mutex_);
        wake_.wait(lock, [this] { return quit_ || !jobs_.empty(); });
    }
}

}  // namespace sqmap::viewer
