// Memory of distance fields in space at a given sampling density, for Table 1 and Fig. 12 of the paper. Counted without queries:
// for all but the adaptive field only the cells that it would keep are found.
#pragma once

#include "setting.h"

#include <cstddef>
#include <cstdint>

namespace sqmap::bench {

/// Cubic cells whose side is the longest side of the object's box over `cells`.
struct FieldDensity {
    std::uint32_t cells = 512;  ///< along the longest side
};
[[nodiscard]] double cell_side(const Setting& setting, FieldDensity density);

/// A dense field: one float a grid point of the object's box, with a cell's margin on every side.
[[nodiscard]] std::size_t dense_bytes(const Setting& setting, FieldDensity density);

/// An adaptive field after Frisken et al. 2000, built (adf.cpp): an octree whose cells are split, down to the density's, while
/// trilinear interpolation misses the exact distance by more than 0.1 % of the object's diagonal; leaves hold their eight
/// corners as floats, nodes a 32-bit link. Its root is a cube about the object. Cost: seconds for 512.
/// @pre cells is a power of two
[[nodiscard]] std::size_t adf_bytes(const Setting& setting, FieldDensity density);

/// The same octree with every cell that reaches the surface split down to the density's, however flat the surface.
[[nodiscard]] std::size_t full_octree_bytes(const Setting& setting, FieldDensity density);

/// The 512-tree of McNeely et al. 1999, three levels of 8 x 8 x 8 children; a block of 512 is there where the surface is:
/// links of 32 bits above, floats in the leaves. The root spans 512 cells, whatever the object fills of it.
/// @pre cells <= 512
[[nodiscard]] std::size_t tree512_bytes(const Setting& setting, FieldDensity density);

/// Error of trilinear interpolation in a field of such cells, percent of R_max: mean over pseudo-random points inside the
/// object within 4 % of R_max of the surface; the same points at every density. The eight samples about each are computed
/// exactly, so no field is needed.
[[nodiscard]] double field_error(const Setting& setting, FieldDensity density, std::uint32_t points = 2000);

}  // namespace sqmap::bench
