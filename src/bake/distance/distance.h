// Bakes the arrays from which signed distances are answered.
#pragma once

#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

namespace sqmap::bake {

/// Fills data.distance from data's header, its exact layer and the solid in model space. band: percent of R_max.
/// Cost: a closest-point query a cell of the tree of bounds, n log n for the hierarchy.
void bake_distance(const mesh::Solid& solid, double band, unsigned threads, model::ModelData& data);

}  // namespace sqmap::bake
