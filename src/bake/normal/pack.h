// All parts' normal maps, packed into a model.
#pragma once

#include "bake/parts/part.h"
#include "sqmap/bake/normal_map_options.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/model/model_data.h"

#include <span>

namespace sqmap::bake {

struct NormalMapsOptions {
    double target_error = 0;  ///< of linear interpolation within one sheet, 99th percentile, model units
    NormalMapOptions map{};   ///< but for its target_error
    unsigned threads = 0;     ///< 0: one per core; the result does not depend on it
};

/// Bakes a map of each part and appends them to data's normal arrays. mesh: closed, model space.
void append_normal_maps(const mesh::Mesh& mesh, std::span<const MeasuredPart> parts, const NormalMapsOptions& options,
                        model::ModelData& data);

}  // namespace sqmap::bake
