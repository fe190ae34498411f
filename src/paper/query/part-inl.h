// One part's map answers points, many at a time: the layers of section 4.2.
#if defined(SQMAP_PAPER_PART_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_PAPER_PART_INL_H
#undef SQMAP_PAPER_PART_INL_H
#else
#define SQMAP_PAPER_PART_INL_H
#endif

#include "paper/query/foot-inl.h"
#include "paper/query/map-inl.h"
#include "paper/query/pyramid-inl.h"
#include "query/layer.h"
#include "query/superquadric/held-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

/// See PartAnswer; model frame.
struct PartAnswerLanes {
    M contact;  // else free
    I flags;
    F foot_distance, map_distance, depth_along, depth;
    AngleLanes angles;
    V3 foot, foot_normal, surface, normal;
    FootLanes shown;   // of the surface, layers 2 and 3
    F shown_distance;  // what the map has there
    I shown_flags;
};
HWY_INLINE M is_witness(const PartAnswerLanes& a)
{
    return hn::AndNot(a.contact, equal(hn::And(a.flags, set_int(k_projection_unproven | k_projection_by_cap)), hn::Zero(di)));
}
HWY_INLINE M has_surface(const PartAnswerLanes& a)
{
    return equal(hn::And(a.flags, set_int(k_projection_cap | k_projection_miss)), hn::Zero(di));
}

class PartLanes {
public:
    /// arcs: workspace of the search, made where it is needed; null: the search works its arcs out one by one.
    PartLanes(const MapView& map, const ProjectionOptions& options, GridArcs* arcs)
        : view_(map),
          options_(options),
          sq_(map.superquadric),
          map_(view_),
          arcs_(arcs),
          coarse_(reads_base_grid(map, options)),
          proven_(set(k_proven_miss * sq_.size()))
    {
        if (arcs_ != nullptr) arcs_->forget();
    }

    const SuperquadricLanes& shape() const { return sq_; }

    /// Layer 1: where the point's own ray leaves the superquadric.
    HWY_INLINE PartAnswerLanes layer_one(const V3& p, const HeldLanes& point) const
    {
        const LeavingLanes found = leaving(sq_, p, point.own);
        PartAnswerLanes a;
        a.contact = hn::Not(none());
        a.flags = hn::Zero(di);
        a.angles = angles_at(point.own);
        a.foot = a.surface = found.point;
        a.foot_normal = a.normal = found.normal;
        a.foot_distance = a.depth_along = found.distance;
        a.map_distance = hn::Zero(df);
        a.depth = dot(minus(a.foot, p), a.normal);
        return a;
    }

    /// Layers 2 and 3 for the lanes of a mask.
    HWY_INLINE PartAnswerLanes answer(const V3& p, const HeldLanes& point, M active) const
    {
        M seeks;
        PartAnswerLanes a = along_foot<true>(p, point, active, seeks);
        seek_nearest(p, seeks, a);
        return a;
    }
    /// The same along the foot's line alone. seeks: the lanes from whose surface closest-point steps are to go on.
    /// normals_of_free: what is above the surface has its normal too.
    template <bool normals_of_free = false>
    HWY_INLINE PartAnswerLanes along_foot(const V3& p, const HeldLanes& point, M active, M& seeks) const
    {
        PartAnswerLanes a;
        a.flags = hn::Zero(di);
        FootLanes found = foot(point, active, a.flags);
        if (coarse_ && options_.projector == Projector::Newton) found = at_base_sample(found.position, point.q);
        a.angles = angles_at(found.position);
        a.foot_distance = length(minus(found.at.point, point.q));
        const F infinite = set(INFINITY);
        SampleLanes sample = sample_at(a.angles, normals_of_free ? infinite : a.foot_distance);
        a.shown = found;
        a.shown_distance = sample.distance;
        a.shown_flags = sample.flags;
        a.foot = sq_.to_model(found.at.point);
        a.foot_normal = sq_.direction_to_model(found.at.normal);
        if (options_.gaps && !coarse_) {
            const M deep = hn::And(active, hn::Gt(a.foot_distance, sample.distance));
            const M behind = any(deep) ? map_.behind_first(a.angles, a.foot_distance, deep, sample.distance) : none();
            const I opening = hn::Or(set_int(k_projection_behind), flag(hn::Eq(sample.distance, infinite), k_projection_miss));
            sample.flags = blend(behind, opening, sample.flags);
            const F zero = hn::Zero(df);
            sample.normal = blend(behind, {zero, zero, zero}, sample.normal);
        }
        a.flags = hn::Or(a.flags, sample.flags);
        a.map_distance = sample.distance;
        a.contact = hn::Ge(a.foot_distance, sample.distance);
        const M surface = has_surface(a), turned = hn::And(surface, hn::Gt(dot(sample.normal, sample.normal), set(0.5f)));
        a.surface = minus(a.foot, scaled(hn::IfThenElseZero(surface, sample.distance), a.foot_normal));
        a.normal = blend(turned, sample.normal, a.foot_normal);
        a.depth_along = hn::Sub(a.foot_distance, sample.distance);
        a.depth = blend(surface, dot(minus(a.surface, p), a.normal), a.depth_along);
        if (options_.projector == Projector::Printed) a.depth = a.depth_along;
        seeks = !coarse_ && options_.nearest_steps > 0 ? hn::And(hn::And(active, a.contact), turned) : none();
        return a;
    }

