// A walk over a probe's points: what is far is dropped, cluster after cluster, by the gaps of the locator's free cells.
#if defined(SQMAP_QUERY_PROBE_PROBE_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_PROBE_PROBE_WALK_INL_H
#undef SQMAP_QUERY_PROBE_PROBE_WALK_INL_H
#else
#define SQMAP_QUERY_PROBE_PROBE_WALK_INL_H
#endif

#include "kept_probe.h"
#include "probe_job.h"
#include "query/locator/locate-inl.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

static_assert(Probe::k_cluster % k_lanes == 0);

class ProbeWalk : protected LocatorLanes {
public:
    static constexpr std::size_t k_groups_at_once = 16;

    explicit ProbeWalk(const ProbeJob& job) : LocatorLanes(job.model), job_(job) {}

    /// Calls take(slot) for a vector of points from each slot on that may touch the solid; after_cluster() when a cluster of them
    /// is done and after_group() for a group, which ends the walk by false. Points without clusters: all of them. k_keeps: where
    /// a workspace keeps the probe, clusters are passed over that cannot have reached the solid.
    template <bool k_keeps = false, class Take, class AfterCluster, class AfterGroup>
    HWY_INLINE void each_near(Take&& take, AfterCluster&& after_cluster, AfterGroup&& after_group) const
    {
        if (job_.clusters == 0) {
            for (std::size_t slot = 0; slot < job_.points; slot += hn::Lanes(df)) {
                take(slot);
                after_cluster();
            }
            return;
        }
        if (job_.points == 0 || is_far(job_.sphere[0], job_.sphere[1], job_.sphere[2], job_.sphere[3])) return;
        for (std::size_t first = 0; first < job_.groups; first += k_groups_at_once) {
            // The cells under all clusters' centres are fetched before the first of them is read.
            std::uint32_t near_groups = 0;
            const std::size_t end = std::min(job_.groups, first + k_groups_at_once);
            for (std::size_t g = first; g < end; ++g) {
                const bool kept = k_keeps && job_.kept != nullptr;
                if (kept ? !is_due(g)
                         : job_.groups > 1 && is_far(job_.group_x[g], job_.group_y[g], job_.group_z[g], job_.group_radius[g]))
                    continue;
                near_groups |= 1u << (g - first);
                if (k_fetches && !kept) each_vector(g, [&](std::size_t c, std::size_t) { fetch_clusters(c); });
            }
            for (std::size_t g = first; g < end; ++g) {
                if ((near_groups >> (g - first) & 1u) == 0) continue;
                each_vector(g, [&](std::size_t c, std::size_t count) {
                    const M near = near_clusters<k_keeps>(c, due_clusters<k_keeps>(c, count));
                    each_lane(near, [&](std::size_t i) {
                        if constexpr (k_keeps)
                            if (job_.kept != nullptr) job_.kept->visited[job_.kept->visits++] = static_cast<std::uint32_t>(c + i);
                        for (std::size_t k = 0; k < Probe::k_cluster; k += hn::Lanes(df)) take((c + i) * Probe::k_cluster + k);
                        after_cluster();
                    });
                });
                if (!after_group()) return;
            }
        }
    }

    /// The clusters of a group by whole vectors: their first, and how many there are.
    template <class Do>
    HWY_INLINE void each_vector(std::size_t group, Do&& action) const
    {
        const std::size_t last = std::min(job_.clusters, (group + 1) * Probe::k_cluster);
        for (std::size_t c = group * Probe::k_cluster; c < last; c += hn::Lanes(df)) action(c, std::min(last - c, hn::Lanes(df)));
    }

