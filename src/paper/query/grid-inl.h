// The samples of a map's grid, many at a time: rows continued over the poles, columns around.
#if defined(SQMAP_PAPER_GRID_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_PAPER_GRID_INL_H
#undef SQMAP_PAPER_GRID_INL_H
#else
#define SQMAP_PAPER_GRID_INL_H
#endif

#include "query/superquadric/surface-inl.h"
#include "sqmap/paper/model.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

// Beside the overload below, which would hide them.
using query::HWY_NAMESPACE::blend;
using sqmap::HWY_NAMESPACE::blend;

/// Arcs of a grid's rows and columns, worked out once for many points. Left as it is until then: a search that nobody needs costs
/// nothing.
class GridArcs {
public:
    static HWY_INLINE ArcLanes row(const SuperquadricLanes& sq, const MapView& map, I index)
    {
        const F eta = mul_add(to_float(index), set(k_pi / static_cast<float>(map.eta_count - 1)), set(-0.5f * k_pi));
        const SineCosine angle = sine_cosine(eta);
        return sq.latitude().through(larger(angle.cosine, hn::Zero(df)), angle.sine).arc;
    }
    static HWY_INLINE ArcLanes column(const SuperquadricLanes& sq, const MapView& map, I index)
    {
        const F omega = mul_add(to_float(index), set(2 * k_pi / static_cast<float>(map.omega_count)), set(-k_pi));
        const SineCosine angle = sine_cosine(omega);
        return sq.longitude().through(angle.cosine, angle.sine).arc;
    }

    /// @pre the map is consistent: it has no more rows and columns than these
    void make(const SuperquadricLanes& sq, const MapView& map)
    {
        const auto fill = [&](Column* to, std::uint32_t count, auto&& arc_of) {
            for (std::size_t i = 0; i < count; i += hn::Lanes(df)) {
                const ArcLanes arc = arc_of(hn::Iota(di, static_cast<std::int32_t>(i)));
                const F values[4] = {arc.c, arc.s, arc.nc, arc.ns};
                for (int k = 0; k < 4; ++k) hn::StoreU(values[k], df, to[k].data() + i);
            }
        };
        fill(rows_, map.eta_count, [&](I index) { return row(sq, map, hn::Min(index, last(map.eta_count))); });
        fill(columns_, map.omega_count, [&](I index) { return column(sq, map, hn::Min(index, last(map.omega_count))); });
        made_ = true;
    }
    bool made() const { return made_; }
    void forget() { made_ = false; }

    HWY_INLINE ArcLanes row(I index) const { return read(rows_, index); }
    HWY_INLINE ArcLanes column(I index) const { return read(columns_, index); }

private:
    using Column = std::array<float, k_max_map_columns + k_lanes>;
    static I last(std::uint32_t count) { return set_int(static_cast<std::int32_t>(count) - 1); }
    static HWY_INLINE ArcLanes read(const Column* from, I index)
    {
        const auto at = [&](int k) { return hn::GatherIndex(df, from[k].data(), index); };
        return {at(0), at(1), at(2), at(3)};
    }

    Column rows_[4], columns_[4];
    bool made_ = false;
};

/// A sample of a grid.
struct NodeLanes {
    I row, column;
};
HWY_INLINE NodeLanes blend(M m, const NodeLanes& yes, const NodeLanes& no)
{
    return {blend(m, yes.row, no.row), blend(m, yes.column, no.column)};
}

/// Every so many samples of a map's grid. The row over a pole is the meridian beyond the pole: the latitude's arc with the sign
/// of its cosine changed, so that rows and columns are looked up each by itself.
class GridLanes {
public:
    /// arcs: made, or null: worked out where they are needed, with the same bits.
    GridLanes(const SuperquadricLanes& sq, const MapView& map, std::int32_t stride, const GridArcs* arcs)
        : sq_(sq),
          map_(map),
          arcs_(arcs),
          stride_(stride),
          rows_(static_cast<std::int32_t>(map.eta_count - 1) / stride + 1),
          columns_(static_cast<std::int32_t>(map.omega_count) / stride)
    {
    }

    std::int32_t rows() const { return rows_; }
    std::int32_t columns() const { return columns_; }
    std::int32_t stride() const { return stride_; }
    const SuperquadricLanes& shape() const { return sq_; }

    /// Arcs of a row that may lie over a pole. The column is to be found by wrapped().
    HWY_NOINLINE ArcLanes row(I index) const
    {
        const I folded = fold(index);
        const M over = beyond(index);
        const I at = hn::Mul(folded, set_int(stride_));
        ArcLanes arc = arcs_ != nullptr ? arcs_->row(at) : GridArcs::row(sq_, map_, at);
        arc.c = blend(over, hn::Neg(arc.c), arc.c);
        arc.nc = blend(over, hn::Neg(arc.nc), arc.nc);
        return arc;
    }
    HWY_NOINLINE ArcLanes column(I index) const
    {
        const I at = hn::Mul(around(index), set_int(stride_));
        return arcs_ != nullptr ? arcs_->column(at) : GridArcs::column(sq_, map_, at);
    }
    HWY_INLINE NodeLanes wrapped(const NodeLanes& node) const
    {
        const I half = blend(beyond(node.row), set_int(columns_ / 2), hn::Zero(di));
        return {fold(node.row), around(hn::Add(around(node.column), half))};
    }
    HWY_INLINE PositionLanes position(const NodeLanes& node) const { return {row(node.row), column(node.column)}; }

    /// The sample nearest to a position, in angle.
    HWY_INLINE NodeLanes nearest(const PositionLanes& at) const
    {
        const F eta = angle_of(at.latitude.s, at.latitude.c), omega = angle_of(at.longitude.s, at.longitude.c);
        const F y = mul_add(eta, set(static_cast<float>(rows_ - 1) / k_pi), set(0.5f * static_cast<float>(rows_ - 1) + 0.5f));
        const F x =
            mul_add(omega, set(static_cast<float>(columns_) / (2 * k_pi)), set(0.5f * static_cast<float>(columns_) + 0.5f));
        return {hn::Min(hn::Max(truncate(y), hn::Zero(di)), set_int(rows_ - 1)), around(truncate(x))};
    }

private:
    HWY_INLINE M beyond(I row) const
    {
        return hn::RebindMask(df, hn::Or(hn::Lt(row, hn::Zero(di)), hn::Gt(row, set_int(rows_ - 1))));
    }
    HWY_INLINE I fold(I row) const
    {
        const I north = set_int(rows_ - 1), below = hn::Max(row, hn::Sub(hn::Zero(di), row));
        const I folded = blend(hn::RebindMask(df, hn::Gt(below, north)), hn::Sub(hn::Add(north, north), below), below);
        return hn::Min(hn::Max(folded, hn::Zero(di)), north);
    }
    /// Up to once around on either side.
    HWY_INLINE I around(I column) const
    {
        const I count = set_int(columns_);
        const I above = hn::Add(column, hn::IfThenElseZero(hn::Lt(column, hn::Zero(di)), count));
        return hn::Sub(above, hn::IfThenElseZero(hn::Gt(above, set_int(columns_ - 1)), count));
    }

    const SuperquadricLanes& sq_;
    const MapView& map_;
    const GridArcs* arcs_;
    std::int32_t stride_, rows_, columns_;
};

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
