// The nine steps of the safety filter. The passivity step is the time-domain observer and controller of Hannaford and Ryu
// (2002), with the energy of a held force over the motion that it was held for (Ryu, Kim and Hannaford 2004). A test removes the
// lines of tick() that name a step, one at a time, and expects that step's test to fail: keep them one a line.
#include "sqmap/haptic/safety.h"

#include "haptic/sane.h"
#include "math/trigonometry.h"
#include "sqmap/math/rotation.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace sqmap::haptic {

namespace {

constexpr double k_rotation = 1e-3;    // how far a rotation's rows may be from orthonormal: seven digits are
constexpr double k_smoothing = 0.003;  // s, of the velocity
constexpr double k_glitch = 0.02;      // s after motion above the top speed during which the velocity is not trusted
constexpr double k_store = 0.2;        // J, maximum that a zone may store: 2 N over 10 cm
constexpr double k_debt = 0.02;        // J, maximum that it may owe: more takes longer to be forgiven
constexpr double k_ramp_store = 0.05;  // J, maximum that stiffening may give in a contact: half of 2 N over 5 cm
constexpr double k_slack = 1.25;       // of its springs' energy: a delay and an encoder may hide the excess
constexpr double k_damping = 5;        // N s/m, maximum that the passivity step adds
constexpr double k_min_valve = 1e-4;   // J: the valve closes over this much if the margin is less
constexpr double k_forgive = 20, k_forgive_free = 1;  // s, time constants of forgiving debt: in contact, out of it
constexpr double k_left = 0.25;                       // s without force: out of contact
constexpr double k_fast_damping = 1;                  // N s/m, above the top speed
constexpr double k_arm = 0.05;                        // m: a damper of b turns with b arm^2
constexpr double k_longest_tick = k_stale_zero;       // s: a longer tick gives no force
constexpr double k_bad_window = 0.1;                  // s
constexpr double k_duty_slack = 0.01;                 // share lost to whole ticks
constexpr double k_grain = 1e-6;                      // s, a clock's rounding: zero comes this much early rather than late
constexpr double k_finest_rate_share = 0.5;  // a sample is never taken to be younger than this share of the sample period

bool is_zero(const Wrench& w) { return w == Wrench{}; }
double power(const Wrench& w, const Vec3d& velocity, const Vec3d& turn) { return dot(w.force, velocity) + dot(w.torque, turn); }

/// v no longer than max_length; zero for a v that cannot be measured.
Vec3d shortened(const Vec3d& v, double max_length)
{
    const double length = norm(v);
    if (length <= max_length) return v;
    return length <= k_absurd * 2 ? std::max(max_length, 0.) / length * v : Vec3d{};
}

/// The wrench, force and torque shortened by one factor until both limits hold: the line of action and the ratio of torque to
/// force stay as commanded, so a tool that is pressed harder at a limit does not seem to be pushed elsewhere. Zero for a wrench
/// that cannot be measured.
Wrench within(const Wrench& w, double max_force, double max_torque)
{
    const double force = norm(w.force), torque = norm(w.torque);
    if (force <= max_force && torque <= max_torque) return w;
    if (!(force <= k_absurd * 2 && torque <= k_absurd * 2)) return {};
    const double share = std::min(force > max_force ? max_force / force : 1, torque > max_torque ? max_torque / torque : 1);
    return std::max(share, 0.) * w;
}

/// The rotation vector from a to b: unit axis times angle, the world's axes.
Vec3d turn_between(const Mat3d& a, const Mat3d& b)
{
    const Mat3d d = b * transpose(a);
    const Vec3d s = 0.5 * Vec3d{d.row[2].y - d.row[1].z, d.row[0].z - d.row[2].x, d.row[1].x - d.row[0].y};
    const double sine = norm(s), cosine = 0.5 * (d.row[0].x + d.row[1].y + d.row[2].z - 1);
    const double angle = angle_of(sine, cosine);
    if (sine > 1e-9) return angle / sine * s;
    return cosine > 0 ? s : Vec3d{angle, 0, 0};  // half a turn: its axis does not matter: no hand turns that far in a tick
}

/// As much of a vector as lies along another one: it shrinks at once, and never grows.
Vec3d shrunk(const Vec3d& from, const Vec3d& to)
{
    const double length_sq = norm_sq(from);
    return length_sq > 0 ? std::clamp(dot(from, to) / length_sq, 0., 1.) * from : Vec3d{};
}

}  // namespace

