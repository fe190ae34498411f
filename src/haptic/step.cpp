// McNeely, Puterbaugh, Troy, "Six degree-of-freedom haptic rendering using voxel sampling", SIGGRAPH 1999 (pre-contact braking,
// virtual coupling); Ruspini, Kolarov, Khatib, "The haptic display of complex graphical environments", SIGGRAPH 1997, and
// Zilles, Salisbury, "A constraint-based god-object method for haptic display", IROS 1995 (the proxy); Hunt, Crossley,
// "Coefficient of restitution interpreted as damping in vibroimpact", J. Appl. Mech. 1975 (damping that grows with depth).
#include "sqmap/haptic/step.h"

#include "coupling.h"
#include "memory.h"
#include "sqmap/haptic/force.h"

namespace sqmap::haptic {

namespace {

constexpr double k_damping_depth = 0.001;  ///< m: deeper, damping has full strength
constexpr double k_free_slope = 3;         ///< a force may change by so many times stiffness times motion without being a jump
constexpr double k_proxy_slope = 1;        ///< a proxy's, which rests on its surface, so many times
constexpr double k_free_turn = 0.001;      ///< m: and across itself by its size times motion over this
constexpr double k_fade = 250;             ///< N/s: what is left of a jump fades no faster, so that the fading is none
constexpr double k_fade_arm = 0.05;        ///< m: its torque likewise, at this lever
constexpr double k_denser_share = 0.75;    ///< of the points that may touch: so many are expected of a denser set that is taken
constexpr int k_proxy_rounds = 4;
/// m: a proxy lies so deep, and so goes on touching what it rests on; of a patch that may be more.
constexpr double k_proxy_sink = 1e-5;
constexpr double k_other_side = -0.5;    ///< cosine between ways out
constexpr double k_ball_sink = 0.2;      ///< of its radius
constexpr double k_proxy_let_in = 1e-4;  ///< m a round
constexpr double k_proxy_step = 0.002;   ///< m a round, so that nothing thicker is passed through

Vec3d transform_back(const Pose& pose, Vec3d p) { return transpose_mul(pose.rotation, p - pose.translation); }
bool same(const Pose& a, const Pose& b) { return a.rotation == b.rotation && a.translation == b.translation; }
/// 1 at the centre of an impact sphere, 0 from its surface on, with zero slope there.
double share_of_sphere(double distance_sq, double radius)
{
    if (!(radius < INFINITY)) return 1;
    const double s = 1 - distance_sq / (radius * radius);
    return s > 0 ? s * s : 0;
}

}  // namespace

model::ModelView in_metres(const model::ModelView& model, double metres_per_unit) noexcept
{
    // Everything in a model but these four numbers is in model space.
    model::ModelView view = model;
    view.header.unit *= metres_per_unit;
    for (double& x : view.header.origin) x *= metres_per_unit;
    return view;
}

void State::reset() noexcept
{
    for (Memory& m : memory_) m = {};
    for (Touch& t : touches_) t = {};
    for (ZoneReport& r : reports_) r = {};
    for (Trail& t : trails_) t = {};
}

struct Stepper {
    State& state;
    const StepInput& in;
    std::span<Wrench> wrenches, on_touched;
    std::size_t solids = std::min(in.touched.size(), state.max_touched_);
    BodyLoad spread{};  ///< Coupled: of the last patch that was felt, the mean over its contacts of springs of 1 N/m

    using Touch = State::Touch;
    using Memory = State::Memory;

    /// Room for the contacts with a solid, and the query that it holds.
    std::span<query::ProbeContact> room(std::size_t s)
    {
        const std::size_t size = state.found_.size() / state.max_touched_;
        return std::span(state.found_).subspan(s * size, size);
    }

    Touch& touch(std::size_t z, std::size_t s) { return state.touches_[z * state.max_touched_ + s]; }

    /// The points that a zone feels with in this tick.
    DenserPoints points(std::size_t z) const
    {
        const Zone& zone = state.zones_[z];
        const std::uint32_t i = state.memory_[z].points;
        return i > 0 ? zone.denser[i - 1] : DenserPoints{zone.probe, zone.weights};
    }

    /// Denser points for the next tick while few touch, fewer where many do; the zone's own again once it is free, since what
    /// comes next may be a wall. Between the bounds nothing changes.
    void choose_points(std::size_t z)
    {
        const Zone& zone = state.zones_[z];
        Memory& m = state.memory_[z];
        const std::size_t touching = state.reports_[z].contacts;
        if (touching == 0) {
            m.points = 0;
        } else if (m.points > 0 && touching > zone.max_touching) {
            --m.points;
        } else if (m.points < zone.denser.size() && zone.options.averaging == Averaging::Patch && zone.first == 0 &&
                   zone.count >= zone.probe->size()) {
            const query::Probe* next = zone.denser[m.points].probe;
            const double growth = next == nullptr ? INFINITY : double(next->size()) / double(points(z).probe->size());
            if (growth * static_cast<double>(touching) < k_denser_share * zone.max_touching) ++m.points;
        }
    }

    const query::ProbeResult& ask(const query::Probe* probe, const ZoneOptions& options, std::size_t s, const Pose& probe_pose)
    {
        const Pose pose = compose(inverse(in.touched[s].pose), probe_pose);
        query::Layer layer = options.layer;
        if (layer == query::Layer::One) layer = query::Layer::Two;
        State::Asked& asked = state.asked_[s];
        if (probe != asked.probe || layer != asked.layer || !same(pose, asked.pose)) {
            const query::ProbeResult r = query::query_probe(*in.touched[s].model, *probe, pose, {.layer = layer}, room(s));
            asked = {probe, pose, layer, r};
        }
        return asked.result;
    }

