// The tree of bounds about an object.
#pragma once

#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

namespace sqmap::bake {

/// Fills data.distance's tree of bounds: how far the surface is wherever it is farther than the band. data's header and the band
/// are set. other_bytes: of the rest of the model, of which the tree takes a small share. Cost: a closest-point query a cell.
void bake_bounds(const mesh::Solid& solid, std::size_t other_bytes, unsigned threads, model::ModelData& data);

}  // namespace sqmap::bake
