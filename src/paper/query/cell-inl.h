// Cells of a map's grid, and sparse records sorted by a grid's rows and columns, at many positions at a time.
#if defined(SQMAP_PAPER_CELL_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_PAPER_CELL_INL_H
#undef SQMAP_PAPER_CELL_INL_H
#else
#define SQMAP_PAPER_CELL_INL_H
#endif

#include "query/superquadric/power-inl.h"

#include <array>
#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

struct AngleLanes {
    F eta, omega;
};

template <class T>
using Corners = std::array<T, 4>;  // (row, column), (row, next), (next, column), (next, next)

HWY_INLINE I flagged(M m) { return hn::IfThenElseZero(hn::RebindMask(di, m), set_int(1)); }

/// A cell of a grid, and where in it.
struct Cell {
    I row, column, next_column;
    F y, x;
    M last;  // the cell ends where the columns begin

    HWY_INLINE Cell(const AngleLanes& angles, std::size_t rows, std::size_t columns)
    {
        const auto count = [](std::size_t n) { return static_cast<float>(n); };
        const auto within = [](F v, float max) { return smaller(larger(v, hn::Zero(df)), set(max)); };
        const F at_y = within(mul_add(angles.eta, set(count(rows - 1) / k_pi), set(0.5f * count(rows - 1))), count(rows - 1)),
                at_x =
                    within(mul_add(angles.omega, set(count(columns) / (2 * k_pi)), set(0.5f * count(columns))), count(columns));
        row = hn::Min(truncate(at_y), set_int(static_cast<std::int32_t>(rows) - 2));
        const I end = set_int(static_cast<std::int32_t>(columns) - 1);
        column = hn::Min(truncate(at_x), end);
        last = equal(column, end);
        next_column = hn::IfThenElseZero(hn::RebindMask(di, hn::Not(last)), hn::Add(column, set_int(1)));
        y = hn::Sub(at_y, to_float(row));
        x = hn::Sub(at_x, to_float(column));
    }
    HWY_INLINE I nearest_row() const
    {
        return hn::Add(row, hn::IfThenElseZero(hn::RebindMask(di, hn::Ge(y, set(0.5f))), set_int(1)));
    }
    HWY_INLINE I corner_row(std::size_t i) const { return i < 2 ? row : hn::Add(row, set_int(1)); }
    HWY_INLINE I corner_column(std::size_t i) const { return i % 2 == 0 ? column : next_column; }
    HWY_INLINE I nearest_column() const { return blend(hn::Ge(x, set(0.5f)), next_column, column); }
    HWY_INLINE F bilinear(F v00, F v01, F v10, F v11) const
    {
        const F lower = mul_add(x, hn::Sub(v01, v00), v00), upper = mul_add(x, hn::Sub(v11, v10), v10);
        return mul_add(y, hn::Sub(upper, lower), lower);
    }
};

/// Records of six bytes, a lane at a time sorted by column, from the first of a column on.
struct Entries {
    const std::byte* base;
    I at, end, column;
    M left;

    HWY_INLINE Entries(const std::uint32_t* rows, const std::byte* records, I row, I wanted, M which)
        : base(records), column(wanted)
    {
        const I from = blend(which, row, hn::Zero(di));
        at = gather_word(rows, from);
        end = gather_word(rows, hn::Add(from, set_int(1)));
        left = hn::And(which, hn::RebindMask(df, hn::Lt(at, end)));
        // The first not before the column, by halves.
        I before = at, after = end;
        for (M open = left; any(open); open = hn::And(open, hn::RebindMask(df, hn::Lt(before, after)))) {
            const I middle = shift_right<1>(hn::Add(before, after));
            const M lower = hn::And(open, hn::RebindMask(df, hn::Lt(column_of(middle, open), column)));
            before = blend(lower, hn::Add(middle, set_int(1)), before);
            after = blend(hn::AndNot(lower, open), middle, after);
        }
        at = before;
        check();
    }
    /// Two bytes at a time from an even offset in the record on.
    HWY_INLINE I word(int offset) const { return gather(at, left, offset); }
    HWY_INLINE void next()
    {
        at = hn::Add(at, set_int(1));
        check();
    }

private:
    HWY_INLINE I gather(I index, M which, int offset) const
    {
        const I byte = hn::Mul(blend(which, index, hn::Zero(di)), set_int(6));
        return hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(base), hn::Add(byte, set_int(offset)));
    }
    HWY_INLINE I column_of(I index, M which) const { return low(gather(index, which, 0)); }
    HWY_INLINE void check()
    {
        left = hn::And(left, hn::RebindMask(df, hn::Lt(at, end)));
        if (any(left)) left = hn::And(left, equal(column_of(at, left), column));
    }
};

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
