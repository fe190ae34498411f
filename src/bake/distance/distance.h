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

}  // namespace sqmap::bake
