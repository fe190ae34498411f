// A set of small numbers, a bit each.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap {

/// Numbers below a size. @pre both sets of a call have the same size
class BitSet {
public:
    explicit BitSet(std::size_t size) : words_((size + 63) / 64) {}

    void add(std::size_t i) { words_[i / 64] |= std::uint64_t{1} << (i % 64); }
    void add(const BitSet& other)
    {
        for (std::size_t w = 0; w < words_.size(); ++w) words_[w] |= other.words_[w];
    }
    void remove(const BitSet& other)
    {
        for (std::size_t w = 0; w < words_.size(); ++w) words_[w] &= ~other.words_[w];
    }
    [[nodiscard]] std::size_t count() const { return count_in(*this); }
    /// How many numbers of this set are in the other one too.
    [[nodiscard]] std::size_t count_in(const BitSet& other) const
    {
        std::size_t count = 0;
        for (std::size_t w = 0; w < words_.size(); ++w)
            count += static_cast<std::size_t>(std::popcount(words_[w] & other.words_[w]));
        return count;
    }
    /// How many numbers of this set are not in the other one.
    [[nodiscard]] std::size_t count_without(const BitSet& other) const { return count() - count_in(other); }
    /// The numbers that are in both sets, in order.
    [[nodiscard]] std::vector<std::size_t> common(const BitSet& other) const
    {
        std::vector<std::size_t> out;
        for (std::size_t w = 0; w < words_.size(); ++w)
            for (std::uint64_t bits = words_[w] & other.words_[w]; bits != 0; bits &= bits - 1)
                out.push_back(64 * w + static_cast<std::size_t>(std::countr_zero(bits)));
        return out;
    }
    /// Number i is bit i % 64 of word i / 64.
    [[nodiscard]] std::span<std::uint64_t> words() { return words_; }

private:
    std::vector<std::uint64_t> words_;
};

}  // namespace sqmap
