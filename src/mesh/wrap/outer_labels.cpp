// Morphological closing: the outside is what the middle of a ball as wide as the gap reaches, and what lies as near to that as
// the ball's radius. The grid is dense here, since the outside is followed through all of it.
#include "grid.h"
#include "outer_steps.h"

#include "sqmap/math/box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sqmap::mesh {

namespace {

constexpr double k_edge_share = 0.5;    ///< an edge of the grid between two corners comes nearer by at most that, cells
constexpr double k_into_corner = 1.42;  ///< a ball's middle is so many radii from the corner of two upright walls
constexpr double k_touch_margin = 1e-6;

enum CornerState : std::uint8_t { k_free, k_near, k_touched, k_outside };

/// The corners of a box of cells.
class DenseCorners {
public:
    DenseCorners(LatticePoint lo, LatticePoint hi) : lo_(lo)
    {
        for (int k = 0; k < 3; ++k) count_[k] = static_cast<std::size_t>(hi[k] - lo[k]) + 1;
        state_.assign(count_[0] * count_[1] * count_[2], k_free);
    }
    [[nodiscard]] std::size_t index(LatticePoint p) const
    {
        return static_cast<std::size_t>(p[0] - lo_[0]) +
               count_[0] * (static_cast<std::size_t>(p[1] - lo_[1]) + count_[1] * static_cast<std::size_t>(p[2] - lo_[2]));
    }
    [[nodiscard]] LatticePoint point(std::size_t i) const
    {
        return {lo_[0] + static_cast<std::int32_t>(i % count_[0]), lo_[1] + static_cast<std::int32_t>(i / count_[0] % count_[1]),
                lo_[2] + static_cast<std::int32_t>(i / count_[0] / count_[1])};
    }
    [[nodiscard]] std::ptrdiff_t stride(int axis) const
    {
        return static_cast<std::ptrdiff_t>(axis == 0 ? 1 : (axis == 1 ? count_[0] : count_[0] * count_[1]));
    }
    std::uint8_t& operator[](std::size_t i) { return state_[i]; }
    [[nodiscard]] std::size_t size() const { return state_.size(); }
    [[nodiscard]] std::size_t count(int axis) const { return count_[axis]; }

private:
    LatticePoint lo_;
    std::array<std::size_t, 3> count_{};
    std::vector<std::uint8_t> state_;
};

class OuterLabeller {
public:
    OuterLabeller(const Mesh& soup, double gap) : soup_(soup), reach_(0.5 * gap + k_edge_share), dense_(around(soup, reach_)) {}

    OuterLabels run()
    {
        for (const Triangle& t : soup_.triangles) touch(t);
        block();
        flood();
        grow_back();
        return mixed_cells();
    }

private:
    static DenseCorners around(const Mesh& soup, double reach)
    {
        const Box box = box_of(soup.vertices);
        const auto rim = static_cast<std::int32_t>(std::ceil(reach)) + 3;
        LatticePoint lo{}, hi{};
        for (int k = 0; k < 3; ++k) {
            lo[k] = static_cast<std::int32_t>(std::floor(box.lo[k])) - rim;
            hi[k] = static_cast<std::int32_t>(std::floor(box.hi[k])) + 1 + rim;
        }
        return {lo, hi};
    }

    void touch(const Triangle& t)
    {
        const std::array<Vec3d, 3> corners{soup_.vertices[t[0]], soup_.vertices[t[1]], soup_.vertices[t[2]]};
        const Box box = box_of(corners);
        LatticePoint lo{}, hi{};
        for (int k = 0; k < 3; ++k) {
            lo[k] = static_cast<std::int32_t>(std::floor(box.lo[k] - k_touch_margin));
            hi[k] = static_cast<std::int32_t>(std::floor(box.hi[k] + k_touch_margin)) + 1;
        }
        touch_cells(corners, lo, hi);
    }

    /// Marks the corners of the cells of [lo, hi) that the triangle touches.
    void touch_cells(const std::array<Vec3d, 3>& triangle, LatticePoint lo, LatticePoint hi)
    {
        constexpr Vec3d k_rim{k_touch_margin, k_touch_margin, k_touch_margin};
        if (!touches(triangle, position(lo) - k_rim, position(hi) + k_rim)) return;
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (hi[k] - lo[k] > hi[axis] - lo[axis]) axis = k;
        if (hi[axis] - lo[axis] == 1) {
            const std::size_t first = dense_.index(lo);
            for (int k = 0; k < 8; ++k) {
                std::uint8_t& state =
                    dense_[first + static_cast<std::size_t>((k & 1) * dense_.stride(0) + (k >> 1 & 1) * dense_.stride(1) +
                                                            (k >> 2) * dense_.stride(2))];
                state = k_touched;
            }
            return;
        }
        LatticePoint low_end = hi, high_begin = lo;
        low_end[axis] = high_begin[axis] = lo[axis] + (hi[axis] - lo[axis]) / 2;
        touch_cells(triangle, lo, low_end);
        touch_cells(triangle, high_begin, hi);
    }