    /// Where the probe stands when the zone stands at `at`.
    Pose probe_pose(std::size_t z, const Pose& at) const
    {
        if (!state.zones_[z].in_world) return at;
        if (same(at, in.poses[z])) return {};
        return compose(at, inverse(in.poses[z]));
    }

    Vec3d tip(std::size_t z, const Pose& at) const { return at.rotation * state.zones_[z].tip; }

    /// What a zone that stands at `at` feels of a solid. keep: the planes for a tick without a query.
    Felt feel(std::size_t z, std::size_t s, const Pose& at, Touch* keep)
    {
        const Zone& zone = state.zones_[z];
        ZoneReport& report = state.reports_[z];
        const query::ProbeResult result = ask(points(z).probe, zone.options, s, probe_pose(z, at));
        if (result.contacts > room(s).size()) report.status |= k_step_full;
        if ((result.status & query::k_probe_not_finite) != 0) report.status |= k_step_not_finite;
        const std::span<const query::ProbeContact> found = room(s).first(std::min(result.contacts, room(s).size()));
        const Felt felt =
            zone.options.averaging == Averaging::Patch ? feel_patch(z, s, at, found, keep) : feel_stencil(z, s, at, found, keep);
        report.contacts += felt.contacts;
        report.deepest = std::max(report.deepest, felt.deepest);
        return felt;
    }

    /// A contact as the world sees it.
    struct Found {
        Vec3d surface, normal;  ///< solid's frame
        double depth;
        Vec3d point;  ///< of the zone, from the pose's centre, world axes
    };

    /// False: not the zone's, or without a surface to push to.
    bool read(std::size_t z, std::size_t s, const Pose& at, const query::ProbeContact& c, Found& found)
    {
        const Zone& zone = state.zones_[z];
        const TouchedBody& solid = in.touched[s];
        if (state.memory_[z].points == 0 && (c.index < zone.first || c.index - zone.first >= zone.count)) return false;
        if ((c.status & query::k_no_surface) != 0) {
            state.reports_[z].status |= k_step_no_surface;
            return false;
        }
        found.surface = model::to_mesh_units(solid.model->header, c.point);
        found.normal = cast<double>(c.normal);
        found.depth = solid.model->header.unit * static_cast<double>(c.depth);
        found.point = apply(solid.pose, found.surface - found.depth * found.normal) - at.translation;
        return true;
    }

    Felt feel_patch(std::size_t z, std::size_t s, const Pose& at, std::span<const query::ProbeContact> contacts, Touch* keep)
    {
        const Zone& zone = state.zones_[z];
        const TouchedBody& solid = in.touched[s];
        const Texture* texture = solid.material.texture;
        const std::size_t stride = std::max<std::size_t>(1, (contacts.size() + k_kept - 1) / k_kept);
        if (keep != nullptr) keep->plane_count = 0, keep->single = false;
        ContactSum sum(zone.options);
        const std::span<const float> weights = points(z).weights;
        spread = {};
        double spread_over = 0;
        Found f;
        for (std::size_t i = 0; i < contacts.size(); ++i) {
            if (!read(z, s, at, contacts[i], f)) continue;
            Spring spring{f.point, {}, f.depth, share_of_sphere(norm_sq(f.point), zone.radius)};
            if (contacts[i].index < weights.size()) spring.weight *= static_cast<double>(weights[contacts[i].index]);
            if (!(spring.weight > 0)) continue;
            if (keep != nullptr && i % stride == 0 && keep->plane_count < k_kept)
                keep->planes[keep->plane_count++] = {f.surface, f.normal, transpose_mul(at.rotation, f.point), spring.weight};
            if (texture != nullptr) {
                const Carved c = carved(relief_at(*texture, f.surface, f.normal), f.depth, f.normal);
                spring.depth = c.depth;
                f.normal = c.normal;
            }
            spring.normal = solid.pose.rotation * f.normal;
            if (!(spring.depth > 0)) continue;
            sum.add(spring);
            if (zone.options.mode == Mode::Coupled) {
                spread.stiffen(spring.weight, spring.normal, spring.point);
                spread_over += spring.weight;
            }
        }
        if (spread_over > 0) spread.scale(1 / spread_over);
        return sum.felt();
    }

    /// The exact layer at a place: searched, not looked up.
    static Sample searched(const TouchedBody& solid, Vec3d at)
    {
        const model::Header& header = solid.model->header;
        const query::Contact c =
            query::query_point(*solid.model, model::to_model_space(header, transform_back(solid.pose, at)), query::Layer::Exact);
        if (!c.contact || (c.status & query::k_no_surface) != 0) return {};
        const Vec3d normal = solid.pose.rotation * cast<double>(c.normal);
        const double depth = header.unit * static_cast<double>(c.depth);
        return {{}, depth * normal, normal, depth};
    }

    /// From a place: the way to the nearest surface, sought about another way to it.
    static Vec3d nearer_surface(const TouchedBody& solid, Vec3d from, Vec3d way)
    {
        const model::Header& header = solid.model->header;
        if (!model::has_exact(*solid.model)) return way;
        const auto in_model = [&](Vec3d p) { return model::to_model_space(header, transform_back(solid.pose, p)); };
        query::Contact there;
        there.point = in_model(from + way);
        there.normal = cast<float>(normalized(transpose_mul(solid.pose.rotation, -1. * way)));
        const query::Contact c = query::nearest_surface(*solid.model, in_model(from), there);
        return c.contact ? apply(solid.pose, model::to_mesh_units(header, c.point)) - from : way;
    }

