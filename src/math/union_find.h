// Disjoint sets of numbers from zero on (Tarjan, van Leeuwen 1984: paths are halved).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace sqmap {

/// The least number of i's set. parents: at first each number is its own.
inline std::uint32_t root_of(std::span<std::uint32_t> parents, std::uint32_t i)
{
    while (parents[i] != i) i = parents[i] = parents[parents[i]];
    return i;
}

/// Joins two sets, whatever the order of the calls to the same result; false where they were one before.
inline bool join(std::span<std::uint32_t> parents, std::uint32_t i, std::uint32_t j)
{
    i = root_of(parents, i);
    j = root_of(parents, j);
    if (i == j) return false;
    parents[std::max(i, j)] = std::min(i, j);
    return true;
}

/// Sets with their own memory.
class UnionFind {
public:
    explicit UnionFind(std::size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), 0u); }
    std::uint32_t find(std::uint32_t i) { return root_of(parents_, i); }
    bool unite(std::uint32_t i, std::uint32_t j) { return join(parents_, i, j); }

private:
    std::vector<std::uint32_t> parents_;
};

}  // namespace sqmap
