// The children of a node in the order in which a search visits them.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace sqmap::query {

/// Chosen children, the nearest first: they bring surfaces near, so that those after them may be too far.
class ChildOrder {
public:
    /// chosen: a bit for each.
    ChildOrder(const float* distance_sq, std::uint32_t chosen)
    {
        for (; chosen != 0; chosen &= chosen - 1) {
            const auto c = static_cast<std::uint32_t>(std::countr_zero(chosen));
            std::size_t k = count_++;
            for (; k > 0 && distance_sq[child_[k - 1]] > distance_sq[c]; --k) child_[k] = child_[k - 1];
            child_[k] = c;
        }
    }
    [[nodiscard]] const std::uint32_t* begin() const { return child_; }
    [[nodiscard]] const std::uint32_t* end() const { return child_ + count_; }

private:
    std::size_t count_ = 0;
    std::uint32_t child_[32];
};

}  // namespace sqmap::query
