// One zone in one tick: its input, its memory from tick to tick, its report.
//
// The track: Janabi-Sharifi, Hayward, Chen, "Discrete-time adaptive windowing for velocity estimation", IEEE Trans. Control
// Systems Technology 8(6), 2000 (end-fit, first-order): a velocity over the longest past that it explains to within the encoder's
// step. At rest and in slow motion, where one step in one tick would be a jerk, that is long; in fast motion one tick.
#pragma once

#include "contact_sum.h"
#include "rigid_motion.h"
#include "sqmap/haptic/safety.h"
#include "sqmap/haptic/step.h"
#include "sqmap/query/contacts.h"

#include <optional>
#include <span>
#include <vector>

namespace sqmap::haptic {

/// The last poses of a device that reports no velocity. One thread.
class Track {
public:
    /// dt: s since the one before
    void add(const Pose& pose, double dt)
    {
        for (int i = k_max; i > 0; --i) past_[i] = past_[i - 1];
        for (int i = 1; i <= k_max; ++i) past_[i].age += dt;
        past_[0] = {pose, 0};
        count_ = std::min(count_ + 1, k_max + 1);
    }

    /// True if a pose is farther from the last one than any motion leads: by more than k_teleport or k_teleport_turn, and by more
    /// than the top speeds allow in dt, s.
    [[nodiscard]] bool jumps(const Pose& pose, double dt) const
    {
        if (count_ == 0) return false;
        const Pose& before = past_[0].pose;
        return norm(pose.translation - before.translation) > std::max(k_teleport, k_top_speed * dt) ||
               norm(rotation_vector(pose.rotation * transpose(before.rotation))) > std::max(k_teleport_turn, k_top_turn * dt);
    }

    /// m since the last tick
    [[nodiscard]] Vec3d shift() const { return count_ > 1 ? past_[0].pose.translation - past_[1].pose.translation : Vec3d{}; }
    [[nodiscard]] double step() const { return norm(shift()); }

    /// rad since the last tick
    [[nodiscard]] double turn() const
    {
        return count_ > 1 ? norm(rotation_vector(past_[0].pose.rotation * transpose(past_[1].pose.rotation))) : 0;
    }

    /// resolution: m, of the encoder; 0: the difference of the last two poses. A turn counts at k_arm.
    [[nodiscard]] Twist twist(double resolution) const
    {
        Vec3d shift[k_max + 1], turn[k_max + 1];
        Twist twist;
        bool moves = true, turns = true;
        for (int n = 1; n < count_ && (moves || turns); ++n) {
            const Past& then = past_[n];
            shift[n] = past_[0].pose.translation - then.pose.translation;
            turn[n] = rotation_vector(past_[0].pose.rotation * transpose(then.pose.rotation));
            moves = moves && (n == 1 || fits(shift, n, resolution));
            turns = turns && (n == 1 || fits(turn, n, resolution / k_arm));
            if (moves) twist.linear = shift[n] / then.age;
            if (turns) twist.angular = turn[n] / then.age;
            if (!(resolution > 0)) break;
        }
        return twist;
    }

private:
    static constexpr int k_max = 16;       // ticks
    static constexpr double k_arm = 0.02;  // m

    struct Past {
        Pose pose{};
        double age = 0;
    };

    /// True if all poses since n ticks ago lie within a step of the straight line from then to now, along every axis.
    [[nodiscard]] bool fits(const Vec3d (&shift)[k_max + 1], int n, double step) const
    {
        for (int i = 1; i < n; ++i) {
            const Vec3d off = shift[i] - (past_[i].age / past_[n].age) * shift[n];
            // 0.1 % more, since the differences are whole steps themselves.
            for (int k = 0; k < 3; ++k)
                if (!(std::fabs(off[k]) <= 1.001 * step)) return false;
        }
        return true;
    }

    Past past_[k_max + 1];
    int count_ = 0;
};

/// Springs kept for a tick without a query.
inline constexpr std::uint32_t k_kept = 64;

/// Memory of a zone's contact with a touched body.
struct TouchMemory {
    /// A contact's tangent plane in the body and its point in the zone's frame.
    struct Plane {
        Vec3d point{}, normal{};  ///< body's frame
        Vec3d probe{};            ///< zone's frame
        double weight = 0;
    };
    Plane planes[k_kept];
    std::uint32_t plane_count = 0;
    bool single = false;  ///< one plane stands for the zone's whole contact (stencils)
    Wrench braking{};     ///< before contact, of the last tick with a query
    double sink = 0;      ///< proxy: depth at which it rests, m
    double let_in = 0;    ///< proxy: m that its plane has receded since its last contact

