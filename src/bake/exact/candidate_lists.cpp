#include "candidate_lists.h"

#include "bake/budget.h"
#include "bake/exact/record.h"
#include "bake/exact/rise_above_planes.h"
#include "bake/locator/grid.h"
#include "bake/locator/near_triangles.h"
#include "model/candidate_lists.h"
#include "model/locator_cells.h"
#include "parallel/for_each.h"
#include "sqmap/math/box.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace sqmap::bake {

namespace {

using model::CandidateRecord;
using model::LocatorBrick;
using model::LocatorCell;
using Triangles = std::vector<std::uint32_t>;

constexpr double k_least_near_share = 0.4;

/// The bytes left for the lists.
double near_budget(const model::ModelData& data, double target_error)
{
    const model::ModelView v = data.view();
    const std::size_t others = v.parts.size_bytes() + model::bytes_of<model::CentralArrays<model::ArrayView>>(v) +
                               model::bytes_of<model::MeshArrays<model::ArrayView>>(v) +
                               model::bytes_of<model::LocatorArrays<model::ArrayView>>(v) + v.rises.size_bytes() +
                               4 * v.bricks.size();
    const double all = model_byte_budget(v.triangle_part.size(), target_error);
    // A large map must not take them all.
    return std::max(all - static_cast<double>(others), k_least_near_share * all);
}

/// The list of a cell, or the lists of its eighths where it is divided. near: the triangles near it.
void set_rises(Rise& rise, const CellCube& cube, std::uint32_t index, const Triangles& near, model::ModelData& data)
{
    const LocatorCell cell{data.locator_cells[index]};
    if (cell.is_divided()) {
        for (std::uint32_t e = 0; e < 8; ++e) set_rises(rise, cube.eighth(e), cell.first() + e, near, data);
    } else if (cell.kind() == model::LocatorCellKind::Mixed && cell.is_flat()) {
        data.rises[index] = rise(data, cell, cube, near);
    }
}

/// A cell of a brick that is not free.
struct ListedCell {
    std::uint32_t number;  ///< in the brick
    CellCube cube;
    bool is_reached;         ///< its list is made anew
    const Triangles* known;  ///< the triangles near it, where an update has found them; or null
};

/// The input from which a brick's lists are made.
struct ListedBrick {
    LocatorBrick brick;
    CellCube cube;
    std::uint32_t before = LocatorUpdate::k_no_brick;  ///< which one it was
    std::uint64_t reached = ~std::uint64_t{0};         ///< its cells with another nearest surface
    std::vector<ListedCell> cells;
};

ListedBrick listed_brick(const model::ModelData& data, const ListsBefore* before, std::size_t number)
{
    const Grid grid = grid_of(data.locator);
    ListedBrick listed{
        LocatorBrick{data.bricks[number]}, grid.brick_cube(number), LocatorUpdate::k_no_brick, ~std::uint64_t{0}, {}};
    if (before != nullptr) listed.before = before->update.brick_before[number];
    if (listed.before != LocatorUpdate::k_no_brick) listed.reached = before->update.reached[number];
    for (std::uint32_t k = 0; k < listed.brick.cell_count(); ++k) {
        if (LocatorCell{data.locator_cells[listed.brick.first() + k]}.is_free()) continue;
        const bool reached = (listed.reached >> k & 1u) != 0;
        const bool known =
            reached && before != nullptr && !before->update.near[number].empty() && !before->update.near[number][k].empty();
        listed.cells.push_back({k, listed.brick.is_deep() ? listed.cube : grid.cell_cube(number, k), reached,
                                known ? &before->update.near[number][k] : nullptr});
    }
    return listed;
}

/// The triangles near each cell of a brick that is reached, in the order of listed.cells; of the others none. fine: as short as
/// can be.
std::vector<Triangles> lists_of(const mesh::Solid& solid, const ListedBrick& listed, bool fine)
{
    thread_local NearTriangles search;  // keeps its memory
    std::vector<Triangles> lists(listed.cells.size());
    // Eight cells at a time: what can be nearest somewhere in the whole brick is four times as many.
    for (std::uint32_t octant = 0; octant < (listed.brick.is_deep() ? 1u : 8u); ++octant) {
        std::vector<std::size_t> group;
        std::vector<Vec3d> centres;
        Box box;
        for (std::size_t i = 0; i < listed.cells.size(); ++i) {
            const ListedCell& cell = listed.cells[i];
            const Vec3d d = cell.cube.centre - listed.cube.centre;
            if (!cell.is_reached) continue;
            if (!listed.brick.is_deep() && ((d.x > 0 ? 1u : 0u) | (d.y > 0 ? 2u : 0u) | (d.z > 0 ? 4u : 0u)) != octant) continue;
            if (cell.known != nullptr) {
                lists[i] = *cell.known;
                continue;
            }
            group.push_back(i);
            centres.push_back(cell.cube.centre);
            extend(box, cell.cube.centre);
        }
        if (group.empty()) continue;
        const Vec3d extent = size(box), middle = centre(box);
        const double side = std::max({extent.x, extent.y, extent.z}), half = listed.cells.front().cube.half();
        search.begin(solid, middle, k_near_slack * (0.5 * side + half), centres, solid.closest_boundary(middle).distance);
        for (std::size_t i = 0; i < group.size(); ++i) lists[group[i]] = search(i, centres[i], k_near_slack * half, fine);
    }
    return lists;
}

/// A brick's record; sets the rises of its cells. before: null, or what was there.
BrickRecord bake_record(const mesh::Solid& solid, const ListsBefore* before, std::size_t number, model::ModelData& data)
{
    const ListedBrick listed = listed_brick(data, before, number);
    if (listed.reached == 0) return {before->model, listed.before};
    const std::vector<Triangles> lists = lists_of(solid, listed, before == nullptr);
    Rise rise(solid);
    BrickRecord record(model::has_wide_candidates(data.triangle_part.size()));
    thread_local BrickRecord::Numbers numbers;
    numbers.begin(data.triangle_part.size());
    for (std::size_t i = 0; i < listed.cells.size(); ++i) {
        const ListedCell& cell = listed.cells[i];
        if (!cell.is_reached) {
            const model::CandidateList list = model::candidate_list(before->model, listed.before, cell.number);
            Triangles kept;
            list.each([&](std::uint32_t t) { kept.push_back(t); });
            record.add(cell.number, kept, numbers);
            continue;
        }
        const CellCube larger{cell.cube.centre, k_near_slack * cell.cube.side};
        set_rises(rise, larger, listed.brick.first() + cell.number, lists[i], data);
        record.add(cell.number, lists[i], numbers);
    }
    // A brick whose lists were too long to keep has none to take over, and gets none.
    if (listed.before != LocatorUpdate::k_no_brick && before->model.near_bricks[listed.before] != model::k_no_candidates &&
        listed.reached != ~std::uint64_t{0}) {
        const CandidateRecord was = model::candidate_record(before->model, listed.before);
        if (was.list_values() == 0) record.drop_lists();
        if (was.triangles == 0) record.drop_triangles();
    }
    return record;
}

}  // namespace

void bake_candidate_lists(const mesh::Solid& solid, const ListsBefore* before, const LocatorOptions& options,
                          model::ModelData& data)
{
    data.near_bricks.clear();
    data.near.clear();
    if (data.bricks.empty() || data.triangle_part.empty()) {
        data.rises.clear();
        return;
    }
    std::vector<BrickRecord> records(data.bricks.size());
    parallel::for_each(records.size(), options.threads, [&](std::size_t b) {
        if (!LocatorBrick{data.bricks[b]}.is_free()) records[b] = bake_record(solid, before, b, data);
    });
    keep_within(near_budget(data, options.target_error), records);
    for (std::size_t b = 0; b < records.size(); ++b) {
        const bool free = LocatorBrick{data.bricks[b]}.is_free();
        data.near_bricks.push_back(free ? model::k_no_candidates : static_cast<std::uint32_t>(data.near.size()));
        if (!free) records[b].pack(data.near);
    }
}

}  // namespace sqmap::bake