const char* describe(SetupStatus status) noexcept
{
    static constexpr const char* k_names[] = {
        "the limits can be held",
        "a limit or a number of the device is negative or not finite",
        "a limit must be more than zero",
        "a limit is more than the device holds",
        "slew must be in (0, 1000] N/s, the energy margin in [0, 0.01] J, the softest spring at least 20 N/m",
        "a tick must be between 0.1 and 20 ms"};
    static_assert(std::size(k_names) == static_cast<std::size_t>(SetupStatus::BadPeriod) + 1, "in the order of the enumeration");
    const auto i = static_cast<std::size_t>(status);
    return i < std::size(k_names) ? k_names[i] : "unknown status";
}

SafetyFilter::SafetyFilter(const DeviceLimits& device, const SafetyOptions& options) noexcept : device_(device)
{
    const double numbers[] = {device.max_force, device.max_torque,       device.continuous_force,
                              device.damping,   device.coulomb_friction, device.resolution,
                              device.delay,     device.period,           device.sample_period};
    const double force = options.force_limit.value_or(1), torque = options.torque_limit.value_or(1);
    const auto usable = [](double x) { return x >= 0 && x <= k_absurd; };
    const double max_force = device.max_force > 0 ? device.max_force : k_unknown_force,
                 max_torque = device.max_torque > 0 ? device.max_torque : k_unknown_torque;
    if (!std::all_of(std::begin(numbers), std::end(numbers), usable) || !sane(force) || !sane(torque))
        setup_status_ = SetupStatus::NotFinite;
    else if (force <= 0 || torque <= 0)
        setup_status_ = SetupStatus::LimitNotPositive;
    else if ((options.force_limit && force > max_force) || (options.torque_limit && torque > max_torque))
        setup_status_ = SetupStatus::LimitAboveDevice;
    else if (!(options.slew > 0 && options.slew <= 1000 && options.energy_margin >= 0 && options.energy_margin <= 0.01 &&
               options.softest >= 20 && options.softest <= 1e6))
        setup_status_ = SetupStatus::BadOption;
    else if (!(device.period >= 1e-4 && device.period <= 0.02))
        setup_status_ = SetupStatus::BadPeriod;
    if (setup_status_ != SetupStatus::Ok) {
        faults_ = k_fault_setup;
        return;
    }
    force_limit_ = options.force_limit.value_or(std::min(k_default_force, max_force));
    torque_limit_ = options.torque_limit.value_or(std::min(k_default_torque, max_torque));
    const double continuous = device.continuous_force > 0 ? device.continuous_force : 0.5 * force_limit_;
    per_heat_force_ = 1 / (continuous * continuous);
    per_heat_torque_ = per_heat_force_ * (force_limit_ / torque_limit_) * (force_limit_ / torque_limit_);
    // Force alone may begin at its limit; both at their limits have twice the heat.
    const double heat = force_limit_ * force_limit_ * per_heat_force_;
    peak_ = std::max(heat, std::min(2 * heat, 2.));
    if (peak_ > 1) duty_time_ = std::min(k_duty_window, (1 - k_duty_slack) * 2 * k_duty_window * peak_ / (peak_ * peak_ - 1));
    force_slew_ = options.slew;
    torque_slew_ = options.slew * torque_limit_ / force_limit_;
    margin_ = options.energy_margin;
    softest_ = options.softest;
    dead_man_ = options.dead_man;
    // A slow device is always late between its samples, so it holds longer; all forces end at k_stale_zero.
    hold_ = std::clamp(2 * device.sample_period, k_stale_hold, 0.75 * k_stale_zero);
    delay_ticks_ = std::min(static_cast<std::size_t>(device.delay / device.period + 0.5), k_history - 2);
}

