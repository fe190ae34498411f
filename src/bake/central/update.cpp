#include "update.h"

#include <algorithm>
#include <cmath>

namespace sqmap::bake {

using model::CellKind;
using model::CentralCell;

ReachedCells all_cells(int side)
{
    const auto count = static_cast<std::size_t>(side * side);
    return {std::vector<std::uint8_t>(count, 1), std::vector<std::uint8_t>(count, 1), side};
}

KnownCells::KnownCells(const KnownMap& known, const Projection& projection) : known_(known)
{
    std::vector<std::uint8_t> is_changed(known.mesh.triangles.size(), 0);
    for (const std::uint32_t t : known.changed) is_changed[t] = 1;
    projection.append_footprints(known.mesh, known.changed, changed_);
    for (std::size_t face = 0; face < model::k_faces; ++face)
        for (const Polygon& p : projection.footprints()[face])
            if (is_changed[p.triangle] != 0) changed_[face].push_back(p);
}

ReachedCells KnownCells::reached(int face) const
{
    const auto n = static_cast<int>(known_.part.base);
    const double size = 2.0 / n;
    const auto count = static_cast<std::size_t>(n * n);
    ReachedCells reached{std::vector<std::uint8_t>(count, 0), std::vector<std::uint8_t>(count, 0), n};
    struct Span {
        int first, last;
    };
    const auto mark = [&](std::vector<std::uint8_t>& cells, Span rows, Span columns) {
        for (int row = std::max(rows.first, 0); row <= std::min(rows.last, n - 1); ++row)
            for (int column = std::max(columns.first, 0); column <= std::min(columns.last, n - 1); ++column)
                cells[static_cast<std::size_t>(row * n + column)] = 1;
    };
    const auto cell = [&](double v) { return static_cast<int>(std::floor((v + 1) / size)); };
    for (const Polygon& p : changed_[static_cast<std::size_t>(face)]) {
        const Extent e = extent_of(p);
        mark(reached.anew, {cell(e.lo_t - k_cell_border) - 1, cell(e.hi_t + k_cell_border) + 1},
             {cell(e.lo_s - k_cell_border) - 1, cell(e.hi_s + k_cell_border) + 1});
    }
    for (int row = 0; row < n; ++row)
        for (int column = 0; column < n; ++column) {
            if (!reached.is_anew(row, column)) continue;
            const int r = row - row % model::k_block, c = column - column % model::k_block;
            mark(reached.listed, {row - 1, row + 1}, {column - 1, column + 1});
            mark(reached.listed, {r, r + model::k_block - 1}, {c, c + model::k_block - 1});
        }
    return reached;
}

std::optional<CentralCell> KnownCells::keep(CentralCell was, CentralMapData& map) const
{
    if (was.kind() == CellKind::Split) {
        const std::size_t record = map.splits.size();
        if (record / model::k_split_size >= model::k_max_payload) return std::nullopt;
        const std::uint16_t* from = known_.own.splits.data() + model::k_split_size * std::size_t{was.payload()};
        map.splits.insert(map.splits.end(), from, from + model::k_split_size);
        for (std::size_t i = model::k_split_cells; i < model::k_split_size; ++i) {
            const std::optional<CentralCell> child = keep({from[i]}, map);
            if (!child) return std::nullopt;
            map.splits[record + i] = child->word;
        }
        return CentralCell::of(CellKind::Split, record / model::k_split_size);
    }
    if (was.kind() == CellKind::Layered) {
        const std::uint16_t* from = known_.own.pool.data() + known_.own.specials[was.payload()];
        if (map.specials.size() >= model::k_max_payload) return std::nullopt;
        const CentralCell cell = CentralCell::of(CellKind::Layered, map.specials.size());
        map.specials.push_back(static_cast<std::uint32_t>(map.pool.size()));
        map.pool.insert(map.pool.end(), from, from + model::LayeredHead{*from}.record_size());
        return cell;
    }
    return was;
}

}  // namespace sqmap::bake
