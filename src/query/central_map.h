// Reading the central map: chart of directions, cells, certified bounds and tangent planes. Header-only, allocation-free.
//
// The chart is a cube about the part's centre, in the part's frame divided by the superquadric's axes. A point x' of
// that frame lies on face m (its largest coordinate) at s, t (the other two over it) and w = 1/|largest|. Every plane
// is w = alpha + beta s + gamma t there: triangles project to straight-edged triangles, flat surfaces are stored
// without error, and the tangent plane of a stored surface is read off without trigonometry.
#pragma once

#include "sqmap/model/model.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace sqmap::query {

struct ChartPoint {
    int face;
    float s, t, w;
};

/// Axis of a face, and the two others in cyclic order.
constexpr int face_axis(int face) { return face >> 1; }
constexpr float face_sign(int face) { return (face & 1) != 0 ? -1.f : 1.f; }

inline ChartPoint to_chart(Vec3f x)
{
    const float ax = std::abs(x.x), ay = std::abs(x.y), az = std::abs(x.z);
    const int m = ax >= ay && ax >= az ? 0 : (ay >= az ? 1 : 2);
    const float major = x[m];
    // The centre itself has no direction: any will do, with a w nearer than every surface.
    const float w = 1.f / std::max(std::abs(major), 1e-18f);
    return {2 * m + (major < 0.f ? 1 : 0), x[(m + 1) % 3] * w, x[(m + 2) % 3] * w, w};
}

/// Direction of (s, t) on a face, largest coordinate 1.
inline Vec3f face_direction(int face, float s, float t)
{
    const int m = face_axis(face);
    Vec3f q{};
    q[m] = face_sign(face);
    q[(m + 1) % 3] = s;
    q[(m + 2) % 3] = t;
    return q;
}

/// Certified deviation of a Single cell, in w: code -> value; bake rounds up to the next code.
inline float deviation_of_code(std::uint32_t code, float w_step)
{
    return std::ldexp((8.f + static_cast<float>(code & 7u)) * 0.03125f * w_step, static_cast<int>(code >> 3));
}

/// A leaf cell, or the side of a divided one, ready to be read.
struct Leaf {
    model::CellKind kind = model::CellKind::Uniform;
    bool centre_inside = false;
    bool bilinear = false;  ///< Layered: sheets have four corners each
    bool foreign = false;   ///< no surface over it is the part's own
    int sheets = 0;         ///< Uniform 0, Single 1
    float s0 = 0, t0 = 0, size = 0;
    float w_min = 0, w_step = 0;
    float corner[4] = {};                   ///< Single: w at (s0,t0) (s1,t0) (s0,t1) (s1,t1)
    float deviation = 0;                    ///< Single
    const std::uint16_t* record = nullptr;  ///< Layered, past the header word
    const std::uint16_t* planes = nullptr;  ///< mixed: three words a sheet
    bool flips = false;                     ///< mixed: the verdict beyond the band differs from the centre's
    bool divided = false;                   ///< mixed: the leaf lies left of the way from one border point to another
    float from[2] = {}, to[2] = {};         ///< s and t of these

    float decode(std::uint16_t v) const { return w_min + w_step * static_cast<float>(v); }
};

/// w and its derivatives on sheet j of a leaf.
struct SheetValue {
    float w, ws, wt;
};

inline SheetValue bilinear_value(const float c[4], float u, float v, float size)
{
    const float bottom = c[0] + u * (c[1] - c[0]), top = c[2] + u * (c[3] - c[2]);
    return {bottom + v * (top - bottom), ((1.f - v) * (c[1] - c[0]) + v * (c[3] - c[2])) / size, (top - bottom) / size};
}

