// For the exact layer: the triangles that can be nearest to some point of a locator cell.
#pragma once

#include "bake/locator/locator.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

namespace sqmap::bake {

/// A model before its locator was updated, and what that update reached.
struct ListsBefore {
    model::ModelView model;
    LocatorUpdate update;
};

/// Fills data's candidate lists and rises from its locator and triangles; leaves them empty where it has not both. solid: of the
/// mesh that the locator was baked from. before: null, or what was there before the locator was updated: cells that the change
/// does not reach keep their lists. Cost: some hundred closest points of triangles for each cell that is not free.
void bake_candidate_lists(const mesh::Solid& solid, const ListsBefore* before, const LocatorOptions& options,
                          model::ModelData& data);

}  // namespace sqmap::bake
