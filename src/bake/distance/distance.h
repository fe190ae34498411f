// Bakes the arrays from which signed distances are answered.
#pragma once

#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

#include <cstddef>

namespace sqmap::bake {

struct DistanceOptions {
    double band = 5;         ///< percent of R_max
    unsigned threads = 0;    ///< 0: one a core
    std::size_t beside = 0;  ///< bytes of maps that stand beside data, which count for what the tree of bounds may take
};

/// Fills data.distance from data's header, its exact layer and the solid in model space.
/// Cost: a closest-point query a cell of the tree of bounds, n log n for the hierarchy.
void bake_distance(const mesh::Solid& solid, const DistanceOptions& options, model::ModelData& data);

/// Fills data.distance's tree of bounds: how far the surface is wherever it is farther than the band. data's header and the band
/// are set. other_bytes: of the rest of the model, of which the tree takes a small share. Cost: a closest-point query a cell.
void bake_bounds(const mesh::Solid& solid, std::size_t other_bytes, unsigned threads, model::ModelData& data);

/// Fills data.distance's hierarchy from data's exact layer. Empty without one, or of more than k_max_hierarchy_entries triangles.
/// Cost: n log n.
void bake_hierarchy(model::ModelData& data);

/// Fills data.distance.samples; data.distance.header's root is set. Cost: candidates times samples.
void bake_samples(const mesh::Solid& solid, model::ModelData& data);

}  // namespace sqmap::bake
