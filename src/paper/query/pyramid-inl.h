// The multiresolution search of section 4.2.2 (eqs. 15 to 19, Fig. 7), many points at a time, with corrections that can be left
// out: both search directions, distance compared beside collinearity, the whole surface where the window does not hold the foot.
#if defined(SQMAP_PAPER_PYRAMID_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_PAPER_PYRAMID_INL_H
#undef SQMAP_PAPER_PYRAMID_INL_H
#else
#define SQMAP_PAPER_PYRAMID_INL_H
#endif

#include "paper/query/foot_record.h"
#include "paper/query/grid-inl.h"
#include "sqmap/paper/projection.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

/// The sample that a search has come to.
struct Searched {
    NodeLanes node;
    F distance_sq;
    F collinearity;  // I_S of eq. 19; with distances compared signed, so that the far side of the surface does not count
    M wide;          // the whole surface was searched
    int evaluations;
};

/// record: told of every sample that is looked at.
template <class Record = NoRecord>
class PyramidSearch {
public:
    /// q: the superquadric's own frame.
    PyramidSearch(const GridLanes& grid, const V3& q, bool compare_distance, Record record = {})
        : grid_(grid), q_(q), by_distance_(compare_distance), score_(set(INFINITY)), record_(record)
    {
    }

    /// Around the sample on a position's ray. eps: exponents of the superquadric.
    HWY_NOINLINE Searched run(const PositionLanes& own, M active, const PyramidOptions& options)
    {
        const std::int32_t stride = std::int32_t{1} << (levels() - 1);
        const NodeLanes centre = grid_.nearest(own);
        const M at_border = options.both_directions ? window(centre, stride) : one_direction(centre, stride, own);
        descend(stride / 2);
        Searched found = state();
        if (options.wide_fallback) {
            const F along = found.collinearity, square = hn::Sub(set(1.f), hn::Mul(along, along));
            const F miss = hn::Sqrt(hn::Mul(found.distance_sq, larger(square, hn::Zero(df))));
            const M lost = hn::Or(hn::Or(at_border, hn::Lt(along, hn::Zero(df))), hn::Gt(miss, diagonal()));
            const M wide = hn::And(active, lost);
            if (any(wide)) {
                search_all(wide);
                found = state();
                found.wide = wide;
            }
        }
        found.evaluations = evaluations_;
        return found;
    }

    /// From a sample on, down to single samples.
    HWY_NOINLINE Searched refine(const NodeLanes& from, std::int32_t stride)
    {
        const M all = hn::Not(none());
        record_.level(grid_.stride() * std::max(stride, std::int32_t{1}));
        consider(Row(grid_, from.row), Column(grid_, from.column), all);
        descend(stride);
        return state();
    }

private:
    struct Row {
        I index;
        ArcLanes arc;
        HWY_INLINE Row(const GridLanes& grid, I i) : index(i), arc(grid.row(i)) {}
    };
    struct Column {
        I index;
        ArcLanes arc;
        HWY_INLINE Column(const GridLanes& grid, I i) : index(i), arc(grid.column(i)) {}
    };

    /// Eq. 18, integer part; at least one level.
    int levels() const
    {
        int count = 0;
        while ((16 << (count + 1)) <= grid_.rows() || (32 << (count + 1)) <= grid_.columns()) ++count;
        // The window goes around once at most.
        while ((1 << count) > grid_.columns()) --count;
        return std::max(count, 1);
    }

    /// The score of a candidate: smaller is better.
    HWY_INLINE F score_of(const Row& row, const Column& column) const
    {
        const PositionLanes at{row.arc, column.arc};
        if (by_distance_) {
            const V3 line = minus(grid_.shape().point(at), q_);
            return dot(line, line);
        }
        const SurfaceLanes s = grid_.shape().surface(at);
        const V3 line = minus(s.point, q_);
        return hn::Neg(hn::Abs(hn::Div(dot(s.normal, line), larger(length(line), set(1e-18f)))));  // errata 7
    }
    HWY_NOINLINE M consider(const Row& row, const Column& column, M which)
    {
        ++evaluations_;
        const F score = score_of(row, column);
        const M better = hn::And(which, hn::Lt(score, score_));
        score_ = blend(better, score, score_);
        node_ = blend(better, {row.index, column.index}, node_);
        record_.sample(grid_, NodeLanes{row.index, column.index}, better);
        return better;
    }

    /// Two top-level strides on either side; returns where the best is at the end.
    HWY_NOINLINE M window(const NodeLanes& centre, std::int32_t stride)
    {
        record_.level(grid_.stride() * stride);
        const auto at = [&](I middle, int k) { return hn::Add(middle, set_int(k * stride)); };
        const Column columns[5] = {{grid_, at(centre.column, -2)},
                                   {grid_, at(centre.column, -1)},
                                   {grid_, centre.column},
                                   {grid_, at(centre.column, 1)},
                                   {grid_, at(centre.column, 2)}};
        M border = none();
        for (int i = -2; i <= 2; ++i) {
            const Row row(grid_, at(centre.row, i));
            for (int j = -2; j <= 2; ++j) {
                const M better = consider(row, columns[j + 2], hn::Not(none()));
                border = std::max(std::abs(i), std::abs(j)) == 2 ? hn::Or(border, better) : hn::AndNot(better, border);
            }
        }
        node_ = grid_.wrapped(node_);
        return border;
    }