    /// True where no point of a sphere (of the probe) is in the solid, by the locator's gap about its centre.
    HWY_NOINLINE bool is_far(float x, float y, float z, float radius) const
    {
        const Vec3f c = job_.in_model_space({x, y, z});
        const float reach = radius * job_.scale;
        float outside_sq = 0.f;
        int at[3];
        Vec3f g;
        for (int k = 0; k < 3; ++k) {
            const float in_cells = (c[k] - locator_.origin[k]) * inverse_cell_;
            g[k] = std::clamp(in_cells, 0.f, extent_[k]);
            const float gap = (in_cells - g[k]) * locator_.cell;
            outside_sq += gap * gap;
            at[k] = std::min(static_cast<int>(g[k]), static_cast<int>(extent_[k]) - 1);
        }
        // Also where the sum overflows.
        if (!(outside_sq <= reach * reach * 1.0001f)) return true;
        const auto* n = locator_.bricks;
        const std::uint32_t brick = model_.bricks[(static_cast<std::size_t>(at[2] / model::k_brick) * n[1] +
                                                   static_cast<std::size_t>(at[1] / model::k_brick)) *
                                                      n[0] +
                                                  static_cast<std::size_t>(at[0] / model::k_brick)];
        if ((brick & LocatorBrick::k_free) == 0) return false;
        const float half = 0.5f * model::k_brick;
        const auto middle = [&](int k) { return static_cast<float>(at[k] / model::k_brick * model::k_brick) + half; };
        const Vec3f d{g.x - middle(0), g.y - middle(1), g.z - middle(2)};
        const float away = (static_cast<float>(brick & ~LocatorBrick::k_free) * model::k_gap_step - norm(d)) * locator_.cell;
        return away > 0.f && away * away + outside_sq > reach * reach * 1.0001f;
    }

    /// Clusters from one on, where their centres are in the grid or nearest to it.
    struct Centres {
        V3 at;  // in cells
        F reach_sq, outside_sq;
        M touches_box;
    };
    HWY_INLINE Centres centres(std::size_t first) const
    {
        const F zero = hn::Zero(df);
        const V3 c = posed(
            {hn::LoadU(df, job_.centre_x + first), hn::LoadU(df, job_.centre_y + first), hn::LoadU(df, job_.centre_z + first)});
        const F reach = hn::Mul(hn::LoadU(df, job_.radius + first), set(job_.scale));
        Centres found;
        found.reach_sq = hn::Mul(hn::Mul(reach, reach), set(1.0001f));
        const V3 g = in_cells(c);
        // Clamped below the last cell's end, so that truncation stays within.
        const auto within = [&](F v, int k) { return hn::Min(hn::Max(v, zero), set(extent_[k] - 0.001f)); };
        found.at = {within(g.x, 0), within(g.y, 1), within(g.z, 2)};
        const V3 out = minus(g, found.at);
        found.outside_sq = hn::Mul(dot(out, out), set(locator_.cell * locator_.cell));
        found.touches_box = hn::Le(found.outside_sq, found.reach_sq);
        return found;
    }

    HWY_NOINLINE void fetch_clusters(std::size_t first) const
    {
        const Centres c = centres(first);
        if (!any(c.touches_box)) return;
        const Address a = address(c.at, c.touches_box);
        fetch(model_.locator_cells.data(), a.index, hn::AndNot(a.free_brick, c.touches_box));
    }

    /// The clusters of a mask from first on that may touch the solid: the same test, finer, for each lane.
    template <bool k_keeps>
    HWY_NOINLINE M near_clusters(std::size_t first, M which) const
    {
        const Centres c = centres(first);
        const M touches_box = hn::And(which, c.touches_box);
        M near = touches_box;
        F away = hn::Zero(df);
        if (any(touches_box)) {
            const Located found = locate(c.at, touches_box);
            const F gap = gap_of(found);
            const M far_away = hn::And(found.is_free, hn::Gt(gap, hn::Zero(df)));
            away = hn::Mul(gap, set(locator_.cell));
            near = hn::AndNot(hn::And(far_away, hn::Gt(mul_add(away, away, c.outside_sq), c.reach_sq)), touches_box);
            away = hn::IfThenElseZero(hn::And(far_away, touches_box), away);
        }
        if constexpr (k_keeps)
            if (job_.kept != nullptr) keep_clusters(first, c, which, away);
        return near;
    }

    /// Notes how far clusters may move before a point of them can be in the solid. away: of their centres from it, 0 where the
    /// locator does not say.
    HWY_INLINE void keep_clusters(std::size_t first, const Centres& c, M which, F away) const
    {
        // All outside the grid is free.
        const F clear = hn::Sub(hn::Sqrt(mul_add(away, away, c.outside_sq)), hn::Sqrt(c.reach_sq));
        hn::BlendedStore(due_after(clear), which, df, job_.kept->due.data() + first);
        job_.kept->reuse.clusters += count_of(which);
    }

