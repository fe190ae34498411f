// Pseudo-random numbers that are the same on every platform.
#pragma once

#include <cstdint>

namespace sqmap {

/// SplitMix64 (Steele, Lea, Flood 2014). Every seed gives a sequence of its own.
/// Thread safety: one thread at a time; any number of generators at once.
class SplitMix64 {
public:
    /// The sequence of that seed.
    explicit constexpr SplitMix64(std::uint64_t seed) noexcept : state_(seed) {}
    /// The next 64 bits.
    constexpr std::uint64_t bits() noexcept
    {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }
    /// In [0, 1), 53 bits.
    constexpr double uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
    /// In [lo, hi).
    constexpr double between(double lo, double hi) noexcept { return lo + (hi - lo) * uniform(); }

private:
    std::uint64_t state_;
};

}  // namespace sqmap
