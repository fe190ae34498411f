// Baking the central map of one part. See model/central_cells.h for what the stored numbers mean.
#pragma once

#include "bake/central/central_options.h"
#include "bake/central/chart.h"
#include "model/central_cells.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model.h"
#include "sqmap/model/model_data.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// One part's arrays, offsets relative to the part.
struct CentralMapData : model::CentralArrays<model::ArrayData> {
    Vec3f centre;
    int centre_winding = 0;
    float chart_rows[9];
    ChartDomain domain;
    model::SampleRange range;
    std::uint32_t base = 0;
    float offset_step = 0, smoothing_step = 0;
    double quantisation = 0;        ///< largest radius error of 16-bit storage, model units
    std::uint32_t rough_cells = 0;  ///< leaves that stayed above their tolerance
    bool is_full = false;           ///< some of them for want of records: finer cells find no room

    std::size_t map_bytes() const
    {
        constexpr std::size_t k_beside = 2;  // an offset and a smoothing term for each sample, which may not be made yet
        return (2 + k_beside) * samples.size() + 2 * (cells.size() + splits.size() + pool.size()) +
               4 * (blocks.size() + specials.size());
    }
};

/// A part's map before some of the mesh moved, in the same chart and domain.
struct KnownMap {
    const model::Part& part;
    model::CentralArrays<model::ArrayView> own;  ///< the part's arrays
    const mesh::Mesh& mesh;                      ///< as it was
    std::span<const std::uint32_t> changed;      ///< triangles that are elsewhere now
};

/// solid: of the mesh in model space. known: cells that no changed triangle reaches are taken from there, where its range of
/// depths still serves; null: none.
/// @throw mesh::RefusedMesh where the part needs more refined cells than a map can number
/// Cost: grows with the triangles in the chart's domain and the cells they need; some ten ms. Thread-safe.
[[nodiscard]] CentralMapData bake_central_map(const mesh::Solid& solid, const PartChart& chart, const CentralOptions& options,
                                              const KnownMap* known = nullptr);

}  // namespace sqmap::bake