    /// Marks what lies within reach of a touched corner. A corner nearer than that to the soup is so near to a touched corner.
    void block()
    {
        const auto r = static_cast<std::int32_t>(std::floor(reach_));
        std::vector<std::ptrdiff_t> offsets;
        for (std::int32_t z = -r; z <= r; ++z)
            for (std::int32_t y = -r; y <= r; ++y)
                for (std::int32_t x = -r; x <= r; ++x)
                    if (x * x + y * y + z * z > 0 && x * x + y * y + z * z <= reach_ * reach_)
                        offsets.push_back(x * dense_.stride(0) + y * dense_.stride(1) + z * dense_.stride(2));
        for (std::size_t i = 0; i < dense_.size(); ++i) {
            if (dense_[i] != k_touched) continue;
            bool is_rim = false;
            for (int axis = 0; axis < 3; ++axis)
                is_rim = is_rim || dense_[i + dense_.stride(axis)] != k_touched || dense_[i - dense_.stride(axis)] != k_touched;
            if (!is_rim) continue;
            for (const std::ptrdiff_t offset : offsets)
                if (std::uint8_t& state = dense_[i + offset]; state == k_free) state = k_near;
        }
    }

    /// Marks the free corners that the first one reaches, row by row.
    void flood()
    {
        std::vector<std::size_t> seeds{0};
        const std::size_t row = dense_.count(0), rows = dense_.count(1), layers = dense_.count(2);
        while (!seeds.empty()) {
            const std::size_t seed = seeds.back();
            seeds.pop_back();
            if (dense_[seed] != k_free) continue;
            const std::size_t begin = seed / row * row;
            std::size_t lo = seed, hi = seed + 1;
            while (lo > begin && dense_[lo - 1] == k_free) --lo;
            while (hi < begin + row && dense_[hi] == k_free) ++hi;
            for (std::size_t i = lo; i < hi; ++i) dense_[i] = k_outside;
            const std::size_t y = seed / row % rows, z = seed / row / rows;
            const auto look = [&](std::ptrdiff_t offset) {
                for (std::size_t i = lo; i < hi; ++i)
                    if (dense_[i + offset] == k_free && (i == lo || dense_[i + offset - 1] != k_free))
                        seeds.push_back(i + offset);
            };
            if (y > 0) look(-dense_.stride(1));
            if (y + 1 < rows) look(dense_.stride(1));
            if (z > 0) look(-dense_.stride(2));
            if (z + 1 < layers) look(dense_.stride(2));
        }
    }

    /// From the outside through corners that the soup does not touch, as far as a ball in a corner of two walls leaves free.
    void grow_back()
    {
        struct Reached {
            std::size_t at, source;
        };
        std::vector<Reached> front;
        const auto each_neighbour = [&](std::size_t i, auto&& visit) {
            for (int axis = 0; axis < 3; ++axis)
                for (const std::ptrdiff_t step : {-dense_.stride(axis), dense_.stride(axis)}) visit(i + step);
        };
        for (std::size_t i = 0; i < dense_.size(); ++i) {
            if (dense_[i] != k_near) continue;
            bool is_next = false;
            each_neighbour(i, [&](std::size_t j) { is_next = is_next || dense_[j] == k_outside; });
            if (is_next) front.push_back({i, i});
        }
        // The source of the first ring is the outside corner itself; its distance is that of the ring less one.
        const double limit = std::max(k_into_corner * reach_ - 1, reach_ - 0.5);
        for (std::size_t k = 0; k < front.size(); ++k) {
            const Reached r = front[k];
            if (dense_[r.at] == k_outside) continue;
            const LatticePoint p = dense_.point(r.at), q = dense_.point(r.source);
            if (norm(position(p) - position(q)) > limit) continue;
            dense_[r.at] = k_outside;
            each_neighbour(r.at, [&](std::size_t j) {
                if (dense_[j] == k_near || dense_[j] == k_free) front.push_back({j, r.source});
            });
        }
    }

    OuterLabels mixed_cells()
    {
        OuterLabels out;
        const std::size_t row = dense_.count(0);
        std::vector<std::uint8_t> sum(row);
        for (std::size_t z = 0; z + 1 < dense_.count(2); ++z)
            for (std::size_t y = 0; y + 1 < dense_.count(1); ++y) {
                const std::size_t begin = row * (y + dense_.count(1) * z);
                const std::uint8_t* const at = &dense_[begin];
                const std::ptrdiff_t dy = dense_.stride(1), dz = dense_.stride(2);
                for (std::size_t x = 0; x < row; ++x)
                    sum[x] = static_cast<std::uint8_t>((at[x] == k_outside) + (at[x + dy] == k_outside) +
                                                       (at[x + dz] == k_outside) + (at[x + dy + dz] == k_outside));
                for (std::size_t x = 0; x + 1 < row; ++x)
                    if (const int outside = sum[x] + sum[x + 1]; outside != 0 && outside != 8)
                        out.grid.add_cell(dense_.point(begin + x));
            }
        for (std::uint32_t c = 0; c < out.grid.corners.size(); ++c) {
            const std::uint8_t state = dense_[dense_.index(out.grid.corners.point(c))];
            out.inside.push_back(state == k_outside ? 0 : (state == k_touched ? k_beside_input : k_sealed));
        }
        return out;
    }

    const Mesh& soup_;
    double reach_;  ///< of what is too narrow, cells
    DenseCorners dense_;
};

}  // namespace

OuterLabels outer_labels(const Mesh& soup, double gap) { return OuterLabeller(soup, gap).run(); }

}  // namespace sqmap::mesh