    /// The direction of eq. 16 for each coordinate.
    HWY_NOINLINE M one_direction(const NodeLanes& centre, std::int32_t stride, const PositionLanes& own)
    {
        record_.level(grid_.stride() * stride);
        const shape::Superquadricf& sq = grid_.shape().shape();
        const I down = hn::Mul(direction(own.latitude, sq.eps1), set_int(stride)),
                across = hn::Mul(direction(own.longitude, sq.eps2), set_int(stride));
        const Column columns[3] = {{grid_, centre.column},
                                   {grid_, hn::Add(centre.column, across)},
                                   {grid_, hn::Add(centre.column, hn::Add(across, across))}};
        M border = none();
        I row_index = centre.row;
        for (int i = 0; i <= 2; ++i, row_index = hn::Add(row_index, down)) {
            const Row row(grid_, row_index);
            for (int j = 0; j <= 2; ++j) {
                const M better = consider(row, columns[j], hn::Not(none()));
                border = std::max(i, j) == 2 ? hn::Or(border, better) : hn::AndNot(better, border);
            }
        }
        node_ = grid_.wrapped(node_);
        return border;
    }
    /// Eqs. 15 and 16, -1 or 1. Which half of its quadrant an angle is in shows in the arc; quadrants and halves are kept by
    /// eq. 9.
    static HWY_INLINE I direction(const ArcLanes& arc, float eps)
    {
        const F c = hn::Abs(arc.c), s = hn::Abs(arc.s), zero = hn::Zero(df);
        const M odd = hn::Lt(hn::Mul(arc.c, arc.s), zero);  // second or fourth quadrant
        const M set_a = hn::Or(hn::And(odd, hn::Lt(c, s)), hn::AndNot(odd, hn::Lt(s, c)));
        const M set_b = hn::Or(hn::And(odd, hn::Lt(s, c)), hn::AndNot(odd, hn::Lt(c, s)));
        const M back = eps < 1 ? set_a : (eps > 1 ? set_b : none());
        return blend(back, set_int(-1), set_int(1));
    }

    /// The eight neighbours of the best at half the stride, down to single samples (Fig. 7).
    HWY_NOINLINE void descend(std::int32_t stride)
    {
        for (; stride >= 1; stride /= 2) (void)step(stride, hn::Not(none()));
    }
    /// One level; returns which have moved.
    HWY_INLINE M step(std::int32_t stride, M which)
    {
        record_.level(grid_.stride() * stride);
        const NodeLanes centre = node_;
        const I by = set_int(stride);
        const Row rows[3] = {{grid_, hn::Sub(centre.row, by)}, {grid_, centre.row}, {grid_, hn::Add(centre.row, by)}};
        const Column columns[3] = {
            {grid_, hn::Sub(centre.column, by)}, {grid_, centre.column}, {grid_, hn::Add(centre.column, by)}};
        M moved = none();
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                if (i != 1 || j != 1) moved = hn::Or(moved, consider(rows[i], columns[j], which));
        node_ = grid_.wrapped(node_);
        return moved;
    }

    /// Coarsely everywhere, then downhill at every stride until no neighbour is nearer; each step gets nearer, so it ends.
    HWY_NOINLINE void search_all(M wide)
    {
        by_distance_ = true;
        const Searched here = state();
        score_ = blend(wide, here.distance_sq, score_);
        const std::int32_t coarse = std::clamp((grid_.rows() - 1) / 8, 1, grid_.columns() / 2);
        record_.level(grid_.stride() * coarse);
        for (std::int32_t i = 0; i < grid_.rows(); i += coarse) {
            const Row row(grid_, set_int(i));
            for (std::int32_t j = 0; j < grid_.columns(); j += coarse) (void)consider(row, {grid_, set_int(j)}, wide);
        }
        for (std::int32_t stride = coarse; stride >= 1; stride /= 2)
            for (M moving = wide; any(moving);) moving = step(stride, moving);
    }

    /// From the best to its neighbours across: a sample is accepted if its normal misses the point by less.
    HWY_NOINLINE F diagonal() const
    {
        const V3 here = grid_.shape().point(grid_.position(node_));
        const ArcLanes next = grid_.column(hn::Add(node_.column, set_int(1)));
        F max = hn::Zero(df);
        for (const std::int32_t side : {-1, 1}) {
            const V3 there = grid_.shape().point({grid_.row(hn::Add(node_.row, set_int(side))), next});
            max = larger(max, length(minus(there, here)));
        }
        return max;
    }

    HWY_NOINLINE Searched state() const
    {
        const SurfaceLanes s = grid_.shape().surface(grid_.position(node_));
        const V3 line = minus(s.point, q_);
        const F distance_sq = dot(line, line), away = hn::Sqrt(distance_sq);
        const F along = blend(hn::Gt(away, hn::Zero(df)), hn::Div(dot(s.normal, line), larger(away, set(1e-18f))), set(1.f));
        return {node_, distance_sq, by_distance_ ? along : hn::Abs(along), none(), evaluations_};
    }

    const GridLanes& grid_;
    const V3 q_;
    bool by_distance_;
    F score_;
    NodeLanes node_{hn::Zero(di), hn::Zero(di)};
    int evaluations_ = 0;
    [[no_unique_address]] Record record_;
};

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
