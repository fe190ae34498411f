// The grid that leads a point in space to the chart that answers it and to where its nearest surface is.
#pragma once

#include "bake/locator/change.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// Fills data's locator from its finished parts and central maps; leaves it empty where some part has no central map or
/// there are 255 parts or more. target_error: percent of R_max, sets the cell and how flat a flat place is. part_of_triangle: of
/// solid.mesh(), whose coordinates are model space. Cost: a closest-point query a cell near the solid.
void bake_locator(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, double target_error,
                  unsigned threads, model::ModelData& data);

/// Bakes what a change reaches of data's locator, which was baked before it, anew; data's parts and maps are those after it. The
/// grid stays, but for bricks that are added about it where the mesh left it. solid: after the change.
/// Of each brick that is now: which one it was, or k_no_brick; and which of its 64 places (of a deep one: the first) have another
/// nearest surface.
struct LocatorUpdate {
    static constexpr std::uint32_t k_no_brick = 0xffffffffu;
    std::vector<std::uint32_t> brick_before;
    std::vector<std::uint64_t> reached;
    /// Of each brick nothing, or of each of its places the triangles near it, where they were looked for.
    std::vector<std::vector<std::vector<std::uint32_t>>> near;
};
[[nodiscard]] LocatorUpdate update_locator(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle,
                                           double target_error, const Change& change, unsigned threads, model::ModelData& data);

}  // namespace sqmap::bake
