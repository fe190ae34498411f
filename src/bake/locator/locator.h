// The grid that leads a point in space to the chart that answers it and to where its nearest surface is.
#pragma once

#include "bake/locator/change.h"
#include "bake/locator/grid.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::bake {

/// A solid whose triangles belong to parts.
struct PartedSolid {
    const mesh::Solid& solid;                         ///< of the mesh in model space
    std::span<const std::uint32_t> part_of_triangle;  ///< #triangles
};

struct LocatorOptions {
    double target_error = 0.5;  ///< percent of R_max: sets the cell, how flat a flat cell is, and how many bytes may be taken
    unsigned threads = 0;       ///< 0: one per core; the result does not depend on it
};

/// By how much a cell's planes may miss the surface at its worst sample, model units; at most points it is a tenth.
/// target_error: percent of r_max.
[[nodiscard]] inline double flat_tolerance(double target_error, double r_max)
{
    constexpr double k_flat_share = 0.4;  // of the target error
    return 0.01 * k_flat_share * target_error * r_max;
}

/// Fills data's locator from its finished parts and central maps; leaves it empty where some part has no central map or there are
/// 255 parts or more. Cost: a closest-point query per cell near the solid.
void bake_locator(const PartedSolid& surface, const LocatorOptions& options, model::ModelData& data);

/// The same, where more bytes may be tried after less: cells that were baked are not baked again. Not thread-safe.
class GrowingLocator {
public:
    /// The surface's referents and data outlive it; between calls, data's parts and maps stay as they are.
    GrowingLocator(const PartedSolid& surface, const LocatorOptions& options, model::ModelData& data);
    ~GrowingLocator();
    GrowingLocator(const GrowingLocator&) = delete;
    GrowingLocator& operator=(const GrowingLocator&) = delete;

    /// more: times the bytes that it may take, no less than before. False: it is the same as before, since there is nothing to
    /// divide, or there is none.
    bool bake(double more = 1);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The result of a locator's update that the candidate lists are updated from.
struct LocatorUpdate {
    static constexpr std::uint32_t k_no_brick = EnclosingGrid::k_no_brick;
    std::vector<std::uint32_t> brick_before;  ///< #bricks: which one each was, or k_no_brick
    std::vector<std::uint64_t>
        reached;  ///< #bricks: which of its 64 cells (of a deep one: the first) have another nearest surface
    /// Per brick: empty, or for each of its cells the triangles near that cell; filled where the bake needs them.
    std::vector<std::vector<std::vector<std::uint32_t>>> near;
};

/// Bakes what a change reaches of data's locator, which was baked before it, anew; data's parts and maps are those after it. The
/// grid stays, but for bricks that are added about it where the mesh left it. surface: after the change.
[[nodiscard]] LocatorUpdate update_locator(const PartedSolid& surface, const LocatorOptions& options, const Change& change,
                                           model::ModelData& data);

}  // namespace sqmap::bake
