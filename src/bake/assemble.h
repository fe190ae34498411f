// One assembly for bake and rebake: from parts, maps and the solid to a model's arrays.
#pragma once

#include "bake/central/central_map.h"
#include "bake/parts/part.h"
#include "sqmap/bake/bake_types.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// A part of the model comes from a fit and its map, or is taken over from another model.
struct PartSource {
    const FittedPart* fitted = nullptr;  ///< null: taken over
    const CentralMapData* map = nullptr;
    const model::Part* before = nullptr;  ///< of the part that is taken over: a part of Assembly::before
};

struct Assembly {
    const mesh::Solid& solid;                         ///< of the mesh in model space
    std::span<const std::uint32_t> part_of_triangle;  ///< #triangles
    std::vector<PartSource> parts;                    ///< in order of their numbers
    const model::ModelData* before = nullptr;         ///< whose parts may be taken over
    bool exact = true;                                ///< store the exact layer's triangles
};

/// Parts, central maps and the triangles of the exact layer, packed; no locator, candidate lists or paper maps.
/// header: origin, unit, solid, projection and the quantisation of parts that are taken over; the rest is told from the mesh.
[[nodiscard]] model::ModelData assemble(const model::Header& header, const Assembly& assembly);

/// The mesh as the caller gave it: vertices in mesh units, numbers as SourceNumbers has them.
void store_input(std::span<const Vec3d> vertices, const SourceNumbers& source, model::ModelData& data);

/// model::SurfaceFlag bits of a triangle.
[[nodiscard]] std::uint16_t surface_flag(mesh::Boundary boundary);

}  // namespace sqmap::bake