    /// Looks for a nearer surface about contacts on this part's map, from the sample whose surface is about the nearest on; its
    /// superquadric need not hold them. Returns the lanes that have one nearer than a distance, from which closest-point steps
    /// are to go on. Every surface point bounds the depth, so the nearest is right.
    HWY_NOINLINE M nearer_surface(const V3& p, F within, PartAnswerLanes& a) const
    {
        if (view_.surface_seeds.empty()) return none();
        const SeedTable table{view_.surface_seeds.data(), k_surface_seeds, false};
        a.shown = foot_at(sq_, table_start(sq_.to_unit(sq_.to_local(p)), table));
        const SampleLanes sample = sample_at(angles_at(a.shown.position));
        a.flags = a.shown_flags = sample.flags;
        a.contact = hn::Not(none());
        // Beside a jump what lies between samples may be no surface.
        const M mapped = hn::And(equal(sample.flags, hn::Zero(di)), hn::Gt(dot(sample.normal, sample.normal), set(0.5f)));
        a.shown_distance = sample.distance;
        a.surface = surface_below(a.shown, hn::IfThenElseZero(mapped, sample.distance));
        a.normal = sample.normal;
        const V3 line = minus(a.surface, p);
        a.depth = dot(line, a.normal);
        const M nearer = hn::And(hn::Lt(length(line), within), hn::Gt(a.depth, hn::Zero(df)));
        return hn::And(mapped, nearer);
    }

    /// Closest-point steps on the map: the surface looked up again at the projection of p on the tangent plane of the surface
    /// point found. A step is kept while it leads to a nearer surface point.
    HWY_NOINLINE void seek_nearest(const V3& p, M active, PartAnswerLanes& a) const
    {
        FootLanes foot = a.shown;
        F nearest = length(minus(a.surface, p));
        for (int step = 0; step < options_.nearest_steps && any(active); ++step) {
            const V3 target = plus(p, scaled(dot(minus(a.surface, p), a.normal), a.normal));
            const V3 q = sq_.to_local(target);
            foot = polished_foot(sq_, q, foot, active, {});
            const SampleLanes sample = sample_at(angles_at(foot.position));
            active = hn::And(hn::And(active, hn::Le(foot.miss, proven_)),
                             hn::And(equal(hn::And(sample.flags, set_int(k_open)), hn::Zero(di)),
                                     hn::Gt(dot(sample.normal, sample.normal), set(0.5f))));
            const V3 surface = surface_below(foot, hn::IfThenElseZero(active, sample.distance));
            const V3 line = minus(surface, p);
            const F distance = length(line);
            active = hn::And(active, hn::Lt(distance, nearest));
            nearest = blend(active, distance, nearest);
            a.shown.position = blend(active, foot.position, a.shown.position);
            a.shown.at = {blend(active, foot.at.point, a.shown.at.point), blend(active, foot.at.normal, a.shown.at.normal)};
            a.shown_distance = blend(active, sample.distance, a.shown_distance);
            a.shown_flags = blend(active, sample.flags, a.shown_flags);
            a.surface = blend(active, surface, a.surface);
            a.normal = blend(active, sample.normal, a.normal);
            a.depth = blend(active, dot(line, sample.normal), a.depth);
        }
    }

