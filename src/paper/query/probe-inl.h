// Section 4.2 for a whole probe on the paper's maps: spheres, layer 1, then the asked-for layer, part after part, and the witness
// rule.
#if defined(SQMAP_PAPER_PROBE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_PAPER_PROBE_INL_H
#undef SQMAP_PAPER_PROBE_INL_H
#else
#define SQMAP_PAPER_PROBE_INL_H
#endif

#include "paper/query/job.h"
#include "paper/query/part-inl.h"
#include "query/probe/contacts-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

/// The state of each point of a batch after the parts that have answered so far.
struct PointStates {
    static constexpr std::size_t k_size = 1024;  ///< whole clusters
    static constexpr std::size_t k_capacity = k_size + k_lanes;

    enum State : std::uint8_t { k_held = 1, k_free = 2, k_contact = 4, k_surface = 8 };

    std::size_t count = 0;
    float x[k_capacity], y[k_capacity], z[k_capacity];  ///< model space
    std::uint32_t point[k_capacity];
    std::uint8_t state[k_capacity];
    std::int16_t part[k_capacity];
    float key[k_capacity];  ///< distance to the tangent plane of the nearest surface so far
    float depth[k_capacity], normal_x[k_capacity], normal_y[k_capacity], normal_z[k_capacity];
};

/// Points that a part's superquadric may hold, side by side.
struct PointQueue {
    std::size_t count = 0;
    float field[3][PointStates::k_capacity];  ///< the superquadric's own frame
    std::int32_t slot[PointStates::k_capacity];

    HWY_INLINE void add(const V3& q, I slots, M which)
    {
        pack(q.x, which, field[0] + count);
        pack(q.y, which, field[1] + count);
        pack(q.z, which, field[2] + count);
        pack(slots, which, slot + count);
        count += count_of(which);
    }
    /// So that whole vectors hold points: the last one again.
    void fill_up()
    {
        for (std::size_t i = 0; i < k_lanes && count > 0; ++i) {
            for (auto& f : field) f[count + i] = f[count - 1];
            slot[count + i] = slot[count - 1];
        }
    }
    HWY_INLINE V3 position(std::size_t first) const
    {
        return {hn::LoadU(df, field[0] + first), hn::LoadU(df, field[1] + first), hn::LoadU(df, field[2] + first)};
    }
    HWY_INLINE I slots(std::size_t first) const { return hn::LoadU(di, slot + first); }
    HWY_INLINE M present(std::size_t first) const { return hn::FirstN(df, count - first); }
};

/// Answers of one part whose closest-point steps are to come: only whole vectors take them, however few lanes of a vector need
/// any.
class PendingAnswers {
public:
    std::size_t count = 0;
    std::int32_t slot[2 * k_lanes];

    HWY_INLINE void add(const PartAnswerLanes& a, I slots, M which)
    {
        each(a, [&](const F& value, std::size_t i) { pack(value, which, field_[i] + count); });
        pack(a.flags, which, flags_[0] + count);
        pack(a.shown_flags, which, flags_[1] + count);
        pack(slots, which, slot + count);
        count += count_of(which);
    }
    [[nodiscard]] HWY_INLINE PartAnswerLanes first() const
    {
        PartAnswerLanes a;
        a.contact = hn::Not(none());
        each(a, [&](F& value, std::size_t i) { value = hn::LoadU(df, field_[i]); });
        a.flags = hn::LoadU(di, flags_[0]);
        a.shown_flags = hn::LoadU(di, flags_[1]);
        return a;
    }
    /// So that the vector holds answers: the first one again.
    void fill_up()
    {
        const auto fill = [&](auto* values) { std::fill(values + count, values + std::max(count, hn::Lanes(df)), values[0]); };
        for (auto& values : field_) fill(values);
        for (auto& values : flags_) fill(values);
        fill(slot);
    }
    /// Lets the first vector go.
    HWY_INLINE void drop()
    {
        const std::size_t lanes = hn::Lanes(df);
        count -= std::min(count, lanes);
        const auto down = [&](auto* values) {
            for (std::size_t i = 0; i < count; ++i) values[i] = values[lanes + i];
        };
        for (auto& values : field_) down(values);
        for (auto& values : flags_) down(values);
        down(slot);
    }

private:
    template <class Answer, class Visit>
    static HWY_INLINE void each(Answer& a, Visit visit)
    {
        std::size_t i = 0;
        for (auto* arc : {&a.shown.position.latitude, &a.shown.position.longitude})
            for (auto* value : {&arc->c, &arc->s, &arc->nc, &arc->ns}) visit(*value, i++);
        for (auto* v : {&a.shown.at.point, &a.shown.at.normal, &a.surface, &a.normal})
            for (auto* value : {&v->x, &v->y, &v->z}) visit(*value, i++);
        visit(a.shown_distance, i++);
        visit(a.depth, i++);
    }

