// Reading the central map: leaves, their surfaces and certified bounds, verdicts. Header-only, allocation-free.
#pragma once

#include "model/central_cells.h"
#include "model/flags.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace sqmap::model {

/// A leaf cell, or the side of a divided one, ready to be read.
struct Leaf {
    CellKind kind = CellKind::Uniform;
    bool centre_inside = false;
    bool bilinear = false;  ///< Layered: sheets have four corners each
    bool foreign = false;   ///< no surface over it is the part's own
    int sheets = 0;         ///< Uniform 0, Single 1
    float s0 = 0, t0 = 0, size = 0;
    SampleRange range;
    float corner[4] = {};                   ///< Single: w at (s0,t0) (s1,t0) (s0,t1) (s1,t1)
    float deviation = 0;                    ///< Single
    const std::uint16_t* record = nullptr;  ///< Layered, past the header word
    const std::uint16_t* planes = nullptr;  ///< mixed: three words a sheet
    bool flips = false;                     ///< mixed: the verdict beyond the band differs from the centre's
    bool divided = false;                   ///< mixed: the leaf lies left of the way from one border point to another
    float from[2] = {}, to[2] = {};         ///< s and t of these
};

/// w and its derivatives on a sheet of a leaf.
using SheetValue = ChartPlane<float>;

inline SheetValue bilinear_value(const float c[4], float u, float v, float size)
{
    const float bottom = c[0] + u * (c[1] - c[0]), top = c[2] + u * (c[3] - c[2]);
    return {bottom + v * (top - bottom), ((1.f - v) * (c[1] - c[0]) + v * (c[3] - c[2])) / size, (top - bottom) / size};
}

inline SheetValue sheet_value(const Leaf& leaf, int sheet, float s, float t)
{
    const float u = (s - leaf.s0) / leaf.size, v = (t - leaf.t0) / leaf.size;
    if (leaf.kind == CellKind::Single) return bilinear_value(leaf.corner, u, v, leaf.size);
    if (leaf.bilinear) {
        const std::uint16_t* r = bilinear_sheet(leaf.record, sheet);
        const float c[4] = {leaf.range.decode(r[0]), leaf.range.decode(r[1]), leaf.range.decode(r[2]), leaf.range.decode(r[3])};
        return bilinear_value(c, u, v, leaf.size);
    }
    const std::uint16_t* r = leaf.planes + 3 * sheet;
    const float half = 0.5f * leaf.size;
    const float ws = decode_slope(r[1]) * leaf.range.w_step / half;
    const float wt = decode_slope(r[2]) * leaf.range.w_step / half;
    return {leaf.range.decode(r[0]) + (s - leaf.s0 - half) * ws + (t - leaf.t0 - half) * wt, ws, wt};
}

/// Positive left of a divided leaf's line, where the leaf is.
inline float side_of_line(const Leaf& leaf, float s, float t)
{
    return (leaf.to[0] - leaf.from[0]) * (t - leaf.from[1]) - (leaf.to[1] - leaf.from[1]) * (s - leaf.from[0]);
}

/// Moves (s, t) into the leaf.
inline void keep_in_leaf(const Leaf& leaf, float& s, float& t)
{
    s = std::clamp(s, leaf.s0, leaf.s0 + leaf.size);
    t = std::clamp(t, leaf.t0, leaf.t0 + leaf.size);
    if (!leaf.divided || side_of_line(leaf, s, t) >= 0.f) return;
    const float ds = leaf.to[0] - leaf.from[0], dt = leaf.to[1] - leaf.from[1];
    const float f = ((s - leaf.from[0]) * ds + (t - leaf.from[1]) * dt) / std::max(ds * ds + dt * dt, 1e-30f);
    s = leaf.from[0] + std::clamp(f, 0.f, 1.f) * ds;
    t = leaf.from[1] + std::clamp(f, 0.f, 1.f) * dt;
}

/// The other side of a divided leaf.
inline Leaf other_side(const Leaf& first)
{
    Leaf leaf = first;
    leaf.planes = first.planes + 3 * first.sheets;
    leaf.sheets = LayeredHead{first.record[-1]}.second_sheets();
    std::swap(leaf.from, leaf.to);
    return leaf;
}

