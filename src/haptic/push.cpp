// McNeely, Puterbaugh, Troy, "Six degree-of-freedom haptic rendering using voxel sampling", SIGGRAPH 1999 (pre-contact braking);
// Hunt, Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", J. Appl. Mech. 1975 (damping that grows
// with depth).
#include "push.h"

#include "contact_force.h"

namespace sqmap::haptic {

namespace {

constexpr double k_fade = 250;  ///< N/s: the remains of a jump fade no faster, so that fading is no jump itself

/// The share of a change that is not explained.
double share_beyond(double change, double explained) { return change > explained ? 1 - explained / change : 0; }

/// How the zone's material at a lever has moved over body s since the last step, m.
Vec3d motion_over(const ZoneTick& tick, std::size_t s, const Pose& at, Vec3d lever)
{
    const TouchMemory& t = tick.touches[s];
    if (!tick.memory.known || !t.known) return {};
    const Vec3d now = at.translation + lever;
    const Vec3d zone_before = apply(tick.memory.points_before, transpose_mul(at.rotation, lever));
    const Vec3d body_before = apply(t.body_before, apply_inverse(tick.body(s).pose, now));
    return body_before - zone_before;
}

/// How far the zone has turned over body s since the last step, rad.
double turn_over(const ZoneTick& tick, std::size_t s, const Pose& at)
{
    const TouchMemory& t = tick.touches[s];
    if (!tick.memory.known || !t.known) return 0;
    const Pose before = compose(inverse(t.body_before), tick.memory.points_before);
    return norm(twist_between(before, compose(inverse(tick.body(s).pose), at), 1).angular);
}

/// The force against the approach, from the position that the zone will reach.
Wrench brake(ZoneTick& tick, std::size_t s, const PointsMotion& points)
{
    const ZoneOptions& o = tick.options;
    const Vec3d velocity = tick.velocity_over(s, points.twist, points.pose, {});
    if (!(o.brake > 0) || !(o.brake_ahead > 0) || norm_sq(velocity) == 0) return {};
    const Pose there{rotation_by(o.brake_ahead * points.twist.angular) * points.pose.rotation,
                     points.pose.translation + o.brake_ahead * velocity};
    const ZoneReport kept = tick.report;
    const ContactForce ahead = contact_force(tick, {s, there}).force;
    tick.report = kept;
    const Vec3d normal = normalized(ahead.force);
    const double approach = -dot(tick.velocity_over(s, points.twist, points.pose, ahead.lever), normal);
    if (!(ahead.depth > 0) || !(approach > 0)) return {};
    const double share = std::min(1., ahead.depth / (approach * o.brake_ahead));
    const Vec3d force = (o.brake * approach * share) * normal;
    return {force, cross(ahead.lever, force)};
}

/// The contact with body s: of a query, or of the last planes.
SpreadForce contact(ZoneTick& tick, std::size_t s, const PointsMotion& points)
{
    if (!tick.in.degraded) {
        const SpreadForce force = contact_force(tick, {s, points.pose, true});
        tick.touches[s].braking = brake(tick, s, points);
        return force;
    }
    const ContactForce force = plane_force(tick, s, points.pose);
    tick.report.contacts += force.contacts;
    tick.report.deepest = std::max(tick.report.deepest, force.deepest);
    return {force};
}

/// Sliding at the centre of a contact.
struct Sliding {
    Vec3d normal{};    ///< unit, outwards, world
    double load = 0;   ///< N, along the normal
    double depth = 0;  ///< m
    Vec3d motion{};    ///< m, of the contact over the body since the last step, world
};

/// N, world. Coulomb: stretches the sticking spring of body s or lets it slip, and reports slipping.
Vec3d friction_force(ZoneTick& tick, std::size_t s, const Sliding& c)
{
    const ZoneOptions& o = tick.options;
    const TouchedBody& body = tick.body(s);
    const Material& material = body.material;
    TouchMemory& t = tick.touches[s];
    if (material.friction == Friction::Paper) return printed_friction({material.f_c, material.k_f}, c.depth, c.motion);
    if (material.friction != Friction::Coulomb || !(o.tangential_stiffness > 0)) return {};
    if (!t.touching) t.bristle = {}, t.stuck = true;
    if (t.stuck) t.mu = material.mu_static;
    Vec3d stretch = body.pose.rotation * t.bristle + c.motion;
    stretch -= dot(stretch, c.normal) * c.normal;
    const double pull = o.tangential_stiffness * norm(stretch);
    if (pull > t.mu * c.load) {
        t.stuck = false;
        // The release takes some ticks: the drop from one coefficient to the other would be a jump.
        const double kept = o.blend_time > 0 ? std::exp(-tick.in.dt / o.blend_time) : 0;
        t.mu = material.mu_dynamic + kept * std::max(t.mu - material.mu_dynamic, 0.);
        stretch = (t.mu * c.load / pull) * stretch;
        tick.report.status |= k_step_slipping;
    } else {
        t.stuck = true;
    }
    t.bristle = transpose_mul(body.pose.rotation, stretch);
    return -o.tangential_stiffness * stretch;
}

/// The push of one body.
struct Contact {
    std::size_t body = 0;
    Vec3d normal{};       ///< unit, outwards
    double size = 0;      ///< of the force over the stiffness
    double out = 0;       ///< m from the contact's centre to the surface
    Vec3d centre{};       ///< on the surface, from the pose's centre
    Vec3d motion{};       ///< over the body since the last step
    double approach = 0;  ///< m/s, into the body
    double damping = 0;   ///< N s/m
};

/// Sums up the bodies' pushes.
struct PushSum {
    ZoneTick& tick;
    const PointsMotion& points;
    Push sum{};
    double total = 0;  ///< of contacts' sizes

