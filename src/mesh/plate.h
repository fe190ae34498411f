// Solids of sheets.
#pragma once

#include "surface.h"

namespace sqmap::mesh {

/// Of each closed sheet keeps one side: the largest stretch of its faces without a fold, the walls between its sides left
/// out. False, and nothing done, where that is not about half of every component.
/// @pre mate, component: of a closed surface whose components are thin (see Pairing, components)
bool keep_one_side(Surface& surface, const std::vector<std::uint32_t>& mate, const std::vector<std::uint32_t>& component);

/// Replaces a surface by a plate: both sides offset by half the thickness along the vertex normals, the rim closed.
/// @pre faces agree in orientation, every vertex has one fan, every edge at most two faces.
void thicken(Surface& surface, double thickness);

}  // namespace sqmap::mesh
