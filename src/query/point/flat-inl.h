// Points in flat places, many at a time: how far each is below the planes of its place.
#if defined(SQMAP_QUERY_FLAT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_FLAT_INL_H
#undef SQMAP_QUERY_FLAT_INL_H
#else
#define SQMAP_QUERY_FLAT_INL_H
#endif

#include "locate-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Points with their places, side by side.
struct LocatedPoints {
    static constexpr std::size_t k_size = 512, k_capacity = k_size + 2 * Probe::k_cluster;
    std::size_t count = 0;
    float p[3][k_capacity], offset[3][k_capacity];  // model space; from the place's centre, in cells
    std::int32_t place[k_capacity], point[k_capacity];

    HWY_INLINE void add(const V3& at, const V3& from_centre, I place_word, I index, M which)
    {
        const F floats[6] = {at.x, at.y, at.z, from_centre.x, from_centre.y, from_centre.z};
        for (int k = 0; k < 3; ++k) {
            pack(floats[k], which, p[k] + count);
            pack(floats[k + 3], which, offset[k] + count);
        }
        pack(place_word, which, place + count);
        pack(index, which, point + count);
        count += hn::CountTrue(df, which);
    }
    /// A vector of them from first on.
    HWY_INLINE M present(std::size_t first) const { return hn::FirstN(df, std::min(count - first, hn::Lanes(df))); }
    HWY_INLINE static V3 load(const float (*from)[k_capacity], std::size_t first)
    {
        return {hn::LoadU(df, from[0] + first), hn::LoadU(df, from[1] + first), hn::LoadU(df, from[2] + first)};
    }
    HWY_INLINE void set(std::size_t first, const V3& from_centre, I place_word)
    {
        hn::StoreU(from_centre.x, df, offset[0] + first);
        hn::StoreU(from_centre.y, df, offset[1] + first);
        hn::StoreU(from_centre.z, df, offset[2] + first);
        hn::StoreU(place_word, di, place + first);
    }
};

/// How far points in flat places are below the planes, plane by plane and not point by point: so no vector waits for the one
/// before it. (Points of one plane apart from the rest would fill more lanes, but moving them takes longer.)
class LowestPlanes {
public:
    explicit LowestPlanes(const Places& places) : places_(places) {}

    /// Calls answer(first, lanes, lowest planes) for each vector of points that has some in flat places. The words of those that
    /// are not to be answered are 0.
    template <class Answer>
    HWY_INLINE void find(const LocatedPoints& points, Answer&& answer)
    {
        std::size_t open = 0, flat = 0;
        for (std::size_t first = 0; first < points.count; first += hn::Lanes(df)) {
            const I place = hn::LoadU(di, points.place + first);
            flat_[flat] = open_[open] = static_cast<std::uint16_t>(first);
            if (!any(Places::has_more(place, 0))) continue;
            ++flat;
            const FlatPlanes group = places_.read_planes(first_plane(place), LocatedPoints::load(points.offset, first));
            group_.set(first, group);
            lowest_.set(first, {group.plane, set(INFINITY)});
            open += any(Places::has_more(place, 1)) ? 1 : 0;
        }
        for (std::int32_t k = 1; open > 0; ++k) {
            std::size_t left = 0;
            for (std::size_t i = 0; i < open; ++i) {
                const std::size_t first = open_[i];
                const I place = hn::LoadU(di, points.place + first);
                const M more = Places::has_more(place, k);
                FlatPlanes group = group_.at(first), lowest = lowest_.at(first);
                const I plane = hn::Add(first_plane(place), blend(more, set_int(k), hn::Zero(di)));
                Places::add_planes(places_.read_planes(plane, LocatedPoints::load(points.offset, first)), more, group, lowest);
                group_.set(first, group);
                lowest_.set(first, lowest);
                open_[left] = static_cast<std::uint16_t>(first);
                left += any(Places::has_more(place, k + 1)) ? 1 : 0;
            }
            open = left;
        }
        for (std::size_t i = 0; i < flat; ++i) {
            const std::size_t first = flat_[i];
            const M lanes = Places::has_more(hn::LoadU(di, points.place + first), 0);
            FlatPlanes lowest = lowest_.at(first);
            Places::close_group(group_.at(first), lanes, lowest);
            answer(first, lanes, lowest);
        }
    }

private:
    static HWY_INLINE I first_plane(I place) { return blend(Places::has_more(place, 0), shift_right<14>(place), hn::Zero(di)); }

    struct StoredPlanes {
        std::int32_t plane[LocatedPoints::k_capacity];
        float gap[LocatedPoints::k_capacity];
        HWY_INLINE FlatPlanes at(std::size_t first) const { return {hn::LoadU(di, plane + first), hn::LoadU(df, gap + first)}; }
        HWY_INLINE void set(std::size_t first, const FlatPlanes& planes)
        {
            hn::StoreU(planes.plane, di, plane + first);
            hn::StoreU(planes.gap, df, gap + first);
        }
    };

    const Places& places_;
    StoredPlanes group_, lowest_;
    std::uint16_t flat_[LocatedPoints::k_capacity], open_[LocatedPoints::k_capacity];
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
