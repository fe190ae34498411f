// The least cut of a graph with two ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::decompose {

/// A maximum flow, and the least cut that it is as large as.
class MaximumFlow {
public:
    explicit MaximumFlow(std::uint32_t nodes) : nodes_(nodes) {}

    void add_edge(std::uint32_t a, std::uint32_t b, double there, double back)
    {
        added_.push_back({b, 0, there});
        added_.push_back({a, 0, back});
    }

    /// Nodes that the source still reaches once the flow is maximal, one byte a node. Flow below the tolerance counts as none.
    std::vector<std::uint8_t> source_side(std::uint32_t source, std::uint32_t sink, double tolerance);

private:
    struct Arc {
        std::uint32_t to, back;  ///< node; number of the arc that leads back
        double capacity;
    };
    /// By the node that they leave, each node's as they were added.
    void sort_arcs();
    std::span<const Arc> arcs_from(std::uint32_t node) const
    {
        return std::span(arcs_).subspan(first_[node], first_[node + 1] - first_[node]);
    }

    std::size_t nodes_;
    std::vector<std::uint32_t> first_;  ///< #nodes + 1: of the arcs that leave a node
    std::vector<Arc> added_;            ///< in pairs: the second leads back
    std::vector<Arc> arcs_;             ///< the same by node
};

}  // namespace sqmap::decompose
