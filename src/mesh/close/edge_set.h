// Which pairs of vertices are joined by an edge.
#pragma once

#include <algorithm>
#include <cstdint>
#include <unordered_set>

namespace sqmap::mesh {

/// Looked up and never walked, so that its order has no influence.
class EdgeSet {
public:
    void insert(std::uint32_t a, std::uint32_t b) { keys_.insert(key(a, b)); }
    void erase(std::uint32_t a, std::uint32_t b) { keys_.erase(key(a, b)); }
    [[nodiscard]] bool contains(std::uint32_t a, std::uint32_t b) const { return keys_.contains(key(a, b)); }

private:
    static std::uint64_t key(std::uint32_t a, std::uint32_t b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }
    std::unordered_set<std::uint64_t> keys_;
};

}  // namespace sqmap::mesh
