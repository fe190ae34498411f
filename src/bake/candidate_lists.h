// For the exact layer of frames: the triangles that can be nearest to some point of a place of the locator.
#pragma once

#include "locator.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

namespace sqmap::bake {

/// Fills data's near lists from its locator and triangles; leaves them empty where it has not both. solid: the mesh that the
/// locator was baked from. Cost: some hundred closest points of triangles for each place that is not Free.
void bake_candidate_lists(const mesh::Solid& solid, double target_error, unsigned threads, model::ModelData& data);

/// The same for a locator that was updated: places that the change does not reach keep their lists. before: the model before it.
void update_candidate_lists(const mesh::Solid& solid, const model::ModelView& before, const LocatorUpdate& update,
                            double target_error, unsigned threads, model::ModelData& data);

}  // namespace sqmap::bake