inline SheetValue sheet_value(const Leaf& leaf, int sheet, float s, float t)
{
    const float u = (s - leaf.s0) / leaf.size, v = (t - leaf.t0) / leaf.size;
    if (leaf.kind == model::CellKind::Single) return bilinear_value(leaf.corner, u, v, leaf.size);
    if (leaf.bilinear) {
        const std::uint16_t* r = leaf.record + 5 * sheet;
        const float c[4] = {leaf.decode(r[0]), leaf.decode(r[1]), leaf.decode(r[2]), leaf.decode(r[3])};
        return bilinear_value(c, u, v, leaf.size);
    }
    const std::uint16_t* r = leaf.planes + 3 * sheet;
    const float half = 0.5f * leaf.size;
    const float ws = static_cast<float>(static_cast<std::int16_t>(r[1])) * leaf.w_step / half;
    const float wt = static_cast<float>(static_cast<std::int16_t>(r[2])) * leaf.w_step / half;
    return {leaf.decode(r[0]) + (s - leaf.s0 - half) * ws + (t - leaf.t0 - half) * wt, ws, wt};
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
    leaf.sheets = (first.record[-1] >> 5) & 7;
    std::swap(leaf.from, leaf.to);
    return leaf;
}

/// Certified deviation of a bilinear sheet.
inline float sheet_deviation(const Leaf& leaf, int sheet)
{
    return leaf.kind == model::CellKind::Single ? leaf.deviation : deviation_of_code(leaf.record[5 * sheet + 4], leaf.w_step);
}

/// Certified least and greatest w of every surface over the leaf.
inline void leaf_band(const Leaf& leaf, float& lo, float& hi)
{
    if (leaf.kind == model::CellKind::Single) {
        lo = std::min(std::min(leaf.corner[0], leaf.corner[1]), std::min(leaf.corner[2], leaf.corner[3])) - leaf.deviation;
        hi = std::max(std::max(leaf.corner[0], leaf.corner[1]), std::max(leaf.corner[2], leaf.corner[3])) + leaf.deviation;
        return;
    }
    if (!leaf.bilinear) {
        lo = leaf.decode(leaf.record[0]);
        hi = leaf.decode(leaf.record[1]);
        return;
    }
    lo = INFINITY;
    hi = 0.f;
    for (int j = 0; j < leaf.sheets; ++j) {
        const float e = sheet_deviation(leaf, j);
        for (int c = 0; c < 4; ++c) {
            const float w = leaf.decode(leaf.record[5 * j + c]);
            lo = std::min(lo, w - e);
            hi = std::max(hi, w + e);
        }
    }
}

/// One part's map.
class CentralMap {
public:
    CentralMap(const model::ModelView& view, const model::Part& part)
        : part_(part),
          samples_(view.samples.data() + part.first_sample),
          offsets_(view.offsets.data() + part.first_sample),
          smoothing_(view.smoothing.data() + part.first_sample),
          cells_(view.cells.data() + part.first_cell),
          blocks_(view.blocks.data() + part.first_block),
          splits_(view.splits.data() + model::k_split_size * static_cast<std::size_t>(part.first_split)),
          specials_(view.specials.data() + part.first_special),
          pool_(view.pool.data() + part.first_pool),
          base_(static_cast<int>(part.base)),
          cell_size_(2.f / static_cast<float>(part.base))
    {
    }

    int base() const { return base_; }
    float cell_size() const { return cell_size_; }
    bool centre_inside() const { return (part_.flags & model::k_centre_inside) != 0; }