    [[nodiscard]] Contact contact_of(std::size_t s, const ContactForce& force) const
    {
        const ZoneOptions& o = tick.options;
        Contact c;
        c.body = s;
        c.size = norm(force.force);
        c.normal = force.force / c.size;
        // A ball touches at its surface, not at its centre.
        const bool ball = o.averaging == Averaging::Ball;
        c.out = force.depth - (ball ? o.smoothing.radius : 0);
        c.centre = ball ? force.lever + c.out * c.normal : force.lever;
        c.motion = motion_over(tick, s, points.pose, c.centre);
        c.approach = -dot(tick.velocity_over(s, points.twist, points.pose, c.centre), c.normal);
        c.damping = o.damping * std::min(1., force.depth / k_damping_depth);
        return c;
    }

    void add(std::size_t s)
    {
        const ZoneOptions& o = tick.options;
        TouchMemory& t = tick.touches[s];
        const SpreadForce found = contact(tick, s, points);
        const ContactForce& force = found.force;
        sum.rest = sum.rest + t.braking;
        tick.add_reaction(s, t.braking, points.pose.translation);
        t.spring = 0;
        if (!(norm(force.force) > 0)) {
            t.touching = false;
            return;
        }
        tick.report.status |= k_step_contact;
        const Contact c = contact_of(s, force);
        const Wrench spring{o.stiffness * force.force, o.stiffness * force.torque};
        const double spring_size = o.stiffness * c.size, extra = std::max(c.damping * c.approach, -spring_size);
        const Vec3d rub = friction_force(tick, s, {c.normal, spring_size + extra, force.depth, c.motion});
        const Vec3d other = extra * c.normal + rub;
        const Wrench side{other, cross(c.centre, other)};
        sum.springs = sum.springs + spring;
        if (o.mode == Mode::Coupled) {
            // Implicit: a light body is damped by far more than its mass over a tick.
            sum.rest = sum.rest + Wrench{rub, cross(c.centre, rub)};
            add_load(c, found.spread);
        } else {
            sum.rest = sum.rest + side;
        }
        tick.add_reaction(s, spring + side, points.pose.translation);
        t.touching = true;
        t.spring = spring_size;
        add_explained(c, std::max(force.reach, norm(c.centre)));
        add_to_report(c, force);
    }