    /// Depth and normal of the smoothed map at the foot of the surface found. With the printed projector the depth is eq. 21's,
    /// |S - D(P_M)| with the smoothed D, on layer 2 of the nearest base sample; else that to the surface about the foot.
    HWY_NOINLINE void smooth(const V3& p, PartAnswerLanes& a) const
    {
        const AngleLanes angles = angles_at(a.shown.position);
        const M answered = equal(hn::And(a.flags, set_int(k_projection_unproven | k_open)), hn::Zero(di));
        const M known = hn::And(answered, equal(hn::And(a.shown_flags, set_int(k_open)), hn::Zero(di)));
        if (!any(known)) return;
        if (options_.projector != Projector::Printed) {
            smooth_about(p, angles, hn::IfThenElseZero(known, a.shown_distance), known, a);
            return;
        }
        const SampleLanes found = sample_at(angles);
        const SampleLanes sample = coarse_ ? map_.smoothed_base(angles, found) : map_.smoothed(angles, found);
        const M good = hn::And(known, hn::Gt(dot(sample.normal, sample.normal), set(0.5f)));
        a.surface = blend(good, surface_below(a.shown, hn::IfThenElseZero(good, sample.distance)), a.surface);
        a.normal = blend(good, sample.normal, a.normal);
        a.depth = blend(good, hn::Sub(a.foot_distance, sample.distance), a.depth);
    }

    HWY_NOINLINE SampleLanes sample_at(const AngleLanes& angles) const { return sample_at(angles, set(INFINITY)); }
    /// With a normal where the surface is no farther from the foot than a distance.
    HWY_NOINLINE SampleLanes sample_at(const AngleLanes& angles, F normals) const
    {
        const MapLanes::Wanted wanted{options_.offset ? set(INFINITY) : normals, options_.corrections};
        const SampleLanes sample = coarse_ ? map_.nearest_base(angles, wanted) : map_.interpolated(angles, wanted);
        return options_.offset ? moved_out(angles, sample) : sample;
    }
    /// Subtracts eq. 12.
    HWY_INLINE SampleLanes moved_out(const AngleLanes& angles, SampleLanes sample) const
    {
        const M surface = hn::Lt(sample.distance, set(INFINITY));  // a cap is at zero already
        const F moved = larger(hn::Sub(hn::IfThenElseZero(surface, sample.distance), map_.offset(angles)), hn::Zero(df));
        sample.distance = blend(surface, moved, sample.distance);
        return sample;
    }
    const MapLanes& map() const { return map_; }

    /// By the options' projector.
    template <class Record = NoRecord>
    HWY_INLINE FootLanes foot(const HeldLanes& point, M active, I& flags, Record record = {}) const
    {
        return options_.projector == Projector::Newton ? newton_foot(point, active, flags, record)
                                                       : searched_foot(point, active, flags, record);
    }

    /// The pyramid search on the base grid, around the sample on the point's own ray or the table's start.
    template <class Record = NoRecord>
    HWY_NOINLINE Searched searched(const HeldLanes& point, M active, const PyramidOptions& options, Record record = {}) const
    {
        const GridLanes grid(sq_, view_, std::int32_t{1} << view_.subdivisions, arcs());
        PyramidSearch<Record> search(grid, point.q, options.compare_distance, record);
        return search.run(options.seeded ? nearer_start(point).position : point.own, active, options);
    }

    static HWY_INLINE AngleLanes angles_at(const PositionLanes& at)
    {
        return {angle_of(at.latitude.s, at.latitude.c), angle_of(at.longitude.s, at.longitude.c)};
    }
    /// For points that may lie outside: the foot nearest to where the own ray leaves.
    HWY_INLINE FootLanes foot_from(const PositionLanes& start, const V3& q, M active) const
    {
        return polished_foot(sq_, q, foot_at(sq_, start), active, {});
    }
    F proven() const { return proven_; }

private:
    static constexpr std::int32_t k_open = k_projection_miss | k_projection_cap;