/// Certified deviation of a bilinear sheet.
inline float sheet_deviation(const Leaf& leaf, int sheet)
{
    return leaf.kind == CellKind::Single ? leaf.deviation
                                         : deviation_of_code(bilinear_sheet(leaf.record, sheet)[4], leaf.range.w_step);
}

/// Certified least and greatest w of every surface over the leaf.
inline void leaf_band(const Leaf& leaf, float& lo, float& hi)
{
    if (leaf.kind == CellKind::Single) {
        lo = std::min(std::min(leaf.corner[0], leaf.corner[1]), std::min(leaf.corner[2], leaf.corner[3])) - leaf.deviation;
        hi = std::max(std::max(leaf.corner[0], leaf.corner[1]), std::max(leaf.corner[2], leaf.corner[3])) + leaf.deviation;
        return;
    }
    if (!leaf.bilinear) {
        lo = leaf.range.decode(leaf.record[0]);
        hi = leaf.range.decode(leaf.record[1]);
        return;
    }
    lo = INFINITY;
    hi = 0.f;
    for (int j = 0; j < leaf.sheets; ++j) {
        const float e = sheet_deviation(leaf, j);
        for (int c = 0; c < 4; ++c) {
            const float w = leaf.range.decode(bilinear_sheet(leaf.record, j)[c]);
            lo = std::min(lo, w - e);
            hi = std::max(hi, w + e);
        }
    }
}

/// A square of a face, s from s0 and t from t0.
struct Square {
    float s0, t0, size;
};

/// One part's map.
class CentralMap {
public:
    CentralMap(const ModelView& view, const Part& part)
        : part_(part),
          own_(arrays_of(view, part)),
          base_(static_cast<int>(part.base)),
          cell_size_(2.f / static_cast<float>(part.base))
    {
    }

    int base() const { return base_; }
    float cell_size() const { return cell_size_; }
    bool centre_inside() const { return (part_.flags & k_centre_inside) != 0; }

    Vec3f to_chart_frame(Vec3f p) const
    {
        const Vec3f d = p - vec3(part_.chart_centre);
        return {dot(vec3(part_.chart_rows), d), dot(vec3(part_.chart_rows + 3), d), dot(vec3(part_.chart_rows + 6), d)};
    }
    /// Model point of a point of the chart frame: centre + rotation' diag(a) x'.
    Vec3f from_chart_frame(Vec3f x) const
    {
        const Vec3f l{part_.a[0] * x.x, part_.a[1] * x.y, part_.a[2] * x.z};
        return vec3(part_.chart_centre) + l.x * vec3(part_.rotation) + l.y * vec3(part_.rotation + 3) +
               l.z * vec3(part_.rotation + 6);
    }
    /// A plane vector's gradient direction in the chart frame, measured in model space: diag(1/a^2) n.
    Vec3f over_axes_sq(Vec3f n) const
    {
        return {n.x / (part_.a[0] * part_.a[0]), n.y / (part_.a[1] * part_.a[1]), n.z / (part_.a[2] * part_.a[2])};
    }
    Vec3f direction_from_chart_frame(Vec3f n) const
    {
        const Vec3f l{n.x / part_.a[0], n.y / part_.a[1], n.z / part_.a[2]};
        return l.x * vec3(part_.rotation) + l.y * vec3(part_.rotation + 3) + l.z * vec3(part_.rotation + 6);
    }
    /// True where the chart answers: in a convex polytope that holds the part's solid and the centre.
    bool in_domain(Vec3f x) const
    {
        const auto v = domain_coordinates(x);
        bool inside = true;
        for (std::size_t i = 0; i < v.size(); ++i) inside = inside && v[i] >= part_.chart_lo[i] && v[i] <= part_.chart_hi[i];
        return inside;
    }

    int column_of(float s) const
    {
        return std::clamp(static_cast<int>((s + 1.f) * 0.5f * static_cast<float>(base_)), 0, base_ - 1);
    }
    CentralCell base_cell(int face, int column, int row) const { return {own_.cells[index_of(face, base_, column, row)]}; }
    Block block(int face, int column, int row) const
    {
        const int n = base_ / k_block;
        return own_.blocks[index_of(face, n, column, row)];
    }
    float decode(std::uint16_t v) const { return part_.w_min + part_.w_step * static_cast<float>(v); }