/// State of one tick and the wrenches that the steps pass on.
struct SafetyFilter::Tick {
    std::size_t zones = 0;
    double dt = 0;         // s since the last tick
    double sample_dt = 0;  // s between the last two fresh samples
    double age = 0;        // s since the last sample
    double scale = 1;      // of every limit: falls while samples are late
    bool fresh = false;    // a new sample
    bool off = false;      // all zero
    std::uint32_t acted = 0;
    std::uint32_t waiting = 0;  // zones with a force commanded before they have been free
    std::array<Wrench, k_max_safe_zones> wrench{};
    std::array<double, k_max_safe_zones> share;             // of the limits: ramp, heat
    std::array<Vec3d, k_max_safe_zones> moved{}, turned{};  // since the last fresh sample
    std::array<double, k_max_safe_zones> speed{}, spin{};
    std::array<bool, k_max_safe_zones> jumped{};
    std::array<double, k_max_safe_zones> push{};       // N, of springs, though they cancel in the commanded wrench
    std::array<double, k_max_safe_zones> springs{};    // J, maximum that the springs behind the commanded wrench hold
    std::array<double, k_max_safe_zones> stiffened{};  // J that the ramp and the user add to them at rest
};

SafetyReport SafetyFilter::tick(const SafetyInput& in, std::span<Wrench> safe) noexcept
{
    Tick tick = begin(in, safe.size());
    finite(in, tick);  // step 1
    observe(in, tick);
    stale(in, tick);   // step 2
    engage(in, tick);  // step 3
    clamp(tick);       // step 4
    slew(tick);        // step 5
    speed(tick);       // step 6
    passivity(tick);   // step 7
    duty(tick);        // step 8
    clamp_last(tick);  // step 9
    return finish(tick, safe);
}

void SafetyFilter::disengage() noexcept
{
    for (Zone& zone : zones_) {
        zone.phase = Phase::Waiting;
        zone.calm = 0;
        zone.ramp = 0;
    }
}

void SafetyFilter::latch(std::uint32_t fault) noexcept
{
    if ((faults_ & fault) == 0) ++counters_.faults;
    faults_ |= fault;
}

double SafetyFilter::stored(const Wrench& commanded, double share) const noexcept
{
    const double k = share * softest_;
    return spring_energy(norm(commanded.force), force_limit_, k) +
           spring_energy(norm(commanded.torque), torque_limit_, k * k_lever * k_lever);
}

double SafetyFilter::heat(const Wrench& w) const noexcept
{
    return per_heat_force_ * norm_sq(w.force) + per_heat_torque_ * norm_sq(w.torque);
}

const Wrench& SafetyFilter::sent_before(const Zone& zone, std::size_t ticks) const noexcept
{
    return zone.sent[(ticks_ + k_history - ticks) % k_history];
}

Wrench SafetyFilter::slewed(const Wrench& from, const Wrench& to, double dt) const noexcept
{
    // A late tick may not step further than one in time.
    const double step = std::min(dt, device_.period);
    const Wrench kept{shrunk(from.force, to.force), shrunk(from.torque, to.torque)};
    const Wrench rest{to.force - kept.force, to.torque - kept.torque};
    const Wrench grown = within(rest, force_slew_ * step, torque_slew_ * step);
    return grown == rest ? to : kept + grown;
}

/// Time, freshness, and what the user and the device allow.
SafetyFilter::Tick SafetyFilter::begin(const SafetyInput& in, std::size_t capacity) noexcept
{
    Tick tick;
    ++ticks_;
    ++counters_.ticks;
    tick.zones = std::min({in.poses.size(), in.commanded.size(), capacity, k_max_safe_zones});
    tick.share.fill(1);
    for (std::size_t z = 0; z < tick.zones; ++z) tick.wrench[z] = in.commanded[z];
    for (std::size_t z = 0; z < std::min(tick.zones, in.pushes.size()); ++z) tick.push[z] = in.pushes[z];
    for (std::size_t z = 0; z < std::min(tick.zones, in.stiffened.size()); ++z) tick.stiffened[z] = in.stiffened[z];
    tick.dt = begun_ && sane(in.time) ? in.time - time_ : device_.period;
    tick.fresh = in.connected && in.sequence != 0 && (!sampled_ || in.sequence != sequence_);
    if (in.resume && setup_status_ == SetupStatus::Ok && faults_ != 0) {
        faults_ = 0;
        bad_count_ = 0;
        for (Zone& zone : zones_) zone.fast = 0;
        disengage();
    }
    if (in.stop) latch(k_fault_stop);
    if (in.restart) disengage();
    if (faults_ != 0 || !in.connected || (in.sequence == 0 && !sampled_) || (dead_man_ && !in.held)) tick.off = true;
    return tick;
}