    Pose body_before{};  ///< of the touched body at the last step
    bool known = false;  ///< body_before is set
    Vec3d bristle{};     ///< Coulomb: stretch of the sticking spring, in the body's frame
    double mu = 0;       ///< coefficient at which it slips: falls from static to dynamic after release
    bool stuck = true;
    bool touching = false;
    double spring = 0;  ///< N, of this tick
};

/// The probe query of a touched body in this tick.
struct CachedQuery {
    const query::Probe* probe = nullptr;
    Pose pose{};
    query::QueryOptions options{};
    query::ProbeResult result{};
};

/// Memory of a zone.
struct ZoneMemory {
    Pose points_before{};  ///< pose of the zone's points at the last step
    Twist device_twist{};
    Track track{};       ///< of the device
    bool known = false;  ///< the members above are set
    Pose body{};         ///< proxy or coupled body
    Twist body_twist{};
    bool has_body = false;
    bool inside = false;  ///< proxy: the device has not been free since the proxy was placed
    Vec3d side{};         ///< proxy, side_path: unit, out of the surface on the side that it came from; zero while free
    /// Blending: springs and total of the last tick, and what remains of jumps.
    Wrench springs_before{}, whole_before{}, left{};
    bool was_touching = false;
    std::uint32_t points = 0;  ///< 0: the zone's own; i: those of denser[i - 1]
};

/// Contacts of edges and faces that are kept of a zone and a body.
inline constexpr std::size_t k_surface_contacts = 4096;

struct State::Data {
    std::vector<Zone> zones;
    std::vector<ZoneReport> reports;
    std::vector<ZoneMemory> memory;
    std::vector<TouchMemory> touches;  ///< zone by touched body
    std::size_t max_touched = 0;
    std::vector<query::Contact> found;                ///< touched body by contact
    std::vector<CachedQuery> queries;                 ///< per touched body
    std::vector<Sample> samples;                      ///< of one stencil
    std::vector<Trail> trails;                        ///< zone by touched body by sample
    std::optional<query::ContactWorkspace> surfaces;  ///< where a zone has a surface
    std::vector<std::vector<double>> mean_weight;     ///< zone by set of points: of one point
    std::uint64_t degraded_steps = 0;
};

struct ZoneTick {
    State::Data& state;
    const StepInput& in;
    std::span<Wrench> on_touched;
    std::size_t index;  ///< of the zone

    const Zone& zone = state.zones[index];
    const ZoneOptions& options = zone.options;
    ZoneMemory& memory = state.memory[index];
    ZoneReport& report = state.reports[index];
    /// The memory of each touched body: of as many as the input and the state hold.
    std::span<TouchMemory> touches =
        std::span(state.touches).subspan(index * state.max_touched, std::min(in.touched.size(), state.max_touched));

    [[nodiscard]] const Pose& device() const { return in.poses[index]; }
    [[nodiscard]] std::size_t bodies() const { return touches.size(); }
    [[nodiscard]] const TouchedBody& body(std::size_t s) const { return in.touched[s]; }
    /// The last surfaces of a stencil's samples on a body: as many as the state has samples.
    [[nodiscard]] std::span<Trail> trail(std::size_t s) const
    {
        const std::size_t size = state.samples.size();
        return std::span(state.trails).subspan((index * state.max_touched + s) * size, size);
    }

    /// The reaction of a wrench about `centre` on a touched body.
    void add_reaction(std::size_t s, const Wrench& w, Vec3d centre) const
    {
        if (s >= on_touched.size()) return;
        on_touched[s].force -= w.force;
        on_touched[s].torque -= w.torque + cross(centre - body(s).pose.translation, w.force);
    }
    /// The wrench with the zone's share of its torque.
    [[nodiscard]] Wrench with_torque_share(const Wrench& w) const { return {w.force, options.torque_share * w.torque}; }
    /// Velocity of the zone over a touched body at a lever from `at`.
    [[nodiscard]] Vec3d velocity_over(std::size_t s, const Twist& twist, const Pose& at, Vec3d lever) const
    {
        return velocity_at(twist, lever) - velocity_at(body(s).twist, at.translation + lever - body(s).pose.translation);
    }
    /// Clears the zone's memory.
    void clear() const;
};

}  // namespace sqmap::haptic
