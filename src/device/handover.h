// Values handed from one thread to another, or one process to another through shared memory, without a lock.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace sqmap::device {

/// The newest of a stream of values (triple buffer). A slower reader misses the values in between. Holds no pointers, so it may
/// lie in shared memory.
/// Thread safety: one writing and one reading thread (or process) at once; neither ever waits.
template <class T>
class Newest {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    /// The writer's thread.
    void put(const T& value) noexcept
    {
        slot_[back_] = value;
        back_ = shared_.exchange(back_ | k_fresh, std::memory_order_acq_rel) & k_index;
    }
    /// The reader's thread: moves on to the newest value; false if none came since the last call.
    bool take() noexcept
    {
        if ((shared_.load(std::memory_order_relaxed) & k_fresh) == 0) return false;
        front_ = shared_.exchange(front_, std::memory_order_acq_rel) & k_index;
        return true;
    }
    /// The reader's thread: the value that the last successful take() moved on to; a default value before that.
    [[nodiscard]] const T& value() const noexcept { return slot_[front_]; }

private:
    static constexpr std::uint32_t k_fresh = 4, k_index = 3;
    static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

    std::array<T, 3> slot_{};
    std::uint32_t back_ = 0;   ///< the writer's
    std::uint32_t front_ = 1;  ///< the reader's
    alignas(64) std::atomic<std::uint32_t> shared_{2};
};

/// Every value in order (ring). Once the reader is N values behind, push() refuses new ones and returns false.
/// Thread safety: one writing and one reading thread at once; neither ever waits.
template <class T, std::size_t N>
class Ring {
    static_assert(std::is_trivially_copyable_v<T> && (N & (N - 1)) == 0);

public:
    /// The writer's thread. False when the ring is full.
    bool push(const T& value) noexcept
    {
        const std::uint64_t at = written_.load(std::memory_order_relaxed);
        if (at - read_.load(std::memory_order_acquire) == N) return false;
        slot_[at % N] = value;
        written_.store(at + 1, std::memory_order_release);
        return true;
    }
    /// The reader's thread. False when the ring is empty.
    bool pop(T& value) noexcept
    {
        const std::uint64_t at = read_.load(std::memory_order_relaxed);
        if (at == written_.load(std::memory_order_acquire)) return false;
        value = slot_[at % N];
        read_.store(at + 1, std::memory_order_release);
        return true;
    }

private:
    static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
    std::array<T, N> slot_{};
    alignas(64) std::atomic<std::uint64_t> written_{0};
    alignas(64) std::atomic<std::uint64_t> read_{0};
};

}  // namespace sqmap::device