/// Step 1. A number that is not finite or absurd, a matrix that is no rotation, or a clock that runs back: nothing goes out in
/// this tick; three such ticks within 100 ms are a fault.
void SafetyFilter::finite(const SafetyInput& in, Tick& tick) noexcept
{
    bool ok = sane(in.time) && sane(in.sample_time) && tick.dt >= 0;
    for (std::size_t z = 0; z < tick.zones; ++z)
        ok = ok && sane(in.poses[z]) && is_rotation(in.poses[z].rotation, k_rotation) && sane(in.commanded[z]);
    for (std::size_t z = 0; z < std::min(tick.zones, in.twists.size()); ++z) ok = ok && sane(in.twists[z]);
    for (std::size_t z = 0; z < std::min(tick.zones, in.pushes.size()); ++z) ok = ok && sane(in.pushes[z]);
    for (std::size_t z = 0; z < std::min(tick.zones, in.stiffened.size()); ++z) ok = ok && sane(in.stiffened[z]);
    if (ok) return;
    tick.off = true;
    tick.acted |= k_acted_finite;
    tick.fresh = false;  // nothing of this sample is remembered
    tick.wrench = {};
    tick.dt = std::max(tick.dt, 0.);
    ++counters_.not_finite;
    // One bad sample of a slow device shows in several ticks and counts once.
    if (in.sequence != 0 && in.sequence == bad_sequence_) return;
    bad_sequence_ = in.sequence;
    bad_ = {sane(in.time) ? in.time : time_, bad_[0], bad_[1]};
    bad_count_ = std::min(bad_count_ + 1, bad_.size());
    if (bad_count_ == bad_.size() && bad_[0] - bad_[2] <= k_bad_window) latch(k_fault_not_finite);
}

/// How every zone has moved since its last sample.
void SafetyFilter::observe(const SafetyInput& in, Tick& tick) noexcept
{
    if (sane(in.time)) {
        begun_ = true;
        time_ = std::max(time_, in.time);
    }
    if (tick.fresh) {
        const double stamp = std::min(in.time, in.sample_time);
        tick.sample_dt = std::max(stamp - stamp_, k_finest_rate_share * device_.sample_period);
        sequence_ = in.sequence;
        sampled_at_ = in.time;
        for (std::size_t z = 0; z < tick.zones; ++z) {
            Zone& zone = zones_[z];
            const Pose& pose = in.poses[z];
            const Vec3d moved = pose.translation - zone.pose.translation,
                        turned = turn_between(zone.pose.rotation, pose.rotation);
            const bool jumped = !zone.known || norm(moved) > k_teleport || norm(turned) > k_teleport_turn;
            tick.jumped[z] = zone.known && jumped;
            zone.pose = pose;
            zone.known = true;
            if (jumped) {
                zone.velocity = zone.turn = {};
                continue;
            }
            const double blend = tick.sample_dt / (k_smoothing + tick.sample_dt);
            tick.moved[z] = moved;
            tick.turned[z] = turned;
            tick.speed[z] = norm(moved) / tick.sample_dt;
            tick.spin[z] = norm(turned) / tick.sample_dt;
            // A glitch is faster than any motion: the velocity for the brakes is cut, so that they do not kick.
            zone.velocity += blend * (shortened(moved / tick.sample_dt, k_top_speed) - zone.velocity);
            zone.turn += blend * (shortened(turned / tick.sample_dt, k_top_turn) - zone.turn);
            if (z < in.twists.size()) {
                tick.speed[z] = std::max(tick.speed[z], norm(in.twists[z].linear));
                tick.spin[z] = std::max(tick.spin[z], norm(in.twists[z].angular));
            }
        }
        stamp_ = sampled_ ? std::max(stamp_, stamp) : stamp;
        sampled_ = true;
    }
    if (sampled_) tick.age = time_ - std::min(stamp_, sampled_at_);
}