    float field_[22][2 * k_lanes];
    std::int32_t flags_[2][2 * k_lanes];
};

class PaperKernel {
public:
    explicit PaperKernel(const PaperJob& paper) : paper_(paper), job_(paper.probe), model_(job_.model), contacts_(job_) {}

    ProbeResult run()
    {
        if (job_.clusters == 0) {
            for (std::size_t first = 0; first < job_.points; first += Probe::k_cluster) add(first, job_.points);
        } else if (!is_far(model_.header.sphere, {job_.sphere[0], job_.sphere[1], job_.sphere[2]}, job_.sphere[3])) {
            for (std::size_t g = 0; g < job_.groups && !is_done(); ++g) {
                if (is_far(model_.header.sphere, {job_.group_x[g], job_.group_y[g], job_.group_z[g]}, job_.group_radius[g]))
                    continue;
                for (std::size_t c = g * Probe::k_cluster; c < std::min(job_.clusters, (g + 1) * Probe::k_cluster); ++c)
                    if (!is_far(model_.header.sphere, centre_of(c), job_.radius[c])) add(c * Probe::k_cluster, job_.points);
            }
        }
        finish();
        return contacts_.result();
    }

private:
    static constexpr std::size_t k_clusters = PointStates::k_size / Probe::k_cluster;

    bool is_done() const { return job_.first_only && contacts_.count() > 0; }
    Vec3f centre_of(std::size_t c) const { return {job_.centre_x[c], job_.centre_y[c], job_.centre_z[c]}; }
    /// No point of a sphere of the probe is in one of the model.
    bool is_far(const float* sphere, Vec3f centre, float radius) const
    {
        const float within = (radius * job_.scale + sphere[3]) * 1.0001f;
        return !(norm_sq(job_.in_model_space(centre) - model::vec3(sphere)) <= within * within);
    }

    /// The points of a cluster, up to an end, in model space.
    void add(std::size_t first, std::size_t end)
    {
        if (states_.count + Probe::k_cluster > PointStates::k_size) finish();
        const std::size_t size = std::min(Probe::k_cluster, end - first);
        const std::size_t at = states_.count;
        cluster_first_[clusters_] = at;
        const float* r = job_.rotation;
        const float* t = job_.translation;
        F low[3] = {set(INFINITY), set(INFINITY), set(INFINITY)}, high[3] = {set(-INFINITY), set(-INFINITY), set(-INFINITY)};
        for (std::size_t k = 0; k < size; k += hn::Lanes(df)) {
            const V3 p{hn::LoadU(df, job_.x + first + k), hn::LoadU(df, job_.y + first + k), hn::LoadU(df, job_.z + first + k)};
            const F posed[3] = {hn::Add(row_dot(r, p), set(t[0])), hn::Add(row_dot(r + 3, p), set(t[1])),
                                hn::Add(row_dot(r + 6, p), set(t[2]))};
            hn::StoreU(posed[0], df, states_.x + at + k);
            hn::StoreU(posed[1], df, states_.y + at + k);
            hn::StoreU(posed[2], df, states_.z + at + k);
            for (int i = 0; i < 3; ++i) {
                low[i] = smaller(low[i], posed[i]);
                high[i] = larger(high[i], posed[i]);
            }
        }
        for (std::size_t k = 0; k < size; ++k) {
            states_.point[at + k] = job_.point[first + k];
            states_.state[at + k] = 0;
        }
        bound(low, high);
        cluster_size_[clusters_++] = size;
        states_.count += Probe::k_cluster;
    }
    /// A sphere about a cluster, model space: about the box of its points.
    void bound(const F (&low)[3], const F (&high)[3])
    {
        float square = 0;
        for (int i = 0; i < 3; ++i) {
            const float lo = hn::GetLane(hn::MinOfLanes(df, low[i])), hi = hn::GetLane(hn::MaxOfLanes(df, high[i]));
            cluster_centre_[i][clusters_] = 0.5f * (lo + hi);
            square += 0.25f * (hi - lo) * (hi - lo);
        }
        cluster_radius_[clusters_] = std::sqrt(square);
    }