    Felt feel_stencil(std::size_t z, std::size_t s, const Pose& at, std::span<const query::ProbeContact> contacts, Touch* keep)
    {
        const Zone& zone = state.zones_[z];
        const TouchedBody& solid = in.touched[s];
        const std::size_t points = zone.probe->size(), first = std::min<std::size_t>(zone.first, points);
        const std::size_t own = std::min({std::size_t{zone.count}, points - first, state.samples_.size()});
        const Vec3d centre = tip(z, at);
        if (own < 2) return {};
        StencilSum sum;
        sum.samples = std::span(state.samples_).first(own - 1);
        for (Sample& sample : sum.samples) sample = {};
        Found f;
        for (const query::ProbeContact& c : contacts) {
            if (!read(z, s, at, c, f)) continue;
            const Vec3d normal = solid.pose.rotation * f.normal, place = f.point - centre;
            const Sample sample{place, place + f.depth * normal, normal, f.depth};
            if (const std::size_t i = c.index - first; i < sum.samples.size())
                sum.samples[i] = sample;
            else
                sum.centre = sample;
        }
        // Of the one point that the felt depth hangs on the nearest surface is searched for, not looked up.
        if (zone.options.layer == query::Layer::Exact && sum.centre.depth > 0) {
            sum.centre = searched(solid, at.translation + centre);
            sum.searched = true;
        }
        const std::span<Trail> trail =
            std::span(state.trails_).subspan((z * state.max_touched_ + s) * state.samples_.size(), own);
        Passed passed;
        if (const Touch& t = touch(z, s); keep != nullptr && t.known && state.memory_[z].known) {
            const Pose before = compose(inverse(t.solid_before), state.memory_[z].body_before);
            const Pose now = compose(inverse(solid.pose), at);
            const Twist moved = twist_between(before, now, 1);
            passed.motion =
                norm(apply(now, zone.tip) - apply(before, zone.tip)) + zone.options.smoothing.radius * norm(moved.angular);
            if (zone.options.blend_time > 0) passed.left = std::exp(-in.dt / zone.options.blend_time);
        }
        sum.trust_the_least(trail, passed, [&](Vec3d p) { return apply(solid.pose, p) - at.translation - centre; });
        const auto nearer = [&](Vec3d surface) {
            return zone.options.layer == query::Layer::Exact ? nearer_surface(solid, at.translation + centre, surface) : surface;
        };
        sum.settle(zone.options, trail[own - 1], passed, nearer);
        if (keep != nullptr) {
            for (std::size_t i = 0; i < sum.samples.size(); ++i) {
                const Sample& sample = sum.samples[i];
                trail[i] = {transform_back(solid.pose, sample.surface + at.translation + centre), sample.depth, true};
            }
            trail[own - 1] = {{}, sum.depth, true};
        }
        Felt felt = sum.felt(zone.options);
        felt.lever = centre;
        felt.torque = cross(centre, felt.force);
        if (keep != nullptr) keep_single(*keep, solid, at, felt, norm(felt.force));
        // Once, after the smoothing: it would be worn down by it. A proxy rests on what is smooth, and feels its spring carved.
        if (zone.options.mode != Mode::Proxy) carve(z, solid, at, felt);
        return felt;
    }

    /// Takes the relief off what a tip feels.
    void carve(std::size_t z, const TouchedBody& solid, const Pose& at, Felt& felt) const
    {
        const ZoneOptions& o = state.zones_[z].options;
        const double size = norm(felt.force);
        if (solid.material.texture == nullptr || !(size > 0)) return;
        const Vec3d normal = transpose_mul(solid.pose.rotation, felt.force / size);
        const double below = o.averaging == Averaging::Ball ? felt.depth - o.smoothing.radius : felt.depth;
        const Vec3d surface = transform_back(solid.pose, at.translation + felt.lever) + below * normal;
        const Carved c = carved(relief_at(*solid.material.texture, surface, normal), felt.depth, normal);
        felt.force = (size / felt.depth * c.depth) * (solid.pose.rotation * c.normal);
        felt.torque = cross(felt.lever, felt.force);
        felt.depth = c.depth;
    }

    static void keep_single(Touch& keep, const TouchedBody& solid, const Pose& at, const Felt& felt, double out)
    {
        keep.single = true;
        keep.plane_count = 0;
        if (!(felt.exact > 0) || !(norm_sq(felt.force) > 0)) return;
        const Vec3d normal = transpose_mul(solid.pose.rotation, normalized(felt.force));
        keep.planes[0] = {transform_back(solid.pose, at.translation + felt.lever) + out * normal, normal,
                          transpose_mul(at.rotation, felt.lever), 1};
        keep.plane_count = 1;
    }

    /// A proxy's spring at a place of the surface, with the relief taken off.
    static Vec3d carved_pull(const TouchedBody& solid, Vec3d place, Vec3d normal, Vec3d pull, double stiffness)
    {
        const double depth = dot(pull, normal) / stiffness;
        if (solid.material.texture == nullptr || !(depth > 0)) return pull;
        const Vec3d n = transpose_mul(solid.pose.rotation, normal);
        const Carved c = carved(relief_at(*solid.material.texture, transform_back(solid.pose, place), n), depth, n);
        return pull + stiffness * (c.depth * (solid.pose.rotation * c.normal) - depth * normal);
    }

