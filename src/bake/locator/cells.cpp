#include "cells.h"

#include "bake/locator/domains.h"
#include "bake/locator/near_triangles.h"
#include "bake/locator/planes.h"
#include "bake/locator/samples.h"
#include "bake/locator/seeds.h"

#include <cmath>
#include <optional>
#include <utility>

namespace sqmap::bake {

using model::LocatorCellKind;

namespace {

constexpr int k_max_loosened = 5;  ///< times that the tolerance is doubled

}  // namespace

mesh::ClosestPoint closest_from(const mesh::Solid& solid, Vec3d known, Vec3d p)
{
    return solid.closest_boundary(p, 1.000001 * norm(known - p) + 1e-12);
}

std::vector<std::uint32_t> triangles_near(const mesh::Solid& solid, const CellCube& cube, double distance)
{
    thread_local NearTriangles search;  // keeps its memory
    const double half = 0.5 * k_near_slack * cube.side;
    search.begin(solid, cube.centre, half, {&cube.centre, 1}, distance);
    return search(0, cube.centre, half, /*fine=*/false);
}

CellDraft CellBaker::bake(const CellCube& cube, const KnownWinding* outer) const
{
    return bake(cube, subject_.solid.closest_boundary(cube.centre), {}, outer);
}

CellDraft CellBaker::bake(const CellCube& cube, const mesh::ClosestPoint& nearest, std::span<const std::uint32_t> near,
                          const KnownWinding* outer) const
{
    CellDraft draft;
    const KnownWinding winding(subject_.solid, cube.centre, nearest.distance, outer);
    const bool crossed = nearest.distance <= 0.5 * std::sqrt(3.0) * cube.side * 1.0001;
    const bool inside = is_inside(winding, cube.centre, nearest);
    if (!crossed && !inside) {
        draft.gap = nearest.distance;
        return draft;
    }
    draft.kind = crossed ? LocatorCellKind::Mixed : LocatorCellKind::Inside;
    if (crossed && cube.side > 1.5 * subject_.cell()) return draft;  // a brick that is stored cell by cell
    if (keeps_near_ && near.empty()) {
        draft.near = triangles_near(subject_.solid, cube, nearest.distance);
        near = draft.near;
    }
    const SurfaceCell cell{subject_, cube, draft.kind, {cube.centre, nearest, inside}, near, subject_.flat_tolerance, winding};
    find_surface(cell, draft);
    if (crossed) list_parts(subject_, cube, subject_.part_of_triangle[nearest.triangle], draft);
    return draft;
}

void CellBaker::find_surface(SurfaceCell cell, CellDraft& draft) const
{
    CellSampler sampler(cell);
    std::vector<Sample> samples = sampler.samples();
    const auto is_flat = [&] {
        std::vector<Sample> checked = samples;
        std::optional<std::vector<PartPlane>> planes = flat_planes(cell, sampler, checked);
        if (planes) draft.planes = std::move(*planes);
        return planes.has_value();
    };
    if (is_flat()) return;
    sampler.add_more(samples);
    SeedChain chain = seed_chain(cell, samples);
    // Charts may not show the nearest sheet. Planes, with a looser tolerance, then answer a cell that is too small to be divided.
    constexpr double k_least = 1.5 / (1 << model::k_max_divisions);  // of the cell: above the smallest of them
    for (int loosened = 0; loosened < k_max_loosened && cell.cube.side < k_least * subject_.cell(); ++loosened) {
        cell.tolerance *= 2;
        if (!(cell.tolerance < chain.miss)) break;
        if (is_flat()) return;
    }
    draft.seeds = std::move(chain.seeds);
    draft.choices = chain.choices;
    draft.miss = chain.miss;
}

std::vector<CellDraft> CellBaker::bake_eighths(const CellCube& cube, std::span<const std::uint32_t> near, int divisions,
                                               const KnownWinding* outer) const
{
    std::vector<CellDraft> eighths;
    mesh::ClosestPoint nearest = subject_.solid.closest_boundary(cube.centre);
    const KnownWinding winding(subject_.solid, cube.centre, nearest.distance, outer);
    for (std::size_t e = 0; e < 8; ++e) {
        const CellCube eighth = cube.eighth(e);
        nearest = closest_from(subject_.solid, nearest.point, eighth.centre);
        eighths.push_back(bake(eighth, nearest, near, &winding));
        if (eighths.back().miss > subject_.flat_tolerance && divisions > 1)
            eighths.back().eighths = bake_eighths(eighth, near, divisions - 1, &winding);
    }
    return eighths;
}

BrickDraft CellBaker::bake_brick(const Grid& grid, std::size_t brick, bool in_full) const
{
    const CellCube cube = grid.brick_cube(brick);
    const mesh::ClosestPoint nearest = subject_.solid.closest_boundary(cube.centre);
    CellDraft whole = bake(cube, nearest);
    // A brick without planes of its own is stored cell by cell, even deep inside: a search there would take ten times as long.
    if (whole.kind == LocatorCellKind::Free || !whole.planes.empty()) {
        const auto kind = whole.kind == LocatorCellKind::Free ? BrickDraft::Kind::Free : BrickDraft::Kind::Deep;
        return {kind, {std::move(whole)}};
    }
    BrickDraft draft;
    const KnownWinding winding(subject_.solid, cube.centre, nearest.distance);
    for (std::size_t i = 0; i < model::k_brick_cells && in_full; ++i)
        draft.cells.push_back(bake(grid.cell_cube(brick, i), &winding));
    return draft;
}

}  // namespace sqmap::bake
