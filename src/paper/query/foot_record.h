// The empty record of a foot search: a search tells its record each step, and this one keeps none.
#pragma once

#include <cstdint>

namespace sqmap::paper {

/// Costs nothing.
struct NoRecord {
    /// Samples of the finest grid between those that are looked at next.
    void level(std::int32_t) const noexcept {}
    /// A sample of a grid was looked at; better: lanes where it is the best so far.
    template <class Grid, class Node, class Mask>
    void sample(const Grid&, const Node&, const Mask&) const noexcept
    {
    }
    /// Newton's method has come to a position.
    template <class Position>
    void position(const Position&) const noexcept
    {
    }
};

}  // namespace sqmap::paper