    /// The same from the planes of the last query.
    Felt felt_of_planes(std::size_t z, std::size_t s, const Pose& at)
    {
        const Touch& t = touch(z, s);
        const TouchedBody& solid = in.touched[s];
        ContactSum sum(state.zones_[z].options);
        for (std::uint32_t i = 0; i < t.plane_count; ++i) {
            const Touch::Plane& p = t.planes[i];
            const Vec3d lever = at.rotation * p.probe, point = transform_back(solid.pose, at.translation + lever);
            const double depth = dot(p.point - point, p.normal);
            const Vec3d normal = solid.pose.rotation * p.normal;
            if (!(depth > 0)) continue;
            if (t.single) {
                Felt felt{depth, depth, depth * normal, cross(lever, depth * normal), lever, 1, depth};
                carve(z, solid, at, felt);
                return felt;
            }
            Carved c{depth, p.normal};
            if (const Texture* texture = solid.material.texture; texture != nullptr)
                c = carved(relief_at(*texture, point + depth * p.normal, p.normal), depth, p.normal);
            if (c.depth > 0) sum.add({lever, solid.pose.rotation * c.normal, c.depth, p.weight});
        }
        return sum.felt();
    }

    /// How the zone's material at a lever has moved over the solid since the last step.
    Vec3d motion_over(const Memory& m, const Touch& t, const TouchedBody& solid, const Pose& at, Vec3d lever) const
    {
        if (!m.known || !t.known) return {};
        const Vec3d now = at.translation + lever;
        const Vec3d zone_before = apply(m.body_before, transpose_mul(at.rotation, lever));
        const Vec3d solid_before = apply(t.solid_before, transform_back(solid.pose, now));
        return solid_before - zone_before;
    }

    /// rad: how far the zone has turned over the solid since the last step.
    double turn_over(const Memory& m, const Touch& t, const TouchedBody& solid, const Pose& at) const
    {
        if (!m.known || !t.known) return 0;
        const Pose before = compose(inverse(t.solid_before), m.body_before);
        return norm(twist_between(before, compose(inverse(solid.pose), at), 1).angular);
    }

    Vec3d velocity_over(const Twist& twist, const TouchedBody& solid, const Pose& at, Vec3d lever) const
    {
        return velocity_at(twist, lever) - velocity_at(solid.twist, at.translation + lever - solid.pose.translation);
    }

    /// Friction at the centre of a contact; stretches or lets slip the sticking spring.
    Vec3d friction(const ZoneOptions& o, Touch& t, const TouchedBody& solid, const Felt& felt, Vec3d normal, double load,
                   Vec3d motion, std::uint32_t& status) const
    {
        const Material& material = solid.material;
        if (material.friction == Friction::Paper) return printed_friction({material.f_c, material.k_f}, felt.depth, motion);
        if (material.friction != Friction::Coulomb || !(o.tangential_stiffness > 0)) return {};
        if (!t.touching) t.bristle = {}, t.stuck = true;
        if (t.stuck) t.mu = material.mu_static;
        Vec3d stretch = solid.pose.rotation * t.bristle + motion;
        stretch -= dot(stretch, normal) * normal;
        const double pull = o.tangential_stiffness * norm(stretch);
        if (pull > t.mu * load) {
            t.stuck = false;
            // What lets go does so over some ticks, or the drop from the one coefficient to the other is a jump.
            const double kept = o.blend_time > 0 ? std::exp(-in.dt / o.blend_time) : 0;
            t.mu = material.mu_dynamic + kept * std::max(t.mu - material.mu_dynamic, 0.);
            stretch = (t.mu * load / pull) * stretch;
            status |= k_step_slipping;
        } else {
            t.stuck = true;
        }
        t.bristle = transpose_mul(solid.pose.rotation, stretch);
        return -o.tangential_stiffness * stretch;
    }

    void add_to_solid(std::size_t s, const Wrench& w, Vec3d about)
    {
        if (s >= on_touched.size()) return;
        on_touched[s].force -= w.force;
        on_touched[s].torque -= w.torque + cross(about - in.touched[s].pose.translation, w.force);
    }

    /// The force against the approach, from where the zone will be.
    Wrench brake(std::size_t z, std::size_t s, const Pose& at, const Twist& twist)
    {
        const ZoneOptions& o = state.zones_[z].options;
        const TouchedBody& solid = in.touched[s];
        const Vec3d velocity = velocity_over(twist, solid, at, {});
        if (!(o.brake > 0) || !(o.brake_ahead > 0) || norm_sq(velocity) == 0) return {};
        const Pose there{rotation_by(o.brake_ahead * twist.angular) * at.rotation, at.translation + o.brake_ahead * velocity};
        ZoneReport& report = state.reports_[z];
        const ZoneReport kept = report;
        const BodyLoad kept_spread = spread;
        const Felt felt = feel(z, s, there, nullptr);
        report = kept;
        spread = kept_spread;
        const Vec3d normal = normalized(felt.force);
        const double approach = -dot(velocity_over(twist, solid, at, felt.lever), normal);
        if (!(felt.depth > 0) || !(approach > 0)) return {};
        const double share = std::min(1., felt.depth / (approach * o.brake_ahead));
        const Vec3d force = (o.brake * approach * share) * normal;
        return {force, cross(felt.lever, force)};
    }