    /// Writes down the parts' answers about the batch.
    HWY_NOINLINE void finish()
    {
        if (is_done()) states_.count = clusters_ = 0;
        if (clusters_ == 0) return;
        for (std::size_t i = 0; i < model_.parts.size(); ++i) hear(i);
        if (paper_.options.layer != Layer::One && paper_.options.nearest_steps > 0) seek_nearest();
        for (std::size_t c = 0; c < clusters_; ++c)
            for (std::size_t k = 0; k < cluster_size_[c]; ++k) write(cluster_first_[c] + k);
        states_.count = clusters_ = 0;
    }
    void write(std::size_t s)
    {
        const std::uint8_t state = states_.state[s];
        if (job_.unproven != nullptr && (state & PointStates::k_held) != 0) job_.unproven[states_.point[s]] = 1;
        if ((state & PointStates::k_free) != 0 || (state & PointStates::k_contact) == 0 || is_done()) return;
        const Vec3f p{states_.x[s], states_.y[s], states_.z[s]};
        Contact c{p, {}, 0, states_.point[s], states_.part[s], false, k_no_surface};
        if ((state & PointStates::k_surface) != 0) {
            c.depth = std::max(states_.depth[s], 0.f);
            c.normal = {states_.normal_x[s], states_.normal_y[s], states_.normal_z[s]};
            c.witness = p + c.depth * c.normal;
            c.status = k_ok;
        }
        contacts_.write(c);
    }

    /// The nearest surface of contacts that any part's map shows: not always the one on the foot's line, nor one of the parts
    /// that hold the point, and below caps there is none yet.
    HWY_NOINLINE void seek_nearest()
    {
        open_ = 0;
        for (std::size_t c = 0; c < clusters_; ++c)
            for (std::size_t s = cluster_first_[c]; s < cluster_first_[c] + cluster_size_[c]; ++s) {
                const std::uint8_t state = states_.state[s];
                if ((state & PointStates::k_contact) == 0 || (state & PointStates::k_free) != 0) continue;
                if ((state & PointStates::k_surface) == 0) states_.key[s] = INFINITY;
                open_slots_[open_++] = static_cast<std::int32_t>(s);
            }
        for (std::size_t i = 0; i < model_.parts.size() && open_ > 0; ++i) seek_on(i);
    }
    void seek_on(std::size_t index)
    {
        const float* sphere = model_.parts[index].sphere;
        held_.count = 0;
        for (std::size_t k = 0; k < open_; ++k) {
            const auto s = static_cast<std::size_t>(open_slots_[k]);
            // Below no surface: of the parts that are about the point.
            const float reach = sphere[3] + std::min(states_.key[s], 0.5f * sphere[3]);
            const Vec3f d = Vec3f{states_.x[s], states_.y[s], states_.z[s]} - model::vec3(sphere);
            if (norm_sq(d) < reach * reach) held_.slot[held_.count++] = open_slots_[k];
        }
        if (held_.count == 0) return;
        held_.fill_up();
        const MapView view = map_of(paper_.model, index);
        const PartLanes part(view, paper_.options, job_.clusters == 0 ? nullptr : &arcs_);
        for (std::size_t first = 0; first < held_.count; first += hn::Lanes(df)) {
            const I at = held_.slots(first);
            const V3 p = position_of(at);
            PartAnswerLanes a;
            const M nearer = hn::And(held_.present(first), part.nearer_surface(p, hn::GatherIndex(df, states_.key, at), a));
            if (any(nearer)) seek_later(part, index, a, at, nearer);
        }
        seek_rest(part, index);
    }

