// Mode::Proxy. Ruspini, Kolarov, Khatib, "The haptic display of complex graphical environments", SIGGRAPH 1997; Zilles,
// Salisbury, "A constraint-based god-object method for haptic display", IROS 1995.
#include "contact_force.h"
#include "push.h"
#include "sqmap/math/friction.h"

namespace sqmap::haptic {

namespace {

constexpr int k_rounds = 4, k_projections = 8;
constexpr double k_slope = 1;  ///< the force may change by this times stiffness times motion without being a jump
/// m: the proxy rests at least this deep, and so stays in contact; a patch or a ball may rest deeper.
constexpr double k_min_sink = 1e-5;
constexpr double k_far_side = -0.5;  ///< cosine between outward directions
constexpr double k_ball_sink = 0.2;  ///< of its radius
constexpr double k_steep = 0.3;      ///< cosine between a plane's normal and the side that the proxy keeps to
constexpr double k_let_in = 1e-4;    ///< m per round
constexpr double k_step = 0.002;     ///< m per round, so that the proxy passes through nothing thicker

/// A spring's pull, N, at a point of the surface.
struct Pull {
    Vec3d point{}, normal{}, force{};  ///< world
};

/// A pull with the body's relief taken off.
Vec3d carved_pull(const TouchedBody& body, const Pull& pull, double stiffness)
{
    const double depth = dot(pull.force, pull.normal) / stiffness;
    if (body.material.texture == nullptr || !(depth > 0)) return pull.force;
    const Vec3d n = transpose_mul(body.pose.rotation, pull.normal);
    const Carved c = carved(relief_at(*body.material.texture, apply_inverse(body.pose, pull.point), n), depth, n);
    return pull.force + stiffness * (c.depth * (body.pose.rotation * c.normal) - depth * pull.normal);
}

/// One tick of a proxy, which goes to the device as far as the surfaces let it.
class Proxy {
public:
    explicit Proxy(ZoneTick& tick) : tick_(tick), goal_(tick.device().translation)
    {
        const ZoneOptions& o = tick.options;
        const double depth = ball_ ? std::min(o.proxy_depth, k_ball_sink * o.smoothing.radius) : o.proxy_depth;
        sink_ = std::max(rests_ ? depth : 0., k_min_sink);
    }

    /// Puts it where it starts: at the device at first, later carried along by the surface that it lies on.
    void begin();
    /// Moves it towards the device, in a few rounds of plane after plane.
    void advance();
    /// Finds the bodies that it touches and the one on which it slips.
    void settle();
    /// The wrench on the hand, and the report.
    [[nodiscard]] Wrench pull();

private:
    /// A position held back by friction, and the body on which it slips (bodies(): none).
    struct Held {
        Vec3d position{};
        std::size_t slipping = 0;
    };
    [[nodiscard]] bool device_is_free();
    [[nodiscard]] Vec3d plane_normal(std::size_t s) const
    {
        return tick_.body(s).pose.rotation * tick_.touches[s].planes[0].normal;
    }
    [[nodiscard]] Vec3d plane_point(std::size_t s, Vec3d at) const
    {
        return apply_inverse(tick_.body(s).pose, at + body_.rotation * tick_.touches[s].planes[0].probe);
    }
    [[nodiscard]] Vec3d outward() const;
    void turn_side();
    [[nodiscard]] Vec3d out_of(Vec3d normal, double below) const;
    [[nodiscard]] Vec3d sunk(std::size_t s, Vec3d at) const;
    [[nodiscard]] double load_at(Vec3d at, Vec3d normal) const;
    [[nodiscard]] Held held_back(Vec3d at) const;
    [[nodiscard]] Vec3d nearest_allowed() const;
    void touch(std::size_t s);
    void pull_of(std::size_t s);

    ZoneTick& tick_;
    Pose& body_ = tick_.memory.body;
    Vec3d goal_;
    // A tool of many points that rested on its deepest one would change that point, and with it the lever, at every step; so
    // would a ball on facets.
    bool rests_ = tick_.options.averaging != Averaging::Stencil, ball_ = tick_.options.averaging == Averaging::Ball;
    double sink_ = 0;
    double motion_ = 0;  ///< m, of device and surface in this tick
    Vec3d before_{};     ///< its position when it set out

