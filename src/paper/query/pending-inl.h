// Points and answers of one part that wait until they fill a vector, and what several points share.
#if defined(SQMAP_PAPER_PENDING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_PAPER_PENDING_INL_H
#undef SQMAP_PAPER_PENDING_INL_H
#else
#define SQMAP_PAPER_PENDING_INL_H
#endif

#include "paper/query/part-inl.h"

#include <algorithm>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

/// Calls visit(value) for each value of a position, of vectors.
template <class Visit, class Position>
HWY_INLINE void each_value_of(Visit&& visit, Position& at)
{
    for (auto* arc : {&at.latitude, &at.longitude})
        for (auto* value : {&arc->c, &arc->s, &arc->nc, &arc->ns}) visit(*value);
}
template <class Visit, class... Vector>
HWY_INLINE void each_value(Visit&& visit, Vector&... vectors)
{
    for (auto* v : {&vectors...})
        for (auto* value : {&v->x, &v->y, &v->z}) visit(*value);
}

/// A point that a part holds, all but the gauge, which layer 1 alone reads.
struct HeldValues {
    static constexpr std::size_t k_count = 14;
    using Of = HeldLanes;
    template <class Visit, class Point>
    static HWY_INLINE void each(Visit&& visit, Point& point)
    {
        each_value(visit, point.q, point.unit);
        each_value_of(visit, point.own);
    }
};

/// Newton's method on its way to the foot of a point.
struct ApproachLanes {
    V3 q;
    FootLanes foot;
    NewtonProgress done;
};
struct ApproachValues {
    static constexpr std::size_t k_count = 20;
    using Of = ApproachLanes;
    template <class Visit, class Approach>
    static HWY_INLINE void each(Visit&& visit, Approach& at)
    {
        each_value(visit, at.q, at.foot.at.point, at.foot.at.normal);
        each_value_of(visit, at.foot.position);
        for (auto* value : {&at.foot.miss, &at.done.steps, &at.done.halvings}) visit(*value);
    }
};

/// A contact's surface, from which closest-point steps go on; the surface point first.
struct AnswerValues {
    static constexpr std::size_t k_count = 24;
    using Of = PartAnswerLanes;
    template <class Visit, class Answer>
    static HWY_INLINE void each(Visit&& visit, Answer& a)
    {
        each_value(visit, a.surface, a.normal, a.shown.at.point, a.shown.at.normal);
        each_value_of(visit, a.shown.position);
        visit(a.shown_distance);
        visit(a.depth);
        visit(a.flags);
        visit(a.shown_flags);
    }
};

/// The values of a kind as an array.
template <class Kind>
struct Values {
    F value[Kind::k_count];

    Values() = default;
    HWY_INLINE explicit Values(const typename Kind::Of& of)
    {
        F* to = value;
        Kind::each([&](const auto& v) { *to++ = hn::BitCast(df, v); }, of);
    }
    [[nodiscard]] HWY_INLINE typename Kind::Of read() const
    {
        typename Kind::Of of{};
        const F* from = value;
        Kind::each([&](auto& v) { v = hn::BitCast(hn::DFromV<std::remove_reference_t<decltype(v)>>(), *from++); }, of);
        return of;
    }
};

/// Points of one part, values of a kind and a slot each, until they fill a vector: only whole vectors are worked on, however few
/// lanes of one come to this.
template <class Kind>
class PendingPoints {
public:
    std::size_t count = 0;

    HWY_INLINE void add(const typename Kind::Of& of, I slots, M which)
    {
        const Values<Kind> values(of);
        for (std::size_t i = 0; i < Kind::k_count; ++i) pack(values.value[i], which, field_[i] + count);
        pack(slots, which, slot_ + count);
        count += count_of(which);
    }
    [[nodiscard]] HWY_INLINE bool is_whole() const { return count >= hn::Lanes(df); }