    /// The leaf that holds (s, t).
    Leaf leaf_at(int face, float s, float t) const
    {
        const int column = column_of(s), row = column_of(t);
        float s0 = -1.f + cell_size_ * static_cast<float>(column), t0 = -1.f + cell_size_ * static_cast<float>(row),
              size = cell_size_;
        CentralCell cell = base_cell(face, column, row);
        if (cell.kind() != CellKind::Split) return side_at(base_leaf(cell, face, column, row), s, t);
        std::uint16_t corner[4];
        base_samples(face, column, row, corner);
        while (cell.kind() == CellKind::Split) {
            const std::uint16_t* split = own_.splits.data() + k_split_size * cell.payload();
            size *= 0.5f;
            const int right = s >= s0 + size ? 1 : 0, up = t >= t0 + size ? 1 : 0;
            s0 += size * static_cast<float>(right);
            t0 += size * static_cast<float>(up);
            child_samples(split, right + 2 * up, corner);
            cell = {split[k_split_cells + static_cast<std::uint32_t>(right + 2 * up)]};
        }
        return side_at(child_leaf(cell, corner, s0, t0, size), s, t);
    }

    /// Calls visit(leaf) for every leaf of a base cell, for each side of a divided one, but passes over the squares of a split
    /// cell where is_wanted(square) is false.
    template <class Visit, class Wanted>
    void each_leaf(int face, int column, int row, Visit&& visit, Wanted&& is_wanted) const
    {
        const CentralCell cell = base_cell(face, column, row);
        if (cell.kind() != CellKind::Split)
            visit_sides(base_leaf(cell, face, column, row), visit);
        else {
            std::uint16_t corner[4];
            base_samples(face, column, row, corner);
            each_child(cell, corner, -1.f + cell_size_ * static_cast<float>(column), -1.f + cell_size_ * static_cast<float>(row),
                       cell_size_, visit, is_wanted);
        }
    }

    /// Layer 2: the base samples of a cell whatever it was refined to; false where a corner has no surface.
    bool base_corners(int face, int column, int row, float corner[4]) const
    {
        std::uint16_t v[4];
        base_samples(face, column, row, v);
        bool all = true;
        for (int i = 0; i < 4; ++i) {
            all = all && v[i] != k_no_surface;
            corner[i] = decode(v[i]);
        }
        return all;
    }

    /// Offset of eq. 12 at (s, t), model units, outwards.
    float offset_at(int face, float s, float t) const { return beside(own_.offsets.data(), face, s, t).w * part_.offset_step; }
    /// The change of w and its slopes by smoothing, at (s, t).
    SheetValue smoothing_at(int face, float s, float t) const
    {
        const SheetValue v = beside(own_.smoothing.data(), face, s, t);
        return {v.w * part_.smoothing_step, v.ws * part_.smoothing_step, v.wt * part_.smoothing_step};
    }

    /// A leaf that was found already, on the side of (s, t); the corners of a Single one are left out.
    Leaf leaf_of(std::uint16_t word, float s0, float t0, float size, float s, float t) const
    {
        return side_at(leaf_frame({word}, s0, t0, size), s, t);
    }