    Vec3f to_chart_frame(Vec3f p) const
    {
        const Vec3f d = p - model::vec3(part_.chart_centre);
        return {dot(model::vec3(part_.chart_rows), d), dot(model::vec3(part_.chart_rows + 3), d),
                dot(model::vec3(part_.chart_rows + 6), d)};
    }
    /// Model point of a point of the chart frame: centre + rotation' diag(a) x'.
    Vec3f from_chart_frame(Vec3f x) const
    {
        const Vec3f l{part_.a[0] * x.x, part_.a[1] * x.y, part_.a[2] * x.z};
        return model::vec3(part_.chart_centre) + l.x * model::vec3(part_.rotation) + l.y * model::vec3(part_.rotation + 3) +
               l.z * model::vec3(part_.rotation + 6);
    }
    /// A plane vector's gradient direction in the chart frame, measured in model space: diag(1/a^2) n.
    Vec3f over_axes_sq(Vec3f n) const
    {
        return {n.x / (part_.a[0] * part_.a[0]), n.y / (part_.a[1] * part_.a[1]), n.z / (part_.a[2] * part_.a[2])};
    }
    Vec3f direction_from_chart_frame(Vec3f n) const
    {
        const Vec3f l{n.x / part_.a[0], n.y / part_.a[1], n.z / part_.a[2]};
        return l.x * model::vec3(part_.rotation) + l.y * model::vec3(part_.rotation + 3) + l.z * model::vec3(part_.rotation + 6);
    }
    /// Where the chart answers: a convex polytope that holds the part's solid and the centre.
    bool in_domain(Vec3f x) const
    {
        const float v[9] = {x.x, x.y, x.z, x.x + x.y, x.x - x.y, x.x + x.z, x.x - x.z, x.y + x.z, x.y - x.z};
        bool inside = true;
        for (int i = 0; i < 9; ++i) inside = inside && v[i] >= part_.chart_lo[i] && v[i] <= part_.chart_hi[i];
        return inside;
    }

    int column_of(float s) const
    {
        return std::clamp(static_cast<int>((s + 1.f) * 0.5f * static_cast<float>(base_)), 0, base_ - 1);
    }
    std::uint16_t base_cell(int face, int column, int row) const { return cells_[(face * base_ + row) * base_ + column]; }
    model::Block block(int face, int column, int row) const
    {
        const int n = base_ / model::k_block;
        return blocks_[(face * n + row) * n + column];
    }
    float decode(std::uint16_t v) const { return part_.w_min + part_.w_step * static_cast<float>(v); }

    /// The leaf that holds (s, t).
    Leaf leaf_at(int face, float s, float t) const
    {
        const int column = column_of(s), row = column_of(t);
        float s0 = -1.f + cell_size_ * static_cast<float>(column), t0 = -1.f + cell_size_ * static_cast<float>(row),
              size = cell_size_;
        std::uint16_t cell = base_cell(face, column, row);
        if (model::cell_kind(cell) != model::CellKind::Split) return side_at(base_leaf(cell, face, column, row), s, t);
        std::uint16_t corner[4];
        base_samples(face, column, row, corner);
        while (model::cell_kind(cell) == model::CellKind::Split) {
            const std::uint16_t* split = splits_ + model::k_split_size * model::cell_payload(cell);
            size *= 0.5f;
            const int right = s >= s0 + size ? 1 : 0, up = t >= t0 + size ? 1 : 0;
            s0 += size * static_cast<float>(right);
            t0 += size * static_cast<float>(up);
            child_samples(split, right + 2 * up, corner);
            cell = split[model::k_split_cells + static_cast<std::uint32_t>(right + 2 * up)];
        }
        return side_at(child_leaf(cell, corner, s0, t0, size), s, t);
    }

    /// Calls visit(leaf) for every leaf of a base cell, for each side of a divided one.
    template <class Visit>
    void each_leaf(int face, int column, int row, Visit&& visit) const
    {
        const std::uint16_t cell = base_cell(face, column, row);
        if (model::cell_kind(cell) != model::CellKind::Split)
            visit_sides(base_leaf(cell, face, column, row), visit);
        else {
            std::uint16_t corner[4];
            base_samples(face, column, row, corner);
            each_child(cell, corner, -1.f + cell_size_ * static_cast<float>(column), -1.f + cell_size_ * static_cast<float>(row),
                       cell_size_, visit);
        }
    }

    /// Layer 2: the base samples of a cell whatever it was refined to; false where a corner has no surface.
    bool base_corners(int face, int column, int row, float corner[4]) const
    {
        std::uint16_t v[4];
        base_samples(face, column, row, v);
        bool all = true;
        for (int i = 0; i < 4; ++i) {
            all = all && v[i] != model::k_no_surface;
            corner[i] = decode(v[i]);
        }
        return all;
    }

