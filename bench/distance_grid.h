// Exact signed distances on a grid: what the dense fields are made of.
#pragma once

#include "setting.h"

#include <cstdint>
#include <vector>

namespace sqmap::bench {

/// Signed distances to the object's boundary, negative inside, at samples^3 points: as many along each side of the box.
/// The box is the object's with a margin of one and a half cells; cells are as oblong as the box, so that none of the
/// samples^3 values is spent on empty space.
struct DistanceGrid {
    std::uint32_t samples = 0;  ///< along each axis
    Vec3d lo, spacing;          ///< point (i, j, k) is lo + (i, j, k) * spacing, component by component
    std::vector<float> values;  ///< samples^3, x fastest
    double build_s = 0;         ///< CPU seconds that it took to make, also when it comes from the cache

    [[nodiscard]] std::size_t index(std::uint32_t i, std::uint32_t j, std::uint32_t k) const
    {
        return (std::size_t{k} * samples + j) * samples + i;
    }
};

/// Signed distance to the solid, exact in double up to rounding: negative inside.
[[nodiscard]] double signed_distance(const mesh::Solid& solid, Vec3d p);

/// Made, or read from setting.cache where the same object and size were made before.
/// Cost: about a microsecond a sample; samples^3 floats.
[[nodiscard]] DistanceGrid distance_grid(const Setting& setting, std::uint32_t samples);

/// Trilinear value; false (and no value) outside the box.
[[nodiscard]] bool interpolate(const DistanceGrid& grid, Vec3d p, double& value);

}  // namespace sqmap::bench