    /// The sheet of a layered cell whose surface over (s, t) comes nearest to the expected distance along the face's axis.
    struct NearestSheet {
        SheetValue value{0, 0, 0};  ///< w is 0 where there is none
        bool exits = false;         ///< a ray from the centre leaves the solid there
    };
    NearestSheet nearest_sheet(std::uint16_t word, float s0, float t0, float size, float s, float t, float expected) const
    {
        const std::uint16_t* record = own_.pool.data() + own_.specials[CentralCell{word}.payload()];
        const float u = (s - s0) / size, v = (t - t0) / size;
        const LayeredHead head{record[0]};
        int sheets = head.sheets();
        NearestSheet best;
        float least = INFINITY;
        const auto offer = [&](const SheetValue& value, int sheet) {
            const float miss = std::abs(1.f - value.w * expected);  // |1/w - expected| w: the same order where w is alike
            if (!(value.w > 1e-6f) || !(miss < least * value.w)) return;
            least = miss / value.w;
            best = {value, centre_inside() == ((sheet & 1) == 0)};
        };
        if (head.bilinear()) {
            for (int j = 0; j < sheets; ++j) {
                const std::uint16_t* r = bilinear_sheet(record + 1, j);
                const float c[4] = {decode(r[0]), decode(r[1]), decode(r[2]), decode(r[3])};
                offer(bilinear_value(c, u, v, size), j);
            }
            return best;
        }
        const std::uint16_t* plane = record + head.head_size();
        if (head.divided()) {
            const auto [from, to] = border_line(record[3]);
            if ((to.u - from.u) * (v - from.v) - (to.v - from.v) * (u - from.u) < 0.f) {
                plane += 3 * sheets;
                sheets = head.second_sheets();
            }
        }
        const float per_half = 2.f * part_.w_step / size;
        for (int j = 0; j < sheets; ++j, plane += 3) {
            const float ws = decode_slope(plane[1]) * per_half, wt = decode_slope(plane[2]) * per_half;
            offer({decode(plane[0]) + (u - 0.5f) * size * ws + (v - 0.5f) * size * wt, ws, wt}, j);
        }
        return best;
    }

    Leaf base_leaf(CentralCell cell, int face, int column, int row) const
    {
        Leaf leaf = leaf_frame(cell, -1.f + cell_size_ * static_cast<float>(column), -1.f + cell_size_ * static_cast<float>(row),
                               cell_size_);
        if (leaf.kind == CellKind::Single) base_corners(face, column, row, leaf.corner);
        return leaf;
    }

private:
    static std::size_t index_of(int face, int side, int column, int row)
    {
        return static_cast<std::size_t>((face * side + row) * side + column);
    }

    static Leaf side_at(const Leaf& leaf, float s, float t)
    {
        return leaf.divided && side_of_line(leaf, s, t) < 0.f ? other_side(leaf) : leaf;
    }

    template <class Visit>
    static void visit_sides(const Leaf& leaf, Visit&& visit)
    {
        visit(leaf);
        if (leaf.divided) visit(other_side(leaf));
    }