    /// Takes the points out, vector after vector: work(of, slots, present lanes) may add them again. all: those that fill no
    /// vector too.
    template <class Work>
    HWY_INLINE void take(bool all, Work&& work)
    {
        const std::size_t lanes = hn::Lanes(df), had = count, whole = all ? had : had - had % lanes;
        if (all && had % lanes != 0) fill_up();
        count = 0;
        for (std::size_t first = 0; first < whole; first += lanes) {
            Values<Kind> values;
            for (std::size_t i = 0; i < Kind::k_count; ++i) values.value[i] = hn::LoadU(df, field_[i] + first);
            // work adds no more than it took, so that nothing behind this vector is overwritten.
            work(values.read(), hn::LoadU(di, slot_ + first), hn::FirstN(df, had - first));
        }
        const auto move = [&](auto* of) { std::copy(of + whole, of + had, of + count); };
        for (auto& field : field_) move(field);
        move(slot_);
        count += had - whole;
    }

private:
    /// Up to a whole vector: the first one again.
    void fill_up()
    {
        const auto fill = [&](auto* of) { std::fill(of + count, of + count + k_lanes, of[0]); };
        for (auto& field : field_) fill(field);
        fill(slot_);
    }

    static constexpr std::size_t k_capacity = 3 * k_lanes;
    float field_[Kind::k_count][k_capacity];
    std::int32_t slot_[k_capacity];
};

/// The surfaces that one part's table of seeds leads to. Contacts lie close together: the first in a cell of the table works its
/// surface out for all.
class SeedSurfaces {
public:
    /// The part changes.
    void forget()
    {
        if (!made_) std::fill_n(row_, k_cells, 0);
        made_ = true;
        for (std::size_t i = 0; i < count_; ++i) row_[cell_[i]] = 0;
        count_ = 0;
    }
    /// Which lanes have a known surface.
    [[nodiscard]] HWY_INLINE M known(I cells) const { return hn::RebindMask(df, hn::Gt(rows(cells), hn::Zero(di))); }
    [[nodiscard]] HWY_INLINE V3 surface(I cells) const
    {
        const I at = rows(cells);
        return {hn::GatherIndex(df, value_[0], at), hn::GatherIndex(df, value_[1], at), hn::GatherIndex(df, value_[2], at)};
    }
    [[nodiscard]] HWY_INLINE PartAnswerLanes answer(I cells) const
    {
        const I at = rows(cells);
        Values<AnswerValues> values;
        for (std::size_t i = 0; i < k_values; ++i) values.value[i] = hn::GatherIndex(df, value_[i], at);
        return values.read();
    }
    void add(const PartAnswerLanes& a, I cells, M which)
    {
        const Values<AnswerValues> values(a);
        HWY_ALIGN float value[k_values][k_lanes];
        HWY_ALIGN std::int32_t cell[k_lanes];
        for (std::size_t i = 0; i < k_values; ++i) hn::Store(values.value[i], df, value[i]);
        hn::Store(cells, di, cell);
        each_lane(which, [&](std::size_t lane) {
            std::int32_t& row = row_[cell[lane]];
            if (row != 0 || count_ == k_rows) return;
            cell_[count_++] = static_cast<std::uint16_t>(cell[lane]);
            row = static_cast<std::int32_t>(count_);
            for (std::size_t i = 0; i < k_values; ++i) value_[i][row] = value[i][lane];
        });
    }

private:
    static constexpr std::size_t k_values = AnswerValues::k_count;
    static constexpr std::size_t k_cells = k_surface_seeds * k_surface_seeds * k_surface_seeds, k_rows = 255;

    [[nodiscard]] HWY_INLINE I rows(I cells) const { return hn::GatherIndex(di, row_, cells); }

    bool made_ = false;
    std::size_t count_ = 0;
    std::int32_t row_[k_cells];  ///< 0: not known
    std::uint16_t cell_[k_rows];
    float value_[k_values][k_rows + 1];
};

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