    /// Clusters from one on that have to be looked at; beside them those that soon would have.
    template <bool k_keeps>
    HWY_INLINE M due_clusters(std::size_t first, std::size_t count) const
    {
        const M present = hn::FirstN(df, count);
        if (!k_keeps || job_.kept == nullptr) return present;
        const F due = hn::LoadU(df, job_.kept->due.data() + first);
        const M now = hn::And(present, hn::Le(due, set(job_.kept->travel)));
        return any(now) ? hn::And(present, hn::Le(due, set(job_.kept->soon))) : now;
    }
    HWY_INLINE bool is_due(std::size_t group) const
    {
        bool due = false;
        each_vector(group, [&](std::size_t c, std::size_t count) { due = due || any(due_clusters<true>(c, count)); });
        return due;
    }

    HWY_INLINE F due_after(F length) const
    {
        return hn::Add(set(job_.kept->travel), hn::Max(hn::Sub(length, set(job_.kept->margin)), hn::Zero(df)));
    }
    /// Notes that points from a slot on are free while they move less than a length.
    HWY_INLINE void keep_points(std::size_t slot, F length, M which) const
    {
        hn::BlendedStore(due_after(length), which, df, job_.kept->point_due.data() + slot);
    }
    /// Points from a slot on that have to be looked at. Where one has, those that soon would have are looked at too, so that
    /// their cluster rests as a whole; but not beside contacts, which have to be every time.
    struct DuePoints {
        M which;
        bool rests;
    };
    HWY_INLINE DuePoints due_points(std::size_t slot) const
    {
        const F due = hn::LoadU(df, job_.kept->point_due.data() + slot);
        DuePoints found{hn::Le(due, set(job_.kept->travel)), false};
        if (!any(found.which) || any(hn::Lt(due, hn::Zero(df)))) return found;
        return {hn::Le(due, set(job_.kept->soon)), true};
    }
    /// When all points of a cluster that was looked at are kept, so is the cluster.
    HWY_NOINLINE void keep_visited(std::size_t contacts) const
    {
        KeptProbe& kept = *job_.kept;
        kept.contacts = contacts;
        for (std::size_t v = 0; v < kept.visits; ++v) {
            const std::size_t c = kept.visited[v];
            F least = hn::LoadU(df, kept.point_due.data() + c * Probe::k_cluster);
            for (std::size_t k = hn::Lanes(df); k < Probe::k_cluster; k += hn::Lanes(df))
                least = hn::Min(least, hn::LoadU(df, kept.point_due.data() + c * Probe::k_cluster + k));
            kept.due[c] = hn::GetLane(hn::MinOfLanes(df, least));
        }
    }
    /// How far outside of the grid positions are, in cells.
    HWY_INLINE F outside_grid(const V3& g) const
    {
        const auto beyond = [&](F v, int k) { return hn::Max(hn::Max(hn::Neg(v), hn::Sub(v, set(extent_[k]))), hn::Zero(df)); };
        return hn::Max(hn::Max(beyond(g.x, 0), beyond(g.y, 1)), beyond(g.z, 2));
    }

    HWY_INLINE V3 posed(const V3& local) const
    {
        const float* r = job_.rotation;
        return {hn::Add(row_dot(r, local), set(job_.translation[0])), hn::Add(row_dot(r + 3, local), set(job_.translation[1])),
                hn::Add(row_dot(r + 6, local), set(job_.translation[2]))};
    }

    /// The points from a slot on, and those of them that are in the grid.
    struct Posed {
        V3 p;         // model space
        V3 in_cells;  // from the grid's corner
        M in_grid;
    };
    HWY_INLINE Posed pose(std::size_t slot) const
    {
        Posed e;
        e.p = posed({hn::LoadU(df, job_.x + slot), hn::LoadU(df, job_.y + slot), hn::LoadU(df, job_.z + slot)});
        e.in_cells = in_cells(e.p);
        e.in_grid = in_grid(e.in_cells);
        // The last cluster is filled up with copies of its last point, which must not answer.
        if (slot + hn::Lanes(df) > job_.points)
            e.in_grid = hn::And(e.in_grid, hn::FirstN(df, job_.points > slot ? job_.points - slot : 0));
        return e;
    }

    /// Points in cells that are not Free. Their cells may be divided.
    struct Entered {
        V3 p;         // model space
        V3 in_cells;  // from the grid's corner
        Located at;
        M occupied;
    };
    HWY_INLINE Entered enter(std::size_t slot, M which = hn::Not(none())) const
    {
        const Posed posed = pose(slot);
        const M in_grid = hn::And(posed.in_grid, which);
        Entered e{posed.p, posed.in_cells, locate(posed.in_cells, in_grid), in_grid};
        e.occupied = hn::AndNot(e.at.is_free, e.occupied);
        return e;
    }

protected:
    const ProbeJob& job_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