    /// Bilinear value of an array that lies beside the base samples.
    template <class T>
    SheetValue beside(const T* values, int face, float s, float t) const
    {
        const int column = column_of(s), row = column_of(t);
        const T* p = values + (face * (base_ + 1) + row) * (base_ + 1) + column;
        const float c[4] = {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[base_ + 1]),
                            static_cast<float>(p[base_ + 2])};
        return bilinear_value(c, (s + 1.f) / cell_size_ - static_cast<float>(column),
                              (t + 1.f) / cell_size_ - static_cast<float>(row), cell_size_);
    }

    Leaf leaf_frame(CentralCell cell, float s0, float t0, float size) const
    {
        Leaf leaf;
        leaf.kind = cell.kind();
        leaf.centre_inside = centre_inside();
        leaf.s0 = s0;
        leaf.t0 = t0;
        leaf.size = size;
        leaf.range = {part_.w_min, part_.w_step};
        if (leaf.kind == CellKind::Single) {
            leaf.sheets = 1;
            leaf.deviation = deviation_of_code(cell.deviation_code(), part_.w_step);
            leaf.foreign = cell.foreign();
        } else if (leaf.kind == CellKind::Layered) {
            const std::uint16_t* record = own_.pool.data() + own_.specials[cell.payload()];
            const LayeredHead head{record[0]};
            leaf.sheets = head.sheets();
            leaf.bilinear = head.bilinear();
            leaf.foreign = head.foreign();
            leaf.record = record + 1;
            if (!leaf.bilinear) read_sides(leaf, record);
        } else {
            leaf.centre_inside = cell.inside();
        }
        return leaf;
    }

    static void read_sides(Leaf& leaf, const std::uint16_t* record)
    {
        leaf.flips = (leaf.sheets & 1) != 0;
        const LayeredHead head{record[0]};
        leaf.divided = head.divided();
        leaf.planes = record + head.head_size();
        if (!leaf.divided) return;
        const auto [from, to] = border_line(record[3]);
        leaf.from[0] = leaf.s0 + leaf.size * from.u;
        leaf.from[1] = leaf.t0 + leaf.size * from.v;
        leaf.to[0] = leaf.s0 + leaf.size * to.u;
        leaf.to[1] = leaf.t0 + leaf.size * to.v;
    }

    void base_samples(int face, int column, int row, std::uint16_t v[4]) const
    {
        const std::uint16_t* p = own_.samples.data() + (face * (base_ + 1) + row) * (base_ + 1) + column;
        v[0] = p[0];
        v[1] = p[1];
        v[2] = p[base_ + 1];
        v[3] = p[base_ + 2];
    }

    /// Corners of a cell -> corners of a quadrant of it.
    static void child_samples(const std::uint16_t* split, int quadrant, std::uint16_t corner[4])
    {
        const std::uint16_t grid[9] = {corner[0], split[0],  corner[1], split[1], split[2],
                                       split[3],  corner[2], split[4],  corner[3]};
        const std::uint16_t* p = grid + (quadrant & 1) + 3 * (quadrant >> 1);
        corner[0] = p[0];
        corner[1] = p[1];
        corner[2] = p[3];
        corner[3] = p[4];
    }

    Leaf child_leaf(CentralCell cell, const std::uint16_t corner[4], float s0, float t0, float size) const
    {
        Leaf leaf = leaf_frame(cell, s0, t0, size);
        if (leaf.kind == CellKind::Single)
            for (int i = 0; i < 4; ++i) leaf.corner[i] = decode(corner[i]);
        return leaf;
    }

    template <class Visit, class Wanted>
    void each_child(CentralCell cell, const std::uint16_t corner[4], float s0, float t0, float size, Visit&& visit,
                    Wanted&& is_wanted) const
    {
        const std::uint16_t* split = own_.splits.data() + k_split_size * cell.payload();
        size *= 0.5f;
        for (int q = 0; q < 4; ++q) {
            const CentralCell child{split[k_split_cells + static_cast<std::uint32_t>(q)]};
            const float s = s0 + size * static_cast<float>(q & 1), t = t0 + size * static_cast<float>(q >> 1);
            if (!is_wanted(Square{s, t, size})) continue;
            std::uint16_t of_child[4] = {corner[0], corner[1], corner[2], corner[3]};
            child_samples(split, q, of_child);
            if (child.kind() == CellKind::Split)
                each_child(child, of_child, s, t, size, visit, is_wanted);
            else
                visit_sides(child_leaf(child, of_child, s, t, size), visit);
        }
    }

    const Part& part_;
    CentralArrays<ArrayView> own_;
    int base_;
    float cell_size_;
};

/// Verdict at a chart point: inside or not, proven or not, and how far (in w) from where it would change.
struct ChartVerdict {
    bool inside = false;
    bool certain = false;
    float margin = 0;
};

inline ChartVerdict classify(const Leaf& leaf, float s, float t, float w)
{
    ChartVerdict v;
    if (leaf.sheets == 0 && leaf.kind != CellKind::Layered) return {leaf.centre_inside, true, INFINITY};
    int nearer = 0;  // sheets between the centre and the point
    v.margin = INFINITY;
    v.certain = true;
    for (int j = 0; j < leaf.sheets; ++j) {
        const float sheet = sheet_value(leaf, j, s, t).w;
        if (sheet > w) ++nearer;
        v.margin = std::min(v.margin, std::abs(sheet - w));
        if ((leaf.kind == CellKind::Single || leaf.bilinear) && !(std::abs(sheet - w) > sheet_deviation(leaf, j)))
            v.certain = false;
    }
    if (leaf.kind == CellKind::Layered && !leaf.bilinear) {
        float lo, hi;
        leaf_band(leaf, lo, hi);
        if (w > hi)
            nearer = 0;
        else if (w < lo)
            nearer = leaf.flips ? 1 : 0;
        else
            v.certain = false;
    }
    v.inside = leaf.centre_inside != ((nearer & 1) != 0);
    return v;
}

}  // namespace sqmap::model