    /// Closest-point steps of a vector of answers, now or with those to come.
    HWY_INLINE void seek_later(const PartLanes& part, std::size_t index, const PartAnswerLanes& a, I slots, M which)
    {
        pending_.add(a, slots, which);
        if (pending_.count >= hn::Lanes(df)) seek_pending(part, index);
    }
    HWY_INLINE void seek_rest(const PartLanes& part, std::size_t index)
    {
        if (pending_.count == 0) return;
        pending_.fill_up();
        seek_pending(part, index);
    }
    HWY_NOINLINE void seek_pending(const PartLanes& part, std::size_t index)
    {
        const V3 p = position_of(hn::LoadU(di, pending_.slot));
        const M present = hn::FirstN(df, pending_.count);
        PartAnswerLanes a = pending_.first();
        part.seek_nearest(p, present, a);
        speak(part, p, a, {present, none()}, {pending_.slot, index});
        pending_.drop();
    }

    /// One part about the points that are not known to be free.
    HWY_NOINLINE void hear(std::size_t index)
    {
        const float* sphere = model_.parts[index].sphere;
        std::uint8_t near[k_clusters];
        bool some = false;
        for (std::size_t c = 0; c < clusters_; ++c) {
            const Vec3f d = Vec3f{cluster_centre_[0][c], cluster_centre_[1][c], cluster_centre_[2][c]} - model::vec3(sphere);
            const float within = (cluster_radius_[c] + sphere[3]) * 1.0001f;
            near[c] = norm_sq(d) <= within * within ? 1 : 0;
            some = some || near[c] != 0;
        }
        if (!some) return;
        const MapView view = map_of(paper_.model, index);
        // For a few points a table is not worth its time.
        const PartLanes part(view, paper_.options, job_.clusters == 0 ? nullptr : &arcs_);
        in_box_.count = 0;
        for (std::size_t c = 0; c < clusters_; ++c)
            if (near[c] != 0) collect(part, sphere, c);
        if (in_box_.count == 0) return;
        in_box_.fill_up();
        held_.count = 0;
        for (std::size_t first = 0; first < in_box_.count; first += hn::Lanes(df)) hold(part, first, index);
        if (paper_.options.layer == Layer::One) return;
        held_.fill_up();
        for (std::size_t first = 0; first < held_.count; first += hn::Lanes(df)) answer(part, first, index);
        seek_rest(part, index);
    }

    static HWY_INLINE M in_sphere(const float* sphere, const V3& p)
    {
        const V3 d{hn::Sub(p.x, set(sphere[0])), hn::Sub(p.y, set(sphere[1])), hn::Sub(p.z, set(sphere[2]))};
        return hn::Le(dot(d, d), set(sphere[3] * sphere[3]));
    }

    /// The points of a cluster that are in the object's sphere and in the part's, and in its box.
    HWY_INLINE void collect(const PartLanes& part, const float* sphere, std::size_t c)
    {
        for (std::size_t k = 0; k < cluster_size_[c]; k += hn::Lanes(df)) {
            const std::size_t at = cluster_first_[c] + k;
            M open = hn::FirstN(df, cluster_size_[c] - k);
            HWY_ALIGN std::int32_t is_free[k_lanes];
            for (std::size_t i = 0; i < k_lanes; ++i) is_free[i] = states_.state[at + i] & PointStates::k_free;
            const V3 p{hn::LoadU(df, states_.x + at), hn::LoadU(df, states_.y + at), hn::LoadU(df, states_.z + at)};
            open = hn::And(hn::And(open, equal(hn::Load(di, is_free), hn::Zero(di))),
                           hn::And(in_sphere(sphere, p), in_sphere(model_.header.sphere, p)));
            if (!any(open)) continue;
            const V3 q = part.shape().to_local(p);
            const M inside = hn::And(open, in_box(part.shape().to_unit(q)));
            if (any(inside)) in_box_.add(q, hn::Iota(di, static_cast<std::int32_t>(at)), inside);
        }
    }

    HWY_INLINE V3 position_of(I slots) const
    {
        return {hn::GatherIndex(df, states_.x, slots), hn::GatherIndex(df, states_.y, slots),
                hn::GatherIndex(df, states_.z, slots)};
    }

