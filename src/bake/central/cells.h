// From what is known of a base cell to its words in the map.
#pragma once

#include "bake/central/cell.h"
#include "bake/central/central_map.h"
#include "bake/central/central_options.h"
#include "bake/central/mixed_cells.h"
#include "model/central_cells.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace sqmap::bake {

/// Appends the cells of one map, whose range has been chosen.
class CentralCellBaker {
public:
    /// mixed: of the same projection and options.
    CentralCellBaker(const Projection& projection, const CentralOptions& options, MixedCells& mixed, CentralMapData& map)
        : projection_(projection), options_(options), mixed_(mixed), map_(map), deviations_(map.range.w_step)
    {
    }

    /// One cell; what hangs on it is appended to the map's splits, specials and pool.
    /// @throw mesh::RefusedMesh where the part needs more refined cells than a map can number
    [[nodiscard]] model::CentralCell bake(const Cell& cell);

private:
    struct Sheets;

    [[nodiscard]] bool fits_another(const Cell& cell) const;
    [[nodiscard]] std::optional<Sheets> measure_sheets(const Cell& cell) const;
    [[nodiscard]] std::optional<model::CentralCell> add_special();
    [[nodiscard]] std::optional<model::CentralCell> store_sheets(const Sheets& sheets, bool foreign);
    [[nodiscard]] std::optional<model::CentralCell> split(const Cell& cell);
    [[nodiscard]] std::vector<Polygon> spare_footprints();
    [[nodiscard]] model::CentralCell store_mixed(const MixedCell& mixed, const CellSquare& square, bool foreign);
    void store_planes(const RayPlanes& planes, const MixedCell& mixed, const CellSquare& square);

    const Projection& projection_;
    const CentralOptions& options_;
    MixedCells& mixed_;
    CentralMapData& map_;
    model::DeviationCodes deviations_;
    std::vector<std::vector<Polygon>> spare_;
};

/// A ray's nearest crossing as stored.
[[nodiscard]] std::uint16_t stored_sample(const RaySample& ray, const model::SampleRange& range);

}  // namespace sqmap::bake