/// Step 2. Without a fresh sample the wrench is held, falls from 5 ms on and is zero 20 ms after the last sample, whose time a
/// slow device's own clock may put before its arrival. A tick that comes 20 ms after the one before gives zero too.
void SafetyFilter::stale(const SafetyInput& in, Tick& tick) noexcept
{
    if (!sampled_) return;
    for (std::size_t z = 0; z < tick.zones && !tick.off; ++z) {
        if (tick.fresh)
            zones_[z].held = in.commanded[z];
        else
            tick.wrench[z] = zones_[z].held;
    }
    const double late = std::max(tick.age, tick.dt);
    if (!tick.fresh) ++counters_.held;
    tick.scale = late >= k_stale_zero - k_grain ? 0 : std::clamp((k_stale_zero - tick.age) / (k_stale_zero - hold_), 0., 1.);
    if (tick.scale >= 1) return;
    tick.acted |= k_acted_stale;
    ++counters_.stale;
    if (late > k_stale_fault && in.connected) latch(k_fault_stale);  // a device that is gone may come back and engages anew
    if (tick.scale <= 0) {
        tick.off = true;
        disengage();
    }
    for (std::size_t z = 0; z < tick.zones; ++z) tick.wrench[z] = tick.scale * tick.wrench[z];
}

/// Step 3. Nothing goes out until next to nothing is commanded, then half a second's ramp; again after every jump.
void SafetyFilter::engage(const SafetyInput&, Tick& tick) noexcept
{
    for (std::size_t z = 0; z < tick.zones; ++z) {
        Zone& zone = zones_[z];
        if (tick.jumped[z]) {
            zone.phase = Phase::Waiting;
            zone.calm = 0;
            zone.ramp = 0;
            ++counters_.teleports;
        }
        if (zone.phase == Phase::Waiting && !tick.off) {
            const bool calm = norm(tick.wrench[z].force) < k_engage_force &&
                              norm(tick.wrench[z].torque) < k_engage_force / k_default_force * torque_limit_;
            if (!calm) tick.waiting |= 1u << z, tick.acted |= k_acted_inside;
            if (tick.fresh) zone.calm = calm ? zone.calm + 1 : 0;
            if (zone.calm > k_engage_ticks) {
                zone.phase = Phase::Ramping;
                zone.ramp_store = k_ramp_store;
                ++counters_.engagements;
            }
        }
        if (zone.phase == Phase::Ramping && !tick.off) {
            const double before = zone.ramp;
            zone.ramp = std::min(zone.ramp + std::min(tick.dt, 2 * device_.period) / k_engage_ramp, 1.);
            tick.stiffened[z] += stored(zone.ramp * tick.wrench[z], zone.ramp) - stored(before * tick.wrench[z], before);
            if (zone.ramp >= 1) zone.phase = Phase::Engaged;
        }
        if (zone.phase == Phase::Engaged) continue;
        const double share = zone.phase == Phase::Waiting ? 0 : zone.ramp;
        tick.acted |= k_acted_engage;
        tick.share[z] = share;
        tick.wrench[z] = share * tick.wrench[z];
    }
}

/// Step 4. The limits. Force and torque shrink together.
void SafetyFilter::clamp(Tick& tick) noexcept
{
    bool acted = false;
    for (std::size_t z = 0; z < tick.zones; ++z) {
        const double share = tick.share[z];
        tick.springs[z] =
            std::max(stored(tick.wrench[z], share), spring_energy(share * tick.push[z], force_limit_, share * softest_));
        const Wrench w = within(tick.wrench[z], force_limit_, torque_limit_);
        acted = acted || !(w == tick.wrench[z]);
        tick.wrench[z] = w;
    }
    if (!acted) return;
    tick.acted |= k_acted_clamp;
    ++counters_.clamped;
}

