// How positions are cut into runs of near ones, offline.
#pragma once

#include "sqmap/math/box.h"

#include <algorithm>
#include <cstdint>
#include <span>

namespace sqmap::query {

/// Orders positions so that each run of as many as `run` is near together: halves along the longest side, whole runs on the left.
inline void order_by_halves(std::span<std::uint32_t> order, std::span<const Vec3d> positions, std::size_t run)
{
    if (order.size() <= run) return;
    Box box;
    for (const std::uint32_t i : order) extend(box, positions[i]);
    const int axis = longest_axis(box);
    const std::size_t runs = (order.size() + run - 1) / run;
    const std::size_t half = runs / 2 * run;
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                         return positions[a][axis] != positions[b][axis] ? positions[a][axis] < positions[b][axis] : a < b;
                     });
    order_by_halves(order.first(half), positions, run);
    order_by_halves(order.subspan(half), positions, run);
}

}  // namespace sqmap::query