    // Sums of pull().
    double load_ = 0, share_ = 0;  ///< m; number of bodies that bear it
    Vec3d held_{}, damping_{}, lever_{};
    Wrench springs_{}, whole_{};
};

/// Leaves the report unchanged.
bool Proxy::device_is_free()
{
    const ZoneReport kept = tick_.report;
    bool touches = false;
    for (std::size_t s = 0; s < tick_.bodies(); ++s)
        touches = touches || contact_force(tick_, {s, tick_.device()}).force.exact > 0;
    tick_.report = kept;
    return !touches;
}

void Proxy::begin()
{
    ZoneMemory& m = tick_.memory;
    if (!m.has_body) {
        body_ = tick_.device();
        m.inside = true;
    }
    m.has_body = true;
    if (m.inside && !tick_.in.degraded && device_is_free()) {
        // A proxy that began inside may have come out anywhere: it moves to the device as soon as the device is free.
        m.inside = false;
        body_ = tick_.device();
        for (TouchMemory& t : tick_.touches) t.plane_count = 0;
    }
    body_.rotation = tick_.device().rotation;
    // A surface that moves carries along what lies on it.
    motion_ = m.track.step();
    for (std::size_t s = 0; s < tick_.bodies(); ++s) {
        const TouchMemory& t = tick_.touches[s];
        if (!t.touching || !t.known) continue;
        const Vec3d still = body_.translation;
        body_.translation = apply(tick_.body(s).pose, apply_inverse(t.body_before, still));
        motion_ += norm(body_.translation - still);
        tick_.memory.side = tick_.body(s).pose.rotation * transpose_mul(t.body_before.rotation, tick_.memory.side);
        break;
    }
    for (TouchMemory& t : tick_.touches)
        if (t.plane_count == 0) t.sink = sink_;
    before_ = body_.translation;
    turn_side();
}

/// The side that the proxy keeps to follows the surface where the device moves over it, not where it only presses.
void Proxy::turn_side()
{
    Vec3d& side = tick_.memory.side;
    if (const Vec3d normal = outward(); !(tick_.options.side_path > 0) || norm_sq(normal) == 0) {
        side = {};
    } else if (norm_sq(side) == 0) {
        side = normal;
    } else {
        const Vec3d moved = tick_.memory.track.shift();
        const double across = norm(moved - dot(moved, side) * side);
        side = normalized(normal + std::exp(-across / tick_.options.side_path) * (side - normal));
    }
}

/// The shift from `below` metres below a plane up to it: along the side that the proxy keeps to, unless the plane is too steep.
Vec3d Proxy::out_of(Vec3d normal, double below) const
{
    const double slope = dot(tick_.memory.side, normal);
    return slope > k_steep ? below / slope * tick_.memory.side : below * normal;
}

/// Unit direction out of all bodies that it lies on.
Vec3d Proxy::outward() const
{
    Vec3d normal{};
    for (std::size_t s = 0; s < tick_.bodies(); ++s)
        if (tick_.touches[s].plane_count > 0) normal += plane_normal(s);
    return normalized(normal);
}

/// How deep it lies in body s, along its normal.
Vec3d Proxy::sunk(std::size_t s, Vec3d at) const
{
    const TouchMemory& t = tick_.touches[s];
    if (t.plane_count == 0 || !rests_) return {};
    const double depth = std::clamp(t.sink - dot(plane_point(s, at) - t.planes[0].point, t.planes[0].normal), 0., t.sink);
    return depth * plane_normal(s);
}

/// m along the normal: how far the device is behind it, and how deep it lies.
double Proxy::load_at(Vec3d at, Vec3d normal) const
{
    double load = dot(at - goal_, normal);
    for (std::size_t s = 0; s < tick_.bodies(); ++s) load += dot(sunk(s, at), normal);
    return load;
}

// Friction as a cone about the normal through the device. Every round applies it: else the proxy would seek its rest at a
// position that it never reaches.
Proxy::Held Proxy::held_back(Vec3d at) const
{
    const Vec3d normal = outward();
    const double load = load_at(at, normal);
    Vec3d back = before_ - at;
    back -= dot(back, normal) * normal;
    const double length = norm(back);
    for (std::size_t s = 0; s < tick_.bodies(); ++s) {
        const TouchMemory& t = tick_.touches[s];
        const Material& material = tick_.body(s).material;
        if (t.plane_count == 0 || !(load > 0) || !t.touching || material.friction != Friction::Coulomb) continue;
        const bool slips = length > (t.stuck ? material.mu_static : material.mu_dynamic) * load;
        return {at + (slips ? material.mu_dynamic * load / length : 1.) * back, slips ? s : tick_.bodies()};
    }
    return {at, tick_.bodies()};
}

/// The nearest position to the goal that no plane forbids: each plane in turn, a few times over.
Vec3d Proxy::nearest_allowed() const
{
    Vec3d p = goal_;
    for (int round = 0; round < k_projections; ++round)
        for (std::size_t s = 0; s < tick_.bodies(); ++s) {
            const TouchMemory& t = tick_.touches[s];
            if (t.plane_count == 0) continue;
            const double below = dot(t.planes[0].point - plane_point(s, p), t.planes[0].normal);
            if (below > 0) p += out_of(plane_normal(s), below);
        }
    return p;
}

/// Renews the plane of body s from the contact where the proxy is, and moves the proxy out to it.
void Proxy::touch(std::size_t s)
{
    TouchMemory& t = tick_.touches[s];
    const ContactForce contact = contact_force(tick_, {s, body_}).force;
    if (contact.exact > 0 && norm_sq(contact.force) > 0) {
        const Vec3d out_of_it = normalized(contact.force);
        if (tick_.options.averaging == Averaging::Patch && t.plane_count > 0 && t.sink > 2 * k_min_sink &&
            dot(out_of_it, plane_normal(s)) < k_far_side) {
            // So deep, it touches the far side of something thin: it rests half as deep until it leaves.
            t.sink *= 0.5;
            t.planes[0].point += t.sink * t.planes[0].normal;
            return;
        }
        const double out = (rests_ ? contact.depth : contact.exact) - t.sink;
        remember_plane(tick_, {s, body_}, contact, out);
        body_.translation += std::max(out, 0.) * out_of_it;
        t.let_in = 0;
    } else if (t.plane_count > 0) {
        // The surface has curved away from its plane, or the smoothed direction led a hair past it: the plane recedes until
        // there is contact again. Without one the proxy would fall, and the force with it.
        t.planes[0].point -= k_let_in * t.planes[0].normal;
        t.let_in += k_let_in;
        if (t.let_in > k_step) t.plane_count = 0;
    }
}

void Proxy::advance()
{
    for (int round = 0; round < k_rounds; ++round) {
        const Vec3d path = held_back(nearest_allowed()).position - body_.translation;
        const double length = norm(path);
        if (round > 0 && length < k_min_sink) break;
        body_.translation += (length > k_step ? k_step / length : 1.) * path;
        if (tick_.in.degraded) break;
        tick_.report.contacts = 0;
        for (std::size_t s = 0; s < tick_.bodies(); ++s) touch(s);
    }
}

void Proxy::settle()
{
    load_ = load_at(body_.translation, outward());
    const std::size_t slipping = held_back(nearest_allowed()).slipping;
    for (std::size_t s = 0; s < tick_.bodies(); ++s) {
        TouchMemory& t = tick_.touches[s];
        t.touching = t.plane_count > 0 && load_ > 0;
        t.stuck = s != slipping || !t.touching;
        if (!t.stuck) tick_.report.status |= k_step_slipping;
    }
    tick_.report.body = body_;
}

/// Adds the pull of body s.
void Proxy::pull_of(std::size_t s)
{
    TouchMemory& t = tick_.touches[s];
    const ZoneOptions& o = tick_.options;
    const TouchedBody& body = tick_.body(s);
    t.spring = 0;
    if (!t.touching) return;
    Vec3d arm = body_.rotation * t.planes[0].probe;
    const Vec3d normal = plane_normal(s);
    if (ball_) arm -= (o.smoothing.radius - norm(sunk(s, body_.translation))) * normal;  // the point that rubs
    Vec3d pull = o.stiffness * (held_ / share_ + sunk(s, body_.translation));
    if (o.averaging != Averaging::Patch) pull = carved_pull(body, {body_.translation + arm, normal, pull}, o.stiffness);
    Vec3d force = pull + damping_ / share_;
    if (const Material& material = body.material; material.friction == Friction::Paper) {
        const Vec3d moved = tick_.in.dt * tick_.velocity_over(s, tick_.memory.device_twist, tick_.device(), {});
        force += printed_friction({material.f_c, material.k_f}, load_, moved - dot(moved, normal) * normal);
    }
    lever_ += arm / share_;
    t.spring = norm(pull);
    springs_ = springs_ + Wrench{pull, cross(arm, pull)};
    const Wrench w{force, cross(arm, force)};
    whole_ = whole_ + w;
    tick_.add_reaction(s, w, body_.translation);
}

Wrench Proxy::pull()
{
    const ZoneOptions& o = tick_.options;
    ZoneReport& report = tick_.report;
    if (!(load_ > 0)) {
        (void)blended(tick_, {});
        return {};
    }
    const Vec3d normal = outward();
    report.status |= k_step_contact;
    report.normal = normal;
    held_ = body_.translation - goal_;
    Vec3d stretch = held_;
    for (std::size_t s = 0; s < tick_.bodies(); ++s) stretch += sunk(s, body_.translation);
    report.depth = norm(stretch);
    report.potential = 0.5 * o.stiffness * report.depth * report.depth;
    const double approach = -dot(tick_.memory.device_twist.linear, normal);
    const double damped = o.damping * approach * std::min(1., load_ / k_damping_depth);
    damping_ = std::max(damped, -o.stiffness * load_) * normal;
    for (const TouchMemory& t : tick_.touches) share_ += t.touching ? 1 : 0;
    for (std::size_t s = 0; s < tick_.bodies(); ++s) pull_of(s);
    report.point = body_.translation + lever_;
    // Between walls it may lie on the one or the other, and off an edge it drops, with its lever: such jumps are blended.
    const double slope = k_slope * o.stiffness, arm = norm(lever_);
    const Explained explained{slope * motion_, slope * arm * (motion_ + arm * tick_.memory.track.turn()), motion_ / k_free_turn};
    const Wrench w = blended(tick_, {true, springs_, whole_, explained});
    add_blend_reaction(tick_, body_.translation);
    return tick_.with_torque_share(w);
}

}  // namespace

Wrench proxy(ZoneTick& tick)
{
    Proxy proxy(tick);
    proxy.begin();
    proxy.advance();
    proxy.settle();
    return proxy.pull();
}

}  // namespace sqmap::haptic
