// Points spread over the surface, for distances without the exact layer.
#pragma once

#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

namespace sqmap::bake {

/// Fills data.distance.samples; data.distance.header's root is set. Cost: candidates times samples.
void bake_samples(const mesh::Solid& solid, model::ModelData& data);

}  // namespace sqmap::bake