    /// By how much motion explains that springs change in a tick.
    struct Explained {
        double force = 0, torque = 0;
        double turn = 0;  ///< of the force, rad
    };

    /// Modes Direct and Coupled: springs, damping and friction of all solids on a zone that stands at `at`.
    void push(std::size_t z, const Pose& at, const Twist& twist, Wrench& springs, Wrench& rest, BodyLoad* load,
              Explained& explained)
    {
        const ZoneOptions& o = state.zones_[z].options;
        Memory& m = state.memory_[z];
        ZoneReport& report = state.reports_[z];
        double total = 0;
        for (std::size_t s = 0; s < solids; ++s) {
            Touch& t = touch(z, s);
            const TouchedBody& solid = in.touched[s];
            Felt felt;
            if (in.degraded) {
                felt = felt_of_planes(z, s, at);
                report.contacts += felt.contacts;
                report.deepest = std::max(report.deepest, felt.deepest);
            } else {
                felt = feel(z, s, at, &t);
            }
            if (!in.degraded) t.braking = brake(z, s, at, twist);  // or as it was
            rest = rest + t.braking;
            add_to_solid(s, t.braking, at.translation);
            const double size = norm(felt.force);
            t.spring = 0;
            if (!(size > 0)) {
                t.touching = false;
                continue;
            }
            report.status |= k_step_contact;
            const Vec3d normal = felt.force / size;
            // A ball touches where its surface is, not at its centre.
            const double out = felt.depth - (o.averaging == Averaging::Ball ? o.smoothing.radius : 0);
            const Vec3d contact = o.averaging == Averaging::Ball ? felt.lever + out * normal : felt.lever;
            const Vec3d motion = motion_over(m, t, solid, at, contact);
            const Wrench spring{o.stiffness * felt.force, o.stiffness * felt.torque};
            const double spring_size = o.stiffness * size;
            const double approach = -dot(velocity_over(twist, solid, at, contact), normal);
            const double damping = o.damping * std::min(1., felt.depth / k_damping_depth);
            const double extra = std::max(damping * approach, -spring_size);
            const Vec3d rub = friction(o, t, solid, felt, normal, spring_size + extra, motion, report.status);
            const Vec3d other = extra * normal + rub;
            const Wrench side{other, cross(contact, other)};
            springs = springs + spring;
            if (load == nullptr) {
                rest = rest + side;
            } else {
                // Implicit: a light body is damped by far more than its mass over a tick.
                rest = rest + Wrench{rub, cross(contact, rub)};
                // The body lands without bouncing: drag is where it touches, not in free air.
                const double landing = std::max(damping, 2 * std::sqrt(o.mass * o.stiffness));
                const bool patch = o.averaging == Averaging::Patch && !in.degraded;
                if (!patch) {
                    spread = {};
                    spread.stiffen(1, normal, contact);
                }
                load->add(o.stiffness, spread);
                if (approach > 0) load->damp(landing, in.dt, velocity_over({}, solid, at, contact), normal, contact, spread);
                if (t.stuck && solid.material.friction == Friction::Coulomb)
                    load->stiffen_across(o.tangential_stiffness, normal, contact);
            }
            add_to_solid(s, spring + side, at.translation);
            t.touching = true;
            t.spring = spring_size;
            const double slope = k_free_slope * o.stiffness, reach = std::max(felt.reach, norm(contact));
            explained.force = std::max(explained.force, slope * norm(motion));
            explained.turn = std::max(explained.turn, norm(motion) / k_free_turn);
            explained.torque =
                std::max(explained.torque, slope * reach * (norm(motion) + (reach + norm(contact)) * turn_over(m, t, solid, at)));
            report.depth += felt.depth * size;
            report.point += size * (at.translation + felt.lever + out * normal);
            report.potential += 0.5 * o.stiffness * felt.depth * felt.depth;
            total += size;
        }
        if (total > 0) {
            report.depth = report.depth / total;
            report.point = report.point / total;
        }
        report.normal = normalized(springs.force);
    }

    /// How much of a change is none that motion explains.
    static double share_beyond(double change, double explained) { return change > explained ? 1 - explained / change : 0; }

    /// Spreads jumps over time, as where the foot point crosses a medial axis. The springs tell of a jump; what damping and
    /// friction, whose normal and lever jump with it, change by in that tick is spread alike, so that the whole wrench stays as
    /// it was but for what motion explains.
    Wrench blended(std::size_t z, bool touching, const Wrench& springs, const Wrench& whole, const Explained& explained)
    {
        const ZoneOptions& o = state.zones_[z].options;
        Memory& m = state.memory_[z];
        if (!touching || !(o.blend_time > 0)) {
            m.left = {};
        } else if (m.was_touching) {
            // A share of a large jump would be a jump itself.
            const double size = std::max(norm(m.left.force), norm(m.left.torque) / k_fade_arm);
            const double slowest = size > 0 ? 1 - k_fade * in.dt / size : 0;
            m.left = std::max(std::exp(-in.dt / o.blend_time), slowest) * m.left;
            const Wrench change = springs + -1. * m.springs_before;
            const double before = norm(m.springs_before.force), now = norm(springs.force), grown = now - before;
            const double across = std::sqrt(std::max(norm_sq(change.force) - grown * grown, 0.));
            const double jump = std::max({share_beyond(norm(change.force), explained.force),
                                          share_beyond(across, std::max(before, now) * explained.turn),
                                          share_beyond(norm(change.torque), explained.torque)});
            if (jump > 0) m.left = m.left + -jump * (whole + -1. * m.whole_before);
            if (norm(m.left.force) > 1e-6 * norm(springs.force)) state.reports_[z].status |= k_step_blended;
        }
        m.springs_before = springs;
        m.whole_before = whole;
        m.was_touching = touching;
        return whole + m.left;
    }

