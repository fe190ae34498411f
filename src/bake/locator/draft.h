// Drafts of the locator's cells, before they are packed.
#pragma once

#include "bake/locator/grid.h"
#include "model/locator_cells.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// A plane as the model stores it, with the part that the model's list names apart.
struct PartPlane {
    model::LocatorPlane plane;
    std::uint32_t part;
};

struct CellDraft {
    model::LocatorCellKind kind = model::LocatorCellKind::Free;
    double gap = 0;  ///< Free: from the centre to the solid, model units
    model::PartList parts{model::k_no_part, model::k_no_part, model::k_no_part, model::k_no_part};
    std::vector<PartPlane> planes;  ///< of a flat cell
    std::uint8_t rise = model::k_no_rise;
    std::vector<model::Seed> seeds;   ///< of another
    std::uint32_t choices = 0;        ///< which seed comes first in each octant, three bits each
    double miss = 0;                  ///< of the seeds: see SeedChain
    std::vector<CellDraft> eighths;   ///< of a cell that is divided, x fastest
    std::vector<std::uint32_t> near;  ///< in an update, of one that is baked anew: the triangles near it
};

struct BrickDraft {
    enum class Kind { Free, Deep, Stored } kind = Kind::Stored;
    std::vector<CellDraft> cells;  ///< one, or of a stored brick all; none where only the kind was needed
};

/// The input from which cells are baked. The referents outlive it.
struct LocatorSubject {
    const mesh::Solid& solid;                         ///< of the mesh in model space
    std::span<const std::uint32_t> part_of_triangle;  ///< #triangles
    model::ModelView model;                           ///< its parts and central maps, and the locator's cell and reach
    double flat_tolerance;                            ///< by how much a cell's planes may miss the surface, model units

    [[nodiscard]] double cell() const { return static_cast<double>(model.locator.cell); }
};

/// All bricks packed into data's locator arrays, whose grid is set: words, part lists, planes and seeds.
/// @throw mesh::InvalidInput where it needs more cells or planes than a word can name
void pack(std::span<const BrickDraft> bricks, model::ModelData& data);

/// The other direction: packed again they are the same.
[[nodiscard]] std::vector<BrickDraft> unpack(const model::ModelData& data);

/// Bytes of data's locator.
[[nodiscard]] std::size_t packed_bytes(const model::ModelData& data);

}  // namespace sqmap::bake
