// A map after some of the mesh moved: cells that no changed triangle reaches are taken over.
#pragma once

#include "bake/central/central_map.h"
#include "bake/central/project.h"
#include "model/central_cells.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace sqmap::bake {

/// Which base cells of a face are baked.
struct ReachedCells {
    std::vector<std::uint8_t> anew;    ///< #cells: with a changed triangle over them or beside them, for neighbours share samples
    std::vector<std::uint8_t> listed;  ///< #cells: those whose triangles are needed for these and their blocks
    int side = 0;                      ///< cells along a side

    /// False beyond the face too.
    [[nodiscard]] bool is_anew(int row, int column) const
    {
        return row >= 0 && column >= 0 && row < side && column < side && anew[static_cast<std::size_t>(row * side + column)] != 0;
    }
};

/// All cells of a face with so many along a side.
[[nodiscard]] ReachedCells all_cells(int side);

/// The cells that may be taken over from a known map.
class KnownCells {
public:
    /// projection: of the mesh as it is now, in the known map's chart.
    KnownCells(const KnownMap& known, const Projection& projection);

    [[nodiscard]] ReachedCells reached(int face) const;

    /// The sample, cell or block of that number.
    [[nodiscard]] std::uint16_t sample(std::size_t i) const { return known_.own.samples[i]; }
    [[nodiscard]] model::Block block(std::size_t i) const { return known_.own.blocks[i]; }
    /// The cell's records are appended to map. Returns nothing where map has no space for them.
    [[nodiscard]] std::optional<model::CentralCell> cell(std::size_t i, CentralMapData& map) const
    {
        return keep({known_.own.cells[i]}, map);
    }

private:
    [[nodiscard]] std::optional<model::CentralCell> keep(model::CentralCell was, CentralMapData& map) const;

    KnownMap known_;
    Footprints changed_;  ///< of changed triangles, where they were and where they are
};

}  // namespace sqmap::bake