    /// What is left of jumps, to the solids too, each its share of the springs.
    void add_left_to_solids(std::size_t z, const Vec3d& about)
    {
        double total = 0;
        for (std::size_t s = 0; s < solids; ++s) total += touch(z, s).spring;
        if (total > 0)
            for (std::size_t s = 0; s < solids; ++s) add_to_solid(s, touch(z, s).spring / total * state.memory_[z].left, about);
    }

    /// As much of the torque as the zone is to have.
    Wrench with_its_share(std::size_t z, const Wrench& w) const
    {
        return {w.force, state.zones_[z].options.torque_share * w.torque};
    }

    Wrench direct(std::size_t z)
    {
        Wrench springs, rest;
        Explained explained;
        push(z, in.poses[z], state.memory_[z].device_twist, springs, rest, nullptr, explained);
        const bool touching = (state.reports_[z].status & k_step_contact) != 0;
        const Wrench w = blended(z, touching, springs, springs + rest, explained);
        add_left_to_solids(z, in.poses[z].translation);
        return with_its_share(z, w);
    }

    Wrench coupled(std::size_t z)
    {
        Memory& m = state.memory_[z];
        const ZoneOptions& o = state.zones_[z].options;
        if (!m.has_body) {
            m.body = in.poses[z];
            m.body_twist = m.device_twist;
            m.has_body = true;
        }
        Wrench springs, rest, on_hand;
        BodyLoad load;
        Explained explained;
        const Pose at = m.body;
        state.reports_[z].body = at;
        push(z, at, m.body_twist, springs, rest, &load, explained);
        load.wrench = load.wrench + with_its_share(z, springs + rest);
        m.body_before = at;
        if (!step_body(o, in.poses[z], m.device_twist, load, in.dt, m.body, m.body_twist, on_hand)) {
            m.has_body = false;
            state.reports_[z].status |= k_step_not_finite;
            return {};
        }
        // The body leaps as its surface does, and its own motion would explain any force: the device's is what counts.
        // Of an encoder the steps come now and then, and the body follows in between.
        const double way = std::max(m.track.step(), in.dt * norm(m.device_twist.linear)) + o.resolution;
        const double turn = std::max(m.track.turn(), in.dt * norm(m.device_twist.angular)) + o.resolution / k_fade_arm;
        const Explained by_device{k_free_slope * o.coupling_stiffness * way, k_free_slope * o.coupling_rotational * turn,
                                  way / k_free_turn};
        return with_its_share(z, blended(z, true, on_hand, on_hand, by_device));
    }

    /// The nearest place to the goal that no plane forbids: each plane in turn, a few times over.
    static Vec3d project(Vec3d goal, std::span<const Touch> touches, std::span<const TouchedBody> over, const Pose& at)
    {
        Vec3d p = goal;
        for (int round = 0; round < 8; ++round)
            for (std::size_t s = 0; s < over.size(); ++s)
                if (const Touch& t = touches[s]; t.plane_count > 0) {
                    const Vec3d point = transform_back(over[s].pose, p + at.rotation * t.planes[0].probe);
                    const double below = dot(t.planes[0].point - point, t.planes[0].normal);
                    if (below > 0) p += below * (over[s].pose.rotation * t.planes[0].normal);
                }
        return p;
    }

    /// Whether anything is felt at a place; the report stays.
    bool touches_at(std::size_t z, const Pose& at)
    {
        ZoneReport& report = state.reports_[z];
        const ZoneReport kept = report;
        bool touches = false;
        for (std::size_t s = 0; s < solids; ++s) touches = touches || feel(z, s, at, nullptr).exact > 0;
        report = kept;
        return touches;
    }

