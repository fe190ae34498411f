// Dual marching cubes (Nielson 2004): each polygon of marching cubes becomes a vertex, each crossed edge a quadrilateral. The
// dual of a closed manifold is one, except where two polygons share two edges (Wenger 2013, chapter 3); there the edges of
// the dual get a vertex each.
#include "steps.h"

#include <algorithm>
#include <tuple>

namespace sqmap::mesh {

namespace {

constexpr std::uint8_t k_uncrossed = 0xff;

/// The polygons of marching cubes in a cell. Edge 4 a + u + 2 v runs along axis a, at u along axis a + 1 and v along a + 2.
struct Sheets {
    std::uint8_t count = 0;
    std::array<std::uint8_t, 12> of_edge{};  ///< k_uncrossed where no sheet crosses the edge
};

constexpr int corner_at(int axis, int along, int u, int v) { return along << axis | u << (axis + 1) % 3 | v << (axis + 2) % 3; }

/// The edge between two corners of a cell that differ in one bit.
constexpr int edge_between(int a, int b)
{
    const int axis = (a ^ b) == 1 ? 0 : ((a ^ b) == 2 ? 1 : 2);
    return 4 * axis + (a >> (axis + 1) % 3 & 1) + 2 * (a >> (axis + 2) % 3 & 1);
}

/// On each side, seen from outside the cell and counter-clockwise, an edge where the solid ends is linked to the next one where
/// it begins: inside corners are joined across the side's middle.
Sheets sheets_of(int inside)
{
    std::array<int, 12> next{};
    next.fill(-1);
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2, upper = side % 2;
        int around[4];
        for (int i = 0; i < 4; ++i) {
            const int k = upper ? i : 3 - i;
            around[i] = corner_at(axis, upper, k == 1 || k == 2, k >= 2);
        }
        for (int i = 0; i < 4; ++i) {
            const int a = around[i], b = around[(i + 1) % 4];
            if (!(inside >> a & 1) || (inside >> b & 1)) continue;
            int j = i + 1;
            while (!(inside >> around[(j + 1) % 4] & 1)) ++j;
            next[edge_between(a, b)] = edge_between(around[j % 4], around[(j + 1) % 4]);
        }
    }
    Sheets sheets;
    sheets.of_edge.fill(k_uncrossed);
    for (int e = 0; e < 12; ++e) {
        if (next[e] < 0 || sheets.of_edge[e] != k_uncrossed) continue;
        for (int at = e; sheets.of_edge[at] == k_uncrossed; at = next[at]) sheets.of_edge[at] = sheets.count;
        ++sheets.count;
    }
    return sheets;
}

/// An edge of the dual that another edge between the same sheets doubles.
struct Twin {
    std::uint32_t lo, hi, outside, quad;
    int k;
    [[nodiscard]] auto key() const { return std::tuple(lo, hi, outside); }
};

class Builder {
public:
    Builder(const Grid& grid, std::span<const std::uint8_t> inside) : grid_(grid), inside_(inside)
    {
        for (int i = 0; i < 256; ++i) table_[i] = sheets_of(i);
    }

    DualSurface run()
    {
        first_vertex_.reserve(grid_.cells.size());
        for (std::uint32_t cell = 0; cell < grid_.cells.size(); ++cell) {
            first_vertex_.push_back(static_cast<std::uint32_t>(surface_.vertex_cell.size()));
            for (int i = 0; i < table_[mask(cell)].count; ++i) surface_.vertex_cell.push_back(cell);
        }
        for (std::uint32_t cell = 0; cell < grid_.cells.size(); ++cell)
            for (int axis = 0; axis < 3; ++axis) add_quad(cell, axis);
        split_twins();
        return std::move(surface_);
    }

private:
    [[nodiscard]] int mask(std::uint32_t cell) const
    {
        int mask = 0;
        for (int k = 0; k < 8; ++k) mask |= (inside_[grid_.cell_corners[cell][k]] != 0) << k;
        return mask;
    }

    /// The quadrilateral about the edge along an axis from the cell's corner 0.
    void add_quad(std::uint32_t cell, int axis)
    {
        const std::uint32_t low = grid_.cell_corners[cell][0], high = grid_.cell_corners[cell][1 << axis];
        const bool low_inside = inside_[low] != 0;
        if (low_inside == (inside_[high] != 0)) return;
        DualQuad quad;
        quad.cell = cell;
        quad.inside = low_inside ? low : high;
        quad.outside = low_inside ? high : low;
        quad.between.fill(KeyTable::k_absent);
        std::array<std::uint32_t, 4> cells{};
        for (int i = 0; i < 4; ++i) {
            const int turn = low_inside ? i : 3 - i, u = turn == 1 || turn == 2, v = turn >= 2;
            LatticePoint p = grid_.cells.point(cell);
            p[(axis + 1) % 3] -= u;
            p[(axis + 2) % 3] -= v;
            cells[i] = grid_.cells.find(p);
            quad.vertices[i] = first_vertex_[cells[i]] + table_[mask(cells[i])].of_edge[4 * axis + u + 2 * v];
        }
        const auto index = static_cast<std::uint32_t>(surface_.quads.size());
        surface_.quads.push_back(quad);
        for (int i = 0; i < 4; ++i) {
            if (!ambiguous(cells[i], cells[(i + 1) % 4])) continue;
            const auto [lo, hi] = std::minmax(quad.vertices[i], quad.vertices[(i + 1) % 4]);
            twins_.push_back({lo, hi, quad.outside, index, i});
        }
    }

    /// True if the corners of the side that two cells share alternate.
    [[nodiscard]] bool ambiguous(std::uint32_t a, std::uint32_t b) const
    {
        const LatticePoint &p = grid_.cells.point(a), &q = grid_.cells.point(b);
        int axis = 0;
        while (p[axis] == q[axis]) ++axis;
        const int upper = q[axis] > p[axis], m = mask(a);
        const auto at = [&](int u, int v) { return m >> corner_at(axis, upper, u, v) & 1; };
        return at(0, 0) == at(1, 1) && at(1, 0) == at(0, 1) && at(0, 0) != at(1, 0);
    }

    /// Both quadrilaterals at a stretch of a side have its outside corner as the end of their edge.
    void split_twins()
    {
        std::sort(twins_.begin(), twins_.end(),
                  [](const Twin& a, const Twin& b) { return std::pair(a.key(), a.quad) < std::pair(b.key(), b.quad); });
        for (std::size_t i = 0; i < twins_.size();) {
            std::size_t j = i;
            while (j < twins_.size() && twins_[j].lo == twins_[i].lo && twins_[j].hi == twins_[i].hi) ++j;
            for (std::size_t k = i; j - i == 4 && k < j; ++k)
                surface_.quads[twins_[k].quad].between[twins_[k].k] =
                    static_cast<std::uint32_t>(surface_.vertex_cell.size()) + surface_.between_count++ / 2;
            i = j;
        }
        surface_.between_count /= 2;
    }

    const Grid& grid_;
    std::span<const std::uint8_t> inside_;
    std::array<Sheets, 256> table_;
    std::vector<std::uint32_t> first_vertex_;
    std::vector<Twin> twins_;
    DualSurface surface_;
};

}  // namespace

DualSurface dual_surface(const Grid& grid, std::span<const std::uint8_t> inside) { return Builder(grid, inside).run(); }

}  // namespace sqmap::mesh