    /// Offset of eq. 12 at (s, t), model units, outwards.
    float offset_at(int face, float s, float t) const { return beside(offsets_, face, s, t).w * part_.offset_step; }
    /// What smoothing adds to w and its slopes at (s, t).
    SheetValue smoothing_at(int face, float s, float t) const
    {
        const SheetValue v = beside(smoothing_, face, s, t);
        return {v.w * part_.smoothing_step, v.ws * part_.smoothing_step, v.wt * part_.smoothing_step};
    }

    /// A leaf that was found already, on the side of (s, t); the corners of a Single one are left out.
    Leaf leaf_of(std::uint16_t cell, float s0, float t0, float size, float s, float t) const
    {
        return side_at(leaf_frame(cell, s0, t0, size), s, t);
    }

    /// Of the sheets of a layered cell over (s, t) the one whose surface comes nearest to expected along the face's axis.
    struct NearestSheet {
        SheetValue value{0, 0, 0};  ///< w is 0 where there is none
        bool exits = false;         ///< a ray from the centre leaves the solid there
    };
    NearestSheet nearest_sheet(std::uint16_t cell, float s0, float t0, float size, float s, float t, float expected) const
    {
        const std::uint16_t* record = pool_ + specials_[model::cell_payload(cell)];
        const float u = (s - s0) / size, v = (t - t0) / size;
        int sheets = record[0] & 7;
        NearestSheet best;
        float least = INFINITY;
        const auto offer = [&](const SheetValue& value, int sheet) {
            const float miss = std::abs(1.f - value.w * expected);  // |1/w - expected| w: the same order where w is alike
            if (!(value.w > 1e-6f) || !(miss < least * value.w)) return;
            least = miss / value.w;
            best = {value, centre_inside() == ((sheet & 1) == 0)};
        };
        if ((record[0] & 8) != 0) {
            for (int j = 0; j < sheets; ++j) {
                const std::uint16_t* r = record + 1 + 5 * j;
                const float c[4] = {decode(r[0]), decode(r[1]), decode(r[2]), decode(r[3])};
                offer(bilinear_value(c, u, v, size), j);
            }
            return best;
        }
        const std::uint16_t* plane = record + 3;
        if ((record[0] & model::k_divided) != 0) {
            const model::BorderPoint from = model::border_point(record[3] >> 8), to = model::border_point(record[3] & 0xffu);
            plane = record + 4;
            if ((to.u - from.u) * (v - from.v) - (to.v - from.v) * (u - from.u) < 0.f) {
                plane += 3 * sheets;
                sheets = (record[0] >> 5) & 7;
            }
        }
        const float per_half = 2.f * part_.w_step / size;
        for (int j = 0; j < sheets; ++j, plane += 3) {
            const float ws = static_cast<float>(static_cast<std::int16_t>(plane[1])) * per_half;
            const float wt = static_cast<float>(static_cast<std::int16_t>(plane[2])) * per_half;
            offer({decode(plane[0]) + (u - 0.5f) * size * ws + (v - 0.5f) * size * wt, ws, wt}, j);
        }
        return best;
    }

    Leaf base_leaf(std::uint16_t cell, int face, int column, int row) const
    {
        Leaf leaf = leaf_frame(cell, -1.f + cell_size_ * static_cast<float>(column), -1.f + cell_size_ * static_cast<float>(row),
                               cell_size_);
        if (leaf.kind == model::CellKind::Single) base_corners(face, column, row, leaf.corner);
        return leaf;
    }

private:
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

