// Tests that nothing waits of what the servo calls: no system call, by the kernel's word, and no allocation.
#include "device/channel.h"
#include "sqmap/device/path.h"
#include "sqmap/device/trace.h"

#include <gtest/gtest.h>

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <thread>

namespace {

thread_local bool g_guarded = false;
std::atomic<int> g_allocations{0};

void* counted(std::size_t size)
{
    if (g_guarded) ++g_allocations;
    void* const p = std::malloc(size == 0 ? 1 : size);
    if (p == nullptr) throw std::bad_alloc();
    return p;
}

}  // namespace

void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }

namespace sqmap::device {
namespace {

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr bool k_watched = false;  // sanitizers make calls of their own
#else
constexpr bool k_watched = true;
#endif

/// From now on the kernel kills this thread at any system call but exit, and reading the clock where that is one.
bool forbid_system_calls()
{
    sock_filter rules[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit, 1, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clock_gettime, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_THREAD),
    };
    const sock_fprog program{static_cast<unsigned short>(std::size(rules)), rules};
    return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

/// Runs work on a thread that may not make system calls. True where it came through and allocated nothing.
template <class Work>
bool waits_for_nothing(Work work)
{
    std::atomic<bool> done{false};
    g_allocations = 0;
    std::thread thread([&] {
        work();  // once before: pages are touched, symbols bound
        if (k_watched && !forbid_system_calls()) return;
        g_guarded = true;
        for (int i = 0; i < 100; ++i) work();
        g_guarded = false;
        done = true;
        if (k_watched) ::syscall(SYS_exit, 0);
    });
    thread.join();
    return done && g_allocations == 0;
}

TEST(WaitFree, TheGuardSeesCallsAndAllocations)
{
    if (!k_watched) GTEST_SKIP() << "not under a sanitizer";
    EXPECT_FALSE(waits_for_nothing([] { std::this_thread::sleep_for(std::chrono::microseconds(1)); }));
    EXPECT_FALSE(waits_for_nothing([] { (void)::getppid(); }));
    EXPECT_FALSE(waits_for_nothing([] {
        int* volatile p = new int(7);
        delete p;
    }));
}

TEST(WaitFree, ChannelsReadWriteAndZero)
{
    Channel channel;
    channel.publish({});
    Sample sample;
    const std::vector<Wrench> wrenches(k_max_zones);
    EXPECT_TRUE(waits_for_nothing([&] {
        (void)channel.read(sample);
        (void)channel.write(wrenches);
        channel.zero();
    }));
}

TEST(WaitFree, PathsReadAndWrite)
{
    PathDevice path("p", std::vector<Pose>(1000), 1000);
    Sample sample;
    const Wrench none[1];
    EXPECT_TRUE(waits_for_nothing([&] {
        (void)path.read(sample);
        (void)path.write(none);
    }));
}

TEST(WaitFree, TracesTakeRows)
{
    const auto file = std::filesystem::temp_directory_path() / ("sqmap-wait-free-" + std::to_string(::getpid()));
    {
        TraceWriter writer(file, {});
        TraceRow row;
        EXPECT_TRUE(waits_for_nothing([&] { (void)writer.push(row); }));
    }
    std::filesystem::remove(file.string() + ".recording");
}

}  // namespace
}  // namespace sqmap::device
