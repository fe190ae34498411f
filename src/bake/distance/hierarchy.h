// The hierarchy of boxes over what of a model's triangles is boundary.
#pragma once

#include "sqmap/model/model_data.h"

namespace sqmap::bake {

/// Fills data.distance's hierarchy from data's exact layer. Empty without one, or of more than k_max_hierarchy_entries triangles.
/// Cost: n log n.
void bake_hierarchy(model::ModelData& data);

}  // namespace sqmap::bake