    /// Layer 1 for a vector of the points in the box.
    HWY_NOINLINE void hold(const PartLanes& part, std::size_t first, std::size_t index)
    {
        HeldLanes point;
        point.q = in_box_.position(first);
        point.unit = part.shape().to_unit(point.q);
        const M held = hn::And(in_box_.present(first), holds(part.shape(), point));
        if (!any(held)) return;
        const I slots = in_box_.slots(first);
        each_lane(held, [&](std::size_t i) { states_.state[in_box_.slot[first + i]] |= PointStates::k_held; });
        if (paper_.options.layer != Layer::One) {
            held_.add(point.q, slots, held);
            return;
        }
        PartAnswerLanes a = part.layer_one(position_of(slots), point);
        // The deepest part speaks: the union's surface is outside every part that holds the point.
        note(a, hn::Neg(a.foot_distance), a.foot_distance, {held, none()}, {in_box_.slot + first, index});
    }

    HWY_NOINLINE void answer(const PartLanes& part, std::size_t first, std::size_t index)
    {
        HeldLanes point;
        point.q = held_.position(first);
        point.unit = part.shape().to_unit(point.q);
        (void)holds(part.shape(), point);
        const M present = held_.present(first);
        const V3 p = position_of(held_.slots(first));
        M seeks;
        PartAnswerLanes a = part.along_foot(p, point, hn::Not(none()), seeks);
        seeks = hn::And(seeks, present);
        if (any(seeks)) seek_later(part, index, a, held_.slots(first), seeks);
        speak(part, p, a,
              {hn::AndNot(seeks, hn::And(present, a.contact)), paper_.pruning ? hn::And(present, is_witness(a)) : none()},
              {held_.slot + first, index});
    }

    struct Verdicts {
        M contact, witness;
    };
    struct Speaker {
        const std::int32_t* slots;
        std::size_t part;
    };
    /// Smooths contacts, where that is asked for, and notes them.
    HWY_INLINE void speak(const PartLanes& part, const V3& p, PartAnswerLanes& a, const Verdicts& verdicts,
                          const Speaker& speaker)
    {
        if (paper_.smoothed_map && any(verdicts.contact)) part.smooth(p, a);
        note(a, paper_.smoothed_map ? a.depth : hn::Abs(a.depth), a.depth, verdicts, speaker);
    }

    /// The witness rule, point by point: the surface of the least key gives depth and normal. The smoothed depth is a key too:
    /// where it is the same in two parts, the one may take over from the other without a step of force.
    HWY_NOINLINE void note(const PartAnswerLanes& a, F key, F depth, const Verdicts& verdicts, const Speaker& speaker)
    {
        each_lane(verdicts.witness, [&](std::size_t i) { states_.state[speaker.slots[i]] |= PointStates::k_free; });
        if (!any(verdicts.contact)) return;
        HWY_ALIGN float keys[k_lanes], depths[k_lanes], x[k_lanes], y[k_lanes], z[k_lanes];
        hn::Store(key, df, keys);
        hn::Store(depth, df, depths);
        hn::Store(a.normal.x, df, x);
        hn::Store(a.normal.y, df, y);
        hn::Store(a.normal.z, df, z);
        const std::uint64_t surfaces = bits_of(has_surface(a));
        each_lane(verdicts.contact, [&](std::size_t i) {
            const auto s = static_cast<std::size_t>(speaker.slots[i]);
            std::uint8_t& state = states_.state[s];
            const auto part = static_cast<std::int16_t>(speaker.part);
            if ((surfaces >> i & 1u) != 0 && ((state & PointStates::k_surface) == 0 || keys[i] < states_.key[s])) {
                states_.key[s] = keys[i];
                states_.depth[s] = depths[i];
                states_.normal_x[s] = x[i];
                states_.normal_y[s] = y[i];
                states_.normal_z[s] = z[i];
                states_.part[s] = part;
                state |= PointStates::k_surface;
            } else if ((state & PointStates::k_contact) == 0) {
                states_.part[s] = part;
            }
            state |= PointStates::k_contact;
        });
    }

    const PaperJob& paper_;
    const ProbeJob& job_;
    const model::ModelView& model_;
    ContactWriter contacts_;
    PointStates states_;
    std::size_t clusters_ = 0;
    std::size_t cluster_first_[k_clusters], cluster_size_[k_clusters];
    float cluster_centre_[3][k_clusters], cluster_radius_[k_clusters];
    PointQueue in_box_, held_;
    PendingAnswers pending_;
    std::size_t open_ = 0;  // contacts
    std::int32_t open_slots_[PointStates::k_capacity];
    GridArcs arcs_;
};

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
