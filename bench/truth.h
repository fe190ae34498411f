// Exact answers for every frame and probe vertex.
#pragma once

#include "path.h"
#include "setting.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bench {

/// A probe vertex inside the object.
struct TrueContact {
    std::uint32_t vertex;
    double depth;  ///< distance to the solid's boundary, units of the setting
};

/// frames[f]: the vertices inside in frame f, ascending.
/// Exact in double: a vertex is asked anew only where it has moved at least as far as it was from the surface, or lies
/// inside. Cost: some microseconds a vertex asked; seconds a path.
[[nodiscard]] std::vector<std::vector<TrueContact>> true_contacts(const Setting& setting, std::span<const Pose> path);

}  // namespace sqmap::bench