    /// Adds a contact to the load of a coupled body's implicit step.
    void add_load(const Contact& c, BodyLoad spread)
    {
        const ZoneOptions& o = tick.options;
        if (o.averaging != Averaging::Patch || tick.in.degraded) {
            spread = {};
            spread.stiffen(1, c.normal, c.centre);
        }
        sum.load.add(o.stiffness, spread);
        // The body lands without bouncing: drag is where it touches, not in free air.
        const double landing = std::max(c.damping, 2 * std::sqrt(o.mass * o.stiffness));
        if (c.approach > 0) {
            const Vec3d away = tick.velocity_over(c.body, {}, points.pose, c.centre);
            sum.load.damp({landing, away, c.normal, c.centre}, tick.in.dt, spread);
        }
        if (tick.touches[c.body].stuck && tick.body(c.body).material.friction == Friction::Coulomb)
            sum.load.stiffen_across(o.tangential_stiffness, c.normal, c.centre);
    }

    void add_explained(const Contact& c, double reach)
    {
        Explained& e = sum.explained;
        const double slope = k_free_slope * tick.options.stiffness;
        e.force = std::max(e.force, slope * norm(c.motion));
        e.turn = std::max(e.turn, norm(c.motion) / k_free_turn);
        e.torque = std::max(e.torque,
                            slope * reach * (norm(c.motion) + (reach + norm(c.centre)) * turn_over(tick, c.body, points.pose)));
    }

    void add_to_report(const Contact& c, const ContactForce& force)
    {
        ZoneReport& report = tick.report;
        report.depth += force.depth * c.size;
        report.point += c.size * (points.pose.translation + force.lever + c.out * c.normal);
        report.potential += 0.5 * tick.options.stiffness * force.depth * force.depth;
        total += c.size;
    }

    Push finish()
    {
        ZoneReport& report = tick.report;
        if (total > 0) {
            report.depth = report.depth / total;
            report.point = report.point / total;
        }
        report.normal = normalized(sum.springs.force);
        return sum;
    }
};

}  // namespace

Push push(ZoneTick& tick, const PointsMotion& points)
{
    PushSum sum{tick, points};
    for (std::size_t s = 0; s < tick.bodies(); ++s) sum.add(s);
    return sum.finish();
}

Wrench blended(ZoneTick& tick, const TickForces& f)
{
    const ZoneOptions& o = tick.options;
    ZoneMemory& m = tick.memory;
    if (!f.touching || !(o.blend_time > 0)) {
        m.left = {};
    } else if (m.was_touching) {
        // By k_fade at most: an exponential share of a large jump would be a jump itself.
        const double size = std::max(norm(m.left.force), norm(m.left.torque) / k_fade_arm);
        const double slowest = size > 0 ? 1 - k_fade * tick.in.dt / size : 0;
        m.left = std::max(std::exp(-tick.in.dt / o.blend_time), slowest) * m.left;
        const Wrench change = f.springs + -1. * m.springs_before;
        const double before = norm(m.springs_before.force), now = norm(f.springs.force), grown = now - before;
        const double across = std::sqrt(std::max(norm_sq(change.force) - grown * grown, 0.));
        const double jump = std::max({share_beyond(norm(change.force), f.explained.force),
                                      share_beyond(across, std::max(before, now) * f.explained.turn),
                                      share_beyond(norm(change.torque), f.explained.torque)});
        if (jump > 0) m.left = m.left + -jump * (f.whole + -1. * m.whole_before);
        if (norm(m.left.force) > 1e-6 * norm(f.springs.force)) tick.report.status |= k_step_blended;
    }
    m.springs_before = f.springs;
    m.whole_before = f.whole;
    m.was_touching = f.touching;
    return f.whole + m.left;
}

void add_blend_reaction(ZoneTick& tick, Vec3d centre)
{
    double total = 0;
    for (const TouchMemory& t : tick.touches) total += t.spring;
    if (!(total > 0)) return;
    for (std::size_t s = 0; s < tick.bodies(); ++s)
        tick.add_reaction(s, tick.touches[s].spring / total * tick.memory.left, centre);
}

}  // namespace sqmap::haptic
