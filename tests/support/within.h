// Waiting for another thread or process.
#pragma once

#include <chrono>
#include <thread>

namespace sqmap::test {

/// True as soon as the condition holds, false where it does not within the limit.
template <class Condition>
bool within(std::chrono::milliseconds limit, Condition condition)
{
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

}  // namespace sqmap::test