    /// Depth and normal of the smoothed surface about a surface point that the map shows: of the four base samples the mean of
    /// their tangent planes and of the plane through their mean, by bilinear shares.
    HWY_INLINE void smooth_about(const V3& p, const AngleLanes& angles, F distance, M known, PartAnswerLanes& a) const
    {
        const GridLanes base(sq_, view_, std::int32_t{1} << view_.subdivisions, arcs());
        const std::array<MapLanes::CornerLanes, 4> corners = map_.base_corners(angles);
        const F zero = hn::Zero(df), one = set(1.f);
        V3 normal{zero, zero, zero}, middle = normal;
        F weights = zero, planes = zero;
        for (const MapLanes::CornerLanes& c : corners) {
            // As the map's own normals: corners whose distance is another one are on another sheet.
            const M hit = hn::And(c.hit, hn::Le(hn::Abs(hn::Sub(c.stored, distance)), set(map_.steepest())));
            const FootLanes foot = foot_at(sq_, base.position({c.row, c.column}));
            F moved = hn::IfThenElseZero(hit, c.smoothed);
            if (options_.offset) moved = hn::Sub(moved, map_.offset(angles));
            // A share for corners that others leave alone.
            const F weight = hn::IfThenElseZero(hit, larger(c.share, set(1e-4f)));
            const V3 line = minus(surface_below(foot, moved), p);
            weights = hn::Add(weights, weight);
            planes = mul_add(weight, dot(line, c.normal), planes);
            normal = plus(normal, scaled(weight, c.normal));
            middle = plus(middle, scaled(weight, line));
        }
        const M good = hn::And(known, hn::Gt(dot(normal, normal), hn::Mul(set(1e-6f), hn::Mul(weights, weights))));
        if (!any(good)) return;
        const F inverse = hn::Div(one, blend(good, weights, one)), size = length(blend(good, normal, {one, zero, zero}));
        const V3 unit = scaled(hn::Div(one, size), normal);
        const F depth = hn::Mul(hn::Mul(set(0.5f), inverse), hn::Add(planes, dot(middle, unit)));
        a.normal = blend(good, unit, a.normal);
        a.depth = blend(good, depth, a.depth);
    }

    /// Eq. 22, model frame.
    HWY_INLINE V3 surface_below(const FootLanes& foot, F distance) const
    {
        return minus(sq_.to_model(foot.at.point), scaled(distance, sq_.direction_to_model(foot.at.normal)));
    }

    /// Starts over the undeformed bounding box, or over its octant.
    struct SeedTable {
        const FootSeed* seeds;
        std::uint32_t along;
        bool mirrored;
    };
    static constexpr PyramidOptions k_printed{
        .both_directions = false, .compare_distance = false, .wide_fallback = false, .seeded = false};

    const GridArcs* arcs() const
    {
        if (arcs_ != nullptr && !arcs_->made()) arcs_->make(sq_, view_);
        return arcs_;
    }

    /// A table's start for undeformed points, taken from the grid.
    HWY_INLINE PositionLanes table_start(const V3& unit, const SeedTable& table) const
    {
        const auto n = static_cast<float>(table.along);
        I index = hn::Zero(di);
        for (const F& coordinate : {unit.x, unit.y, unit.z}) {
            const F share = table.mirrored ? hn::Abs(coordinate) : hn::Mul(set(0.5f), hn::Add(coordinate, set(1.f)));
            const F x = smaller(larger(hn::Mul(share, set(n)), hn::Zero(df)), set(n - 1));
            index = hn::Add(hn::Mul(index, set_int(static_cast<std::int32_t>(table.along))), truncate(x));
        }
        const I seed = MapLanes::half_word(reinterpret_cast<const std::uint16_t*>(table.seeds), index);
        const F eta = mul_add(to_float(hn::And(seed, set_int(255))), set(k_pi / 255), set(-0.5f * k_pi)),
                omega = mul_add(to_float(shift_right<8>(seed)), set(2 * k_pi / 256), set(-k_pi));
        const SineCosine up = sine_cosine(eta), round = sine_cosine(omega);
        PositionLanes at{sq_.latitude().through(larger(up.cosine, hn::Zero(df)), up.sine).arc,
                         sq_.longitude().through(round.cosine, round.sine).arc};
        if (table.mirrored) {
            const auto flip = [](F like, F& c, F& nc) {
                c = hn::CopySign(c, like);
                nc = hn::CopySign(nc, like);
            };
            flip(unit.x, at.longitude.c, at.longitude.nc);
            flip(unit.y, at.longitude.s, at.longitude.ns);
            flip(unit.z, at.latitude.s, at.latitude.ns);
        }
        return at;
    }

