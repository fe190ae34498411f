// The triangles and cells whose surface a cure of the mesh made up: no triangle of the input lies there.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/model/model_data.h"

#include <cstdint>
#include <span>

namespace sqmap::bake {

/// Marks the exact layer's triangles, and the locator's cells of which some point may be nearest to such a triangle. mesh: in
/// model space; made_up: #triangles, or empty for none. Cost: two searches a cell.
void mark_made_up(const mesh::Mesh& mesh, std::span<const std::uint8_t> made_up, model::ModelData& data);

}  // namespace sqmap::bake