    Leaf leaf_frame(std::uint16_t cell, float s0, float t0, float size) const
    {
        Leaf leaf;
        leaf.kind = model::cell_kind(cell);
        leaf.centre_inside = centre_inside();
        leaf.s0 = s0;
        leaf.t0 = t0;
        leaf.size = size;
        leaf.w_min = part_.w_min;
        leaf.w_step = part_.w_step;
        if (leaf.kind == model::CellKind::Single) {
            leaf.sheets = 1;
            leaf.deviation = deviation_of_code(model::cell_payload(cell) & 0xffu, part_.w_step);
            leaf.foreign = (model::cell_payload(cell) & model::k_foreign) != 0;
        } else if (leaf.kind == model::CellKind::Layered) {
            const std::uint16_t* record = pool_ + specials_[model::cell_payload(cell)];
            leaf.sheets = record[0] & 7;
            leaf.bilinear = (record[0] & 8) != 0;
            leaf.foreign = (record[0] & model::k_foreign) != 0;
            leaf.record = record + 1;
            if (!leaf.bilinear) read_sides(leaf, record);
        } else {
            leaf.centre_inside = (model::cell_payload(cell) & 1u) != 0;
        }
        return leaf;
    }

    static void read_sides(Leaf& leaf, const std::uint16_t* record)
    {
        leaf.flips = (leaf.sheets & 1) != 0;
        leaf.divided = (record[0] & model::k_divided) != 0;
        leaf.planes = record + (leaf.divided ? 4 : 3);
        if (!leaf.divided) return;
        const model::BorderPoint from = model::border_point(record[3] >> 8), to = model::border_point(record[3] & 0xffu);
        leaf.from[0] = leaf.s0 + leaf.size * from.u;
        leaf.from[1] = leaf.t0 + leaf.size * from.v;
        leaf.to[0] = leaf.s0 + leaf.size * to.u;
        leaf.to[1] = leaf.t0 + leaf.size * to.v;
    }

    void base_samples(int face, int column, int row, std::uint16_t v[4]) const
    {
        const std::uint16_t* p = samples_ + (face * (base_ + 1) + row) * (base_ + 1) + column;
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

    Leaf child_leaf(std::uint16_t cell, const std::uint16_t corner[4], float s0, float t0, float size) const
    {
        Leaf leaf = leaf_frame(cell, s0, t0, size);
        if (leaf.kind == model::CellKind::Single)
            for (int i = 0; i < 4; ++i) leaf.corner[i] = decode(corner[i]);
        return leaf;
    }

    template <class Visit>
    void each_child(std::uint16_t cell, const std::uint16_t corner[4], float s0, float t0, float size, Visit&& visit) const
    {
        const std::uint16_t* split = splits_ + model::k_split_size * model::cell_payload(cell);
        size *= 0.5f;
        for (int q = 0; q < 4; ++q) {
            const std::uint16_t child = split[model::k_split_cells + static_cast<std::uint32_t>(q)];
            const float s = s0 + size * static_cast<float>(q & 1), t = t0 + size * static_cast<float>(q >> 1);
            std::uint16_t of_child[4] = {corner[0], corner[1], corner[2], corner[3]};
            child_samples(split, q, of_child);
            if (model::cell_kind(child) == model::CellKind::Split)
                each_child(child, of_child, s, t, size, visit);
            else
                visit_sides(child_leaf(child, of_child, s, t, size), visit);
        }
    }

    const model::Part& part_;
    const std::uint16_t* samples_;
    const std::uint8_t* offsets_;
    const std::int8_t* smoothing_;
    const std::uint16_t* cells_;
    const model::Block* blocks_;
    const std::uint16_t* splits_;
    const std::uint32_t* specials_;
    const std::uint16_t* pool_;
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
    if (leaf.sheets == 0 && leaf.kind != model::CellKind::Layered) return {leaf.centre_inside, true, INFINITY};
    int nearer = 0;  // sheets between the centre and the point
    v.margin = INFINITY;
    v.certain = true;
    for (int j = 0; j < leaf.sheets; ++j) {
        const float sheet = sheet_value(leaf, j, s, t).w;
        if (sheet > w) ++nearer;
        v.margin = std::min(v.margin, std::abs(sheet - w));
        if ((leaf.kind == model::CellKind::Single || leaf.bilinear) && !(std::abs(sheet - w) > sheet_deviation(leaf, j)))
            v.certain = false;
    }
    if (leaf.kind == model::CellKind::Layered && !leaf.bilinear) {
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

}  // namespace sqmap::query