    /// The nearer of the position on the point's own ray and the table's start: near the surface the first is right, deep inside
    /// and beside a sharp edge the second.
    HWY_NOINLINE FootLanes nearer_start(const HeldLanes& point) const
    {
        FootLanes own = foot_at(sq_, point.own);
        const FootLanes seed =
            foot_at(sq_, table_start(point.unit, {view_.seeds.data(), view_.seed_count, view_.seeds_mirrored != 0}));
        const V3 to_own = minus(own.at.point, point.q), to_seed = minus(seed.at.point, point.q);
        const M nearer = hn::Lt(dot(to_seed, to_seed), dot(to_own, to_own));
        return {blend(nearer, seed.position, own.position),
                {blend(nearer, seed.at.point, own.at.point), blend(nearer, seed.at.normal, own.at.normal)},
                own.miss};
    }

    /// The foot from the table's start; where no basin holds that, from the search.
    template <class Record>
    HWY_INLINE FootLanes newton_foot(const HeldLanes& point, M active, I& flags, Record record) const
    {
        FootLanes foot = polished_foot(sq_, point.q, nearer_start(point), active, {}, record);
        const M failed = hn::AndNot(hn::Le(foot.miss, proven_), active);
        if (any(failed)) start_again(point, failed, foot, flags, record);
        return foot;
    }

    /// Layer 2 compares a sample's distances, that of the point and that of the map: those of the nearest sample.
    HWY_NOINLINE FootLanes at_base_sample(const PositionLanes& foot, const V3& q) const
    {
        const GridLanes base(sq_, view_, std::int32_t{1} << view_.subdivisions, arcs());
        PyramidSearch<> search(base, q, true);
        return foot_at(sq_, base.position(search.refine(base.nearest(foot), 1).node));
    }

    template <class Record>
    HWY_NOINLINE void start_again(const HeldLanes& point, M failed, FootLanes& foot, I& flags, Record record) const
    {
        flags = hn::Or(flags, flag(failed, k_projection_wide));
        const GridLanes grid(sq_, view_, std::int32_t{1} << view_.subdivisions, arcs());
        const Searched found = searched(point, failed, {}, record);
        const FootLanes again = polished_foot(sq_, point.q, foot_at(sq_, grid.position(found.node)), failed, {}, record);
        const M better = hn::And(failed, hn::Lt(again.miss, foot.miss));
        foot = {blend(better, again.position, foot.position),
                {blend(better, again.at.point, foot.at.point), blend(better, again.at.normal, foot.at.normal)},
                blend(better, again.miss, foot.miss)};
        record.position(foot.position);
        flags = hn::Or(flags, flag(hn::AndNot(hn::Le(foot.miss, proven_), failed), k_projection_unproven));
    }

    /// The sample that the search comes to; layer 3 goes on through the subdivided levels, and one Newton step leads from the
    /// finest sample to the position between samples that linear interpolation of steps 2 and 3 is for: at the samples
    /// themselves the vertices of step 3 have no weight.
    template <class Record>
    HWY_NOINLINE FootLanes searched_foot(const HeldLanes& point, M active, I& flags, Record record) const
    {
        const bool printed = options_.projector == Projector::Printed;
        const Searched found = searched(point, active, printed ? k_printed : PyramidOptions{}, record);
        flags = hn::Or(flags, flag(found.wide, k_projection_wide));
        const std::int32_t stride = std::int32_t{1} << view_.subdivisions;
        if (coarse_) return foot_at(sq_, GridLanes(sq_, view_, stride, arcs()).position(found.node));
        const GridLanes finest(sq_, view_, 1, arcs());
        PyramidSearch<Record> search(finest, point.q, !printed, record);
        const I scale = set_int(stride);
        const Searched fine = search.refine({hn::Mul(found.node.row, scale), hn::Mul(found.node.column, scale)}, stride / 2);
        const FootLanes at_sample = foot_at(sq_, finest.position(fine.node));
        return polished_foot(sq_, point.q, at_sample, active, {1, 0}, record);
    }

    const MapView view_;
    const ProjectionOptions options_;
    const SuperquadricLanes sq_;
    const MapLanes map_;
    GridArcs* arcs_;
    bool coarse_;
    F proven_;
};

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