    /// The proxy goes to the device as far as the surfaces let it.
    Wrench proxy(std::size_t z)
    {
        Memory& m = state.memory_[z];
        const ZoneOptions& o = state.zones_[z].options;
        ZoneReport& report = state.reports_[z];
        const Vec3d goal = in.poses[z].translation;
        // A tool of many points that rested on its deepest would change it at every step, and its lever with it.
        // Likewise a ball on facets.
        const bool rests = o.averaging != Averaging::Stencil, ball = o.averaging == Averaging::Ball;
        const double room = ball ? std::min(o.proxy_depth, k_ball_sink * o.smoothing.radius) : o.proxy_depth;
        const double sink = std::max(rests ? room : 0., k_proxy_sink);
        if (!m.has_body) {
            m.body = in.poses[z];
            m.inside = true;
        }
        m.has_body = true;
        if (m.inside && !in.degraded && !touches_at(z, in.poses[z])) {
            // It began inside and may have come out anywhere: once the device is free, it is where the device is.
            m.inside = false;
            m.body = in.poses[z];
            for (std::size_t s = 0; s < solids; ++s) touch(z, s).plane_count = 0;
        }
        m.body.rotation = in.poses[z].rotation;
        const std::span<Touch> touches = std::span(state.touches_).subspan(z * state.max_touched_, solids);
        // A surface that moves carries along what lies on it.
        double motion = m.track.step();
        for (std::size_t s = 0; s < solids; ++s)
            if (touches[s].touching && touches[s].known) {
                const Vec3d still = m.body.translation;
                m.body.translation = apply(in.touched[s].pose, transform_back(touches[s].solid_before, still));
                motion += norm(m.body.translation - still);
                break;
            }
        for (Touch& t : touches)
            if (t.plane_count == 0) t.sink = sink;
        const Vec3d before = m.body.translation;
        // The way out of all that it lies on, how deep it lies in each, and how far the device is behind it.
        const auto way_out = [&] {
            Vec3d normal{};
            for (std::size_t s = 0; s < solids; ++s)
                if (touches[s].plane_count > 0) normal += in.touched[s].pose.rotation * touches[s].planes[0].normal;
            return normalized(normal);
        };
        const auto borne = [&](std::size_t s, Vec3d at) {
            const Touch& t = touches[s];
            if (t.plane_count == 0 || !rests) return Vec3d{};
            const Vec3d point = transform_back(in.touched[s].pose, at + m.body.rotation * t.planes[0].probe);
            const double depth = std::clamp(t.sink - dot(point - t.planes[0].point, t.planes[0].normal), 0., t.sink);
            return depth * (in.touched[s].pose.rotation * t.planes[0].normal);
        };
        const auto load_at = [&](Vec3d at, Vec3d normal) {
            double load = dot(at - goal, normal);
            for (std::size_t s = 0; s < solids; ++s) load += dot(borne(s, at), normal);
            return load;
        };
        // Friction holds it back: a cone about the normal through the device. In every round, or it would look for its rest where
        // it never stands.
        const auto held_back = [&](Vec3d at, auto&& slips) {
            const Vec3d normal = way_out();
            const double load = load_at(at, normal);
            Vec3d back = before - at;
            back -= dot(back, normal) * normal;
            const double length = norm(back);
            for (std::size_t s = 0; s < solids; ++s) {
                const Touch& t = touches[s];
                const Material& material = in.touched[s].material;
                if (t.plane_count == 0 || !(load > 0) || !t.touching || material.friction != Friction::Coulomb) continue;
                const bool slip = length > (t.stuck ? material.mu_static : material.mu_dynamic) * load;
                slips(s, slip);
                return at + (slip ? material.mu_dynamic * load / length : 1.) * back;
            }
            return at;
        };
        const auto nearest = [&] { return project(goal, touches, in.touched.first(solids), m.body); };
        for (int round = 0; round < k_proxy_rounds; ++round) {
            const Vec3d way = held_back(nearest(), [](std::size_t, bool) {}) - m.body.translation;
            const double length = norm(way);
            if (round > 0 && length < k_proxy_sink) break;
            m.body.translation += (length > k_proxy_step ? k_proxy_step / length : 1.) * way;
            if (in.degraded) break;
            report.contacts = 0;
            for (std::size_t s = 0; s < solids; ++s) {
                Touch& t = touches[s];
                const Felt felt = feel(z, s, m.body, nullptr);
                if (felt.exact > 0 && norm_sq(felt.force) > 0) {
                    const Vec3d felt_out = normalized(felt.force);
                    if (o.averaging == Averaging::Patch && t.plane_count > 0 && t.sink > 2 * k_proxy_sink &&
                        dot(felt_out, in.touched[s].pose.rotation * t.planes[0].normal) < k_other_side) {
                        // So deep it feels the other side of something thin: half as deep, until it leaves.
                        t.sink *= 0.5;
                        t.planes[0].point += t.sink * t.planes[0].normal;
                        continue;
                    }
                    const double out = (rests ? felt.depth : felt.exact) - t.sink;
                    keep_single(t, in.touched[s], m.body, felt, out);
                    m.body.translation += std::max(out, 0.) * felt_out;
                    t.let_in = 0;
                } else if (t.plane_count > 0) {
                    // The surface has curved away from its plane, or the smoothed direction led a hair past it: the plane goes
                    // in until it is felt again. Without one the proxy would fall, and the force with it.
                    t.planes[0].point -= k_proxy_let_in * t.planes[0].normal;
                    t.let_in += k_proxy_let_in;
                    if (t.let_in > k_proxy_step) t.plane_count = 0;
                }
            }
        }
        const Vec3d normal = way_out();
        const double load = load_at(m.body.translation, normal);
        std::size_t slipping = solids;
        (void)held_back(nearest(), [&](std::size_t s, bool slip) { slipping = slip ? s : solids; });
        for (std::size_t s = 0; s < solids; ++s) {
            Touch& t = touches[s];
            t.touching = t.plane_count > 0 && load > 0;
            t.stuck = s != slipping || !t.touching;
            if (!t.stuck) report.status |= k_step_slipping;
        }
        report.body = m.body;
        if (!(load > 0)) {
            (void)blended(z, false, {}, {}, {});
            return {};
        }
        report.status |= k_step_contact;
        report.normal = normal;
        const Vec3d held = m.body.translation - goal;
        Vec3d stretch = held;
        for (std::size_t s = 0; s < solids; ++s) stretch += borne(s, m.body.translation);
        report.depth = norm(stretch);
        report.potential = 0.5 * o.stiffness * report.depth * report.depth;
        const double approach = -dot(m.device_twist.linear, normal);
        const double damped = o.damping * approach * std::min(1., load / k_damping_depth);
        const Vec3d damping = std::max(damped, -o.stiffness * load) * normal;
        Vec3d lever{};
        Wrench springs, whole;
        double share = 0;
        for (std::size_t s = 0; s < solids; ++s) share += touches[s].touching ? 1 : 0;
        for (std::size_t s = 0; s < solids; ++s)
            if (touches[s].touching) {
                Vec3d arm = m.body.rotation * touches[s].planes[0].probe;
                const Vec3d normal_there = in.touched[s].pose.rotation * touches[s].planes[0].normal;
                if (ball) arm -= (o.smoothing.radius - norm(borne(s, m.body.translation))) * normal_there;  // where it rubs
                Vec3d pull = o.stiffness * (held / share + borne(s, m.body.translation));
                if (o.averaging != Averaging::Patch)
                    pull = carved_pull(in.touched[s], m.body.translation + arm, normal_there, pull, o.stiffness);
                Vec3d force = pull + damping / share;
                if (const Material& material = in.touched[s].material; material.friction == Friction::Paper) {
                    const Vec3d moved = in.dt * velocity_over(m.device_twist, in.touched[s], in.poses[z], {});
                    force +=
                        printed_friction({material.f_c, material.k_f}, load, moved - dot(moved, normal_there) * normal_there);
                }
                lever += arm / share;
                touches[s].spring = norm(pull);
                springs = springs + Wrench{pull, cross(arm, pull)};
                const Wrench w{force, cross(arm, force)};
                whole = whole + w;
                add_to_solid(s, w, m.body.translation);
            } else {
                touches[s].spring = 0;
            }
        report.point = m.body.translation + lever;
        // Between walls it may lie on the one or the other, and off an edge it drops, with its lever: such jumps are blended.
        const double slope = k_proxy_slope * o.stiffness, arm = norm(lever);
        const Wrench w = blended(z, true, springs, whole,
                                 {slope * motion, slope * arm * (motion + arm * m.track.turn()), motion / k_free_turn});
        add_left_to_solids(z, m.body.translation);
        return with_its_share(z, w);
    }