/// Step 5. Growth is limited, a decrease towards zero never is.
void SafetyFilter::slew(Tick& tick) noexcept
{
    bool acted = false;
    for (std::size_t z = 0; z < tick.zones; ++z) {
        const Wrench w = slewed(sent_before(zones_[z], 1), tick.wrench[z], tick.dt);
        acted = acted || !(w == tick.wrench[z]);
        tick.wrench[z] = w;
    }
    if (!acted) return;
    tick.acted |= k_acted_slew;
    ++counters_.slewed;
}

/// Step 6. A hand or a robot that moves this fast is not touching anything on purpose: brake it, and if that does not help, stop.
void SafetyFilter::speed(Tick& tick) noexcept
{
    bool acted = false;
    for (std::size_t z = 0; z < tick.zones; ++z) {
        Zone& zone = zones_[z];
        if (tick.fresh) {
            const bool fast = tick.speed[z] > k_top_speed || tick.spin[z] > k_top_turn;
            zone.fast = fast ? zone.fast + tick.sample_dt : 0;
            zone.since_fast = fast ? 0 : std::min(zone.since_fast + tick.sample_dt, k_glitch);
        }
        if (zone.fast <= 0) continue;
        acted = true;
        const Wrench damper{-k_fast_damping * zone.velocity, -k_fast_damping * k_arm * k_arm * zone.turn};
        const Wrench brake = within(damper, force_limit_, torque_limit_);
        tick.wrench[z] = slewed(sent_before(zone, 1), brake, tick.dt);
        if (zone.fast > k_fast_fault) {
            latch(k_fault_fast);
            tick.off = true;
        }
    }
    if (!acted) return;
    tick.acted |= k_acted_speed;
    ++counters_.fast;
}

/// Step 7. The observer sums the work of the wrenches in effect over the measured motion, less the loss in the device's own
/// damping. The controller is a valve that closes as the excess grows to the margin once more, and a damper.
void SafetyFilter::passivity(Tick& tick) noexcept
{
    bool acted = false;
    for (std::size_t z = 0; z < tick.zones; ++z) {
        Zone& zone = zones_[z];
        const Wrench& then = sent_before(zone, 1 + delay_ticks_);
        zone.since = zone.since + then;
        ++zone.since_count;
        if (tick.fresh) {
            const Wrench mean = 1. / zone.since_count * zone.since;
            const double given = power(mean, tick.moved[z], tick.turned[z]);
            zone.energy =
                std::clamp(zone.energy + given - device_.damping * norm_sq(zone.velocity) * tick.sample_dt, -k_store, k_debt);
            zone.since = {};
            zone.since_count = 0;
        }
        Wrench& wrench = tick.wrench[z];
        // The account never holds more than the springs do, and nothing out of contact, so that energy lost to friction cannot
        // pay for energy from elsewhere.
        const double springs = std::max(tick.springs[z], stored(then, tick.share[z]));
        // A spring that the ramp or the user stiffens while it is pressed in pushes the hand out, and nobody's motion paid for
        // it.
        const double stiffened = std::clamp(tick.stiffened[z], 0., zone.ramp_store);
        zone.ramp_store -= stiffened;
        zone.energy -= stiffened;
        // A motion there and back within two samples is a glitch: the second sample returns the energy that the first one took.
        if (zone.since_fast >= k_glitch) zone.energy = std::max(zone.energy, -k_slack * springs);
        const bool free = is_zero(wrench) && is_zero(then);
        // Debt is forgiven slowly, in contact down to the margin: else a zone in debt would stay dead for ever. A touch that
        // comes and goes many times a second is one touch: else each would be given the margin anew.
        zone.free_for = free ? zone.free_for + tick.dt : 0;
        const bool left = zone.free_for > k_left;
        if (left && zone.phase == Phase::Engaged) zone.ramp_store = k_ramp_store;
        const double kept = left ? 0 : margin_, rate = tick.dt / (left ? k_forgive_free : k_forgive);
        if (zone.energy > kept) zone.energy -= std::min(rate, 1.) * (zone.energy - kept);
        const double excess = zone.energy - margin_;
        if (!(excess > 0) || is_zero(wrench)) continue;
        acted = true;
        // The valve follows energy, which is never late, not velocity, which is; a damper of half the device's own cannot
        // make the two together active, however late it is.
        wrench = std::clamp(1 - excess / std::max(margin_, k_min_valve), 0., 1.) * wrench;
        wrench.force -= std::min(k_damping, 0.5 * device_.damping) * zone.velocity;
        // A glitch gives a false velocity: the slew limit keeps the damper from turning it into a blow.
        if (zone.since_fast < k_glitch) wrench = slewed(sent_before(zone, 1), wrench, tick.dt);
    }
    if (!acted) return;
    tick.acted |= k_acted_passivity;
    ++counters_.passivity;
}

