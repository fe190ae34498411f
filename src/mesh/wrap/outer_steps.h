// The steps of the outer solid: labels, and a surface that keeps the input inside on its way to it.
#pragma once

#include "enclosed.h"
#include "steps.h"

#include <cstdint>
#include <vector>

namespace sqmap::mesh {

inline constexpr std::uint8_t k_beside_input = 1;  ///< corner of a cell that the input touches
inline constexpr std::uint8_t k_sealed = 2;        ///< out of the outside's reach

/// The cells through which the boundary of the outer solid passes: the input touches none of them.
struct OuterLabels {
    Grid grid;
    std::vector<std::uint8_t> inside;  ///< #corners: 0 outside
};

/// The solid that cannot be reached from outside through gaps narrower than that, cells. soup: units of the cells.
[[nodiscard]] OuterLabels outer_labels(const Mesh& soup, double gap);

/// The input of a shrink, in units of the cells.
struct ShrinkInput {
    const Mesh& soup;          ///< triangles with area
    const Bvh& bvh;            ///< over them
    const Enclosed& enclosed;  ///< all triangles
    double offset;             ///< distance of the result from flat input
};

/// A surface near the input that keeps all of it inside. Vertices start in their cells, where that holds whatever they do there,
/// and go toward the planes of the nearest triangles, less far where a triangle would touch the input or another one.
[[nodiscard]] ClosedMesh shrunk(const DualSurface& surface, const OuterLabels& labels, const ShrinkInput& input);

}  // namespace sqmap::mesh
