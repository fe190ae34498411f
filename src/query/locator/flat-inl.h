// Points in flat cells, many at a time: how far each is below the planes of its cell.
#if defined(SQMAP_QUERY_LOCATOR_FLAT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_LOCATOR_FLAT_INL_H
#undef SQMAP_QUERY_LOCATOR_FLAT_INL_H
#else
#define SQMAP_QUERY_LOCATOR_FLAT_INL_H
#endif

#include "locate-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Points with their cells, side by side.
struct LocatedPoints {
    static constexpr std::size_t k_size = 512, k_capacity = k_size + 2 * k_max_lanes;
    std::size_t count = 0;
    float p[3][k_capacity], offset[3][k_capacity];  // model space; from the cell's centre, in cells
    std::int32_t cell[k_capacity], point[k_capacity];

    HWY_INLINE void add(const V3& at, const V3& from_centre, I cell_word, I index, M which)
    {
        const F floats[6] = {at.x, at.y, at.z, from_centre.x, from_centre.y, from_centre.z};
        for (int k = 0; k < 3; ++k) {
            pack(floats[k], which, p[k] + count);
            pack(floats[k + 3], which, offset[k] + count);
        }
        pack(cell_word, which, cell + count);
        pack(index, which, point + count);
        count += count_of(which);
    }
    /// A vector of them from first on.
    HWY_INLINE M present(std::size_t first) const { return hn::FirstN(df, std::min(count - first, hn::Lanes(df))); }
    HWY_INLINE static V3 load(const float (*from)[k_capacity], std::size_t first)
    {
        return {hn::LoadU(df, from[0] + first), hn::LoadU(df, from[1] + first), hn::LoadU(df, from[2] + first)};
    }
    HWY_INLINE void set(std::size_t first, const V3& from_centre, I cell_word)
    {
        hn::StoreU(from_centre.x, df, offset[0] + first);
        hn::StoreU(from_centre.y, df, offset[1] + first);
        hn::StoreU(from_centre.z, df, offset[2] + first);
        hn::StoreU(cell_word, di, cell + first);
    }
};

/// How far points in flat cells are below the planes, plane by plane and not point by point: so no vector waits for the one
/// before it. (Points of one plane apart from the rest would fill more lanes, but moving them takes longer.)
class LowestPlanes {
public:
    explicit LowestPlanes(const LocatorLanes& locator) : locator_(locator) {}

    /// Calls answer(first, lanes, lowest planes) for each vector of points that has some in flat cells. The words of those that
    /// are not to be answered are 0.
    template <class Answer>
    HWY_INLINE void find(const LocatedPoints& points, Answer&& answer)
    {
        std::size_t open = 0, flat = 0;
        for (std::size_t first = 0; first < points.count; first += hn::Lanes(df)) {
            const I cell = hn::LoadU(di, points.cell + first);
            flat_[flat] = open_[open] = static_cast<std::uint16_t>(first);
            if (!any(LocatorLanes::has_more(cell, 0))) continue;
            ++flat;
            const FlatPlanes group = locator_.read_planes(first_plane(cell), LocatedPoints::load(points.offset, first));
            group_.set(first, group);
            lowest_.set(first, {group.plane, set(INFINITY)});
            open += any(LocatorLanes::has_more(cell, 1)) ? 1 : 0;
        }
        for (std::int32_t k = 1; open > 0; ++k) {
            std::size_t left = 0;
            for (std::size_t i = 0; i < open; ++i) {
                const std::size_t first = open_[i];
                const I cell = hn::LoadU(di, points.cell + first);
                const M more = LocatorLanes::has_more(cell, k);
                FlatPlanes group = group_.at(first), lowest = lowest_.at(first);
                const I plane = hn::Add(first_plane(cell), blend(more, set_int(k), hn::Zero(di)));
                LocatorLanes::add_planes(locator_.read_planes(plane, LocatedPoints::load(points.offset, first)), more, group,
                                         lowest);
                group_.set(first, group);
                lowest_.set(first, lowest);
                open_[left] = static_cast<std::uint16_t>(first);
                left += any(LocatorLanes::has_more(cell, k + 1)) ? 1 : 0;
            }
            open = left;
        }
        for (std::size_t i = 0; i < flat; ++i) {
            const std::size_t first = flat_[i];
            const M lanes = LocatorLanes::has_more(hn::LoadU(di, points.cell + first), 0);
            FlatPlanes lowest = lowest_.at(first);
            LocatorLanes::close_group(group_.at(first), lanes, lowest);
            answer(first, lanes, lowest);
        }
    }

private:
    static HWY_INLINE I first_plane(I cell)
    {
        return blend(LocatorLanes::has_more(cell, 0), LocatorLanes::first_of(cell), hn::Zero(di));
    }

    struct StoredPlanes {
        std::int32_t plane[LocatedPoints::k_capacity];
        float below[LocatedPoints::k_capacity];
        HWY_INLINE FlatPlanes at(std::size_t first) const { return {hn::LoadU(di, plane + first), hn::LoadU(df, below + first)}; }
        HWY_INLINE void set(std::size_t first, const FlatPlanes& planes)
        {
            hn::StoreU(planes.plane, di, plane + first);
            hn::StoreU(planes.below, df, below + first);
        }
    };

    const LocatorLanes& locator_;
    StoredPlanes group_, lowest_;
    std::uint16_t flat_[LocatedPoints::k_capacity], open_[LocatedPoints::k_capacity];
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