/// Step 8. The motors' heat. A first-order thermal model keeps spare, the share of the window's heat that is left. The largest
/// force, squared and over the continuous force's square, is 1 - spare + peak spare^3. So it falls smoothly from the limits to
/// just below the continuous force and from there rises to it. With duty_time at most 2 window peak / (peak^2 - 1) no window's
/// mean square passes the continuous force's: docs/algorithms/safety.md.
void SafetyFilter::duty(Tick& tick) noexcept
{
    if (!(peak_ > 1)) return;
    const double dt = std::clamp(tick.dt, device_.period, k_longest_tick);
    bool acted = false;
    for (std::size_t z = 0; z < tick.zones; ++z) {
        const double e = zones_[z].spare;
        const double max_heat = 1 - e + std::min(peak_ * e * e * e, e * duty_time_ / dt), commanded = heat(tick.wrench[z]);
        if (!(commanded > max_heat)) continue;
        acted = true;
        tick.wrench[z] = std::sqrt(max_heat / commanded) * tick.wrench[z];
    }
    if (!acted) return;
    tick.acted |= k_acted_duty;
    ++counters_.duty;
}

/// Step 9. Whatever the steps before did, no more than the limits goes out, less while engaging or while samples are late.
void SafetyFilter::clamp_last(Tick& tick) noexcept
{
    bool acted = false;
    for (std::size_t z = 0; z < tick.zones; ++z) {
        const double share = tick.scale * tick.share[z];
        Wrench w = within(tick.wrench[z], share * force_limit_, share * torque_limit_);
        if (!sane(w)) w = {};
        acted = acted || !(w == tick.wrench[z]);
        tick.wrench[z] = w;
    }
    if (!acted) return;
    tick.acted |= k_acted_last;
    ++counters_.last_clamped;
}

SafetyReport SafetyFilter::finish(Tick& tick, std::span<Wrench> safe) noexcept
{
    const bool off = tick.off || faults_ != 0;
    if (off) {
        tick.acted |= k_acted_off;
        ++counters_.off;
        // One tick that is not finite does not disengage the filter; every other cause does.
        if ((tick.acted & k_acted_finite) == 0 || faults_ != 0) disengage();
    }
    SafetyReport report{.acted = tick.acted,
                        .faults = faults_,
                        .engaged = !off && tick.zones > 0,
                        .age = tick.age,
                        .waiting = off ? 0 : tick.waiting};
    for (std::size_t z = 0; z < safe.size(); ++z) safe[z] = off || z >= tick.zones ? Wrench{} : tick.wrench[z];
    const double dt = std::clamp(tick.dt, device_.period, k_longest_tick);
    for (std::size_t z = 0; z < k_max_safe_zones; ++z) {
        Zone& zone = zones_[z];
        const Wrench w = z < safe.size() ? safe[z] : Wrench{};
        zone.sent[ticks_ % k_history] = w;
        if (z < tick.zones) report.engaged = report.engaged && zone.phase == Phase::Engaged;
        if (peak_ > 1) zone.spare = std::clamp(zone.spare + dt / duty_time_ * (1 - zone.spare - heat(w)), 0., 1.);
    }
    return report;
}

}  // namespace sqmap::haptic
