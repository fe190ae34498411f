// The grid that leads a point in space to the chart that answers it and to where its nearest surface is.
#pragma once

#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

#include <cstdint>
#include <span>

namespace sqmap::bake {

/// Fills data's locator from its finished parts and central maps; leaves it empty where some part has no central map or
/// there are 255 parts or more. target_error: percent of R_max, sets the cell and how flat a flat place is. part_of_triangle: of
/// solid.mesh(), whose coordinates are model space. Cost: a closest-point query a cell near the solid.
void bake_locator(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, double target_error,
                  unsigned threads, model::ModelData& data);

}  // namespace sqmap::bake