    void clear(std::size_t z)
    {
        state.memory_[z] = {};
        for (std::size_t s = 0; s < state.max_touched_; ++s) touch(z, s) = {};
        const std::size_t size = state.max_touched_ * state.samples_.size();
        for (Trail& t : std::span(state.trails_).subspan(z * size, size)) t = {};
    }

    StepResult run()
    {
        StepResult result;
        for (Wrench& w : wrenches) w = {};
        for (Wrench& w : on_touched) w = {};
        for (State::Asked& a : state.asked_) a = {};  // a probe may have been moved
        const std::size_t zones = state.zones_.size();
        if (wrenches.size() < zones || (!on_touched.empty() && on_touched.size() < in.touched.size()))
            result.status |= k_step_short_span;
        bool sound = std::isfinite(in.dt) && in.dt > 0;
        for (const TouchedBody& solid : in.touched)
            sound = sound && solid.model != nullptr && is_finite(solid.pose) && is_finite(solid.twist);
        if (in.touched.size() > solids) result.status |= k_step_full;
        if (in.degraded) {
            ++state.degraded_steps_;
            result.status |= k_step_degraded;
        }
        for (std::size_t z = 0; z < zones; ++z) {
            ZoneReport& report = state.reports_[z];
            Memory& m = state.memory_[z];
            report = {};
            if (!sound || z >= in.poses.size() || !is_finite(in.poses[z]) || state.zones_[z].probe == nullptr ||
                (z < in.twists.size() && !is_finite(in.twists[z]))) {
                report.status = k_step_not_finite;
                clear(z);
                result.status |= report.status;
                continue;
            }
            const Pose& device = in.poses[z];
            // What was touched before it, friction's stretch, a proxy behind a wall: no motion leads there.
            if (m.track.jumps(device, k_teleport, k_teleport_turn, in.dt)) {
                clear(z);
                report.status |= k_step_teleport;
            }
            m.track.add(device, in.dt);
            m.device_twist = z < in.twists.size() ? in.twists[z] : m.track.twist(state.zones_[z].options.resolution);
            report.body = device;
            report.points = m.points;
            Wrench w;
            switch (state.zones_[z].options.mode) {
                case Mode::Direct:
                    w = direct(z);
                    m.body_before = device;
                    m.has_body = false;
                    break;
                case Mode::Proxy:
                    w = proxy(z);
                    break;
                case Mode::Coupled:
                    w = coupled(z);
                    break;
            }
            const ZoneOptions& o = state.zones_[z].options;
            report.push = o.stiffness * report.depth;
            if (o.mode == Mode::Coupled)
                report.push = std::max(report.push, o.coupling_stiffness * norm(report.body.translation - device.translation));
            m.known = true;
            if (!in.degraded) choose_points(z);
            for (std::size_t s = 0; s < solids; ++s) {
                touch(z, s).solid_before = in.touched[s].pose;
                touch(z, s).known = true;
            }
            if (in.degraded) report.status |= k_step_degraded;
            if (!std::isfinite(norm_sq(w.force)) || !std::isfinite(norm_sq(w.torque))) {  // sizes count too: they may overflow
                w = {};
                report.status |= k_step_not_finite;
                clear(z);
            }
            if (z < wrenches.size()) wrenches[z] = w;
            result.status |= report.status;
            result.contacts += report.contacts;
            result.deepest = std::max(result.deepest, report.deepest);
        }
        return result;
    }
};

StepResult step(State& state, const StepInput& input, std::span<Wrench> wrenches, std::span<Wrench> on_touched) noexcept
{
    return Stepper{state, input, wrenches, on_touched}.run();
}

}  // namespace sqmap::haptic
