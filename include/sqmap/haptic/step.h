// One tick of haptic rendering: poses of a tool's zones in, one wrench a zone out (section 6).
#pragma once

#include "sqmap/haptic/safety.h"
#include "sqmap/haptic/stencil.h"
#include "sqmap/haptic/texture.h"
#include "sqmap/haptic/wrench.h"
#include "sqmap/math/friction.h"
#include "sqmap/model/model.h"
#include "sqmap/query/probe.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sqmap::haptic {

/// The same model measured in metres: where a mesh unit is not a metre. @pre metres_per_unit > 0
[[nodiscard]] model::ModelView in_metres(const model::ModelView& model, double metres_per_unit) noexcept;

/// The surface of a touched body.
struct Material {
    Friction friction = Friction::Coulomb;
    double mu_static = 0.4, mu_dynamic = 0.3;
    double f_c = 0.2;                  ///< N, eq. 33
    double k_f = 100;                  ///< 1/m, eq. 33
    const Texture* texture = nullptr;  ///< eq. 34; outlives the step
};

/// What is touched: a baked model in metres, posed in the world. Movable: its twist counts, and it gets its own wrench.
struct TouchedBody {
    const model::ModelView* model = nullptr;  ///< from model::parse, in metres (see in_metres)
    Pose pose{};                              ///< mesh frame -> world, rigid
    Twist twist{};                            ///< of the mesh frame's origin, world
    Material material{};
};

/// How a zone follows the device.
enum class Mode : std::uint8_t {
    Direct,   ///< the zone's points stand where the device says; the paper's
    Proxy,    ///< a proxy stays outside the surface and is pulled by the device: thin and deep cases. Turns with the device
    Coupled,  ///< a simulated body, joined to the device by springs and dampers in position and rotation
};

/// What the forces of a zone's contacts become. All leave a force that does not depend on how many points there are.
enum class Averaging : std::uint8_t {
    Patch,    ///< mean over the contacts, weighted by area; what enters does so with no weight (entry_depth)
    Stencil,  ///< the points are stencil_points: what the zone's tip feels, smoothed over a small sphere about it
    Ball,     ///< the same points: a ball about the zone's tip, as deep as its deepest place
};

/// Where on the smooth side a zone's force lies; see docs/algorithms/haptics.md.
enum class Shading : std::uint8_t {
    Levelled,    ///< full spring force across edges: size from the mean depth, direction from the mean of the normals
    Consistent,  ///< the gradient of one potential, so that a closed path gives no energy: weaker on edges
};

struct ZoneOptions {
    Mode mode = Mode::Direct;
    Averaging averaging = Averaging::Patch;
    Smoothing smoothing{};  ///< Stencil and Ball: what the probe's points were made from
    Shading shading = Shading::Levelled;
    double entry_depth = 0.0005;  ///< m, Patch: from here on a contact has its full weight; 0: at once, the paper's mean
    query::Layer layer = query::Layer::Three;  ///< One is answered by Two: a superquadric pushes from outside the surface
    double stiffness = 500;                    ///< k of eqs. 21 and 32, N/m (errata 10)
    double damping = 0;                        ///< N s/m along the normal while pressing in; never pulls
    double tangential_stiffness = 500;         ///< of the sticking spring of Coulomb friction, N/m
    double torque_share = 1;                   ///< 0: force only
    /// Pre-contact braking: N s/m against the approach, from where the zone will be after brake_ahead seconds; 0: none. Costs
    /// a second query.
    double brake = 0, brake_ahead = 0.005;
    /// Where the foot point jumps (medial axis): what is left of a jump after each blend_time, s, is 1/e; 0: jumps pass.
    double blend_time = 0.010;
    /// m, of the device's encoder, where twists are not measured: velocity is then taken over as long a past as one velocity
    /// explains to within it; 0: over the last tick.
    double resolution = 0;
    /// m, Proxy with a Patch or a Ball (of which no more than a fifth of the radius): it lies so deep in the surface that many
    /// points bear it, which makes the force smooth and the torque soft: as the tool turns, the place that bears it moves across
    /// it. A Patch in something thinner rises until it no longer feels the other side. 0: on one point.
    double proxy_depth = 0.002;
    /// Coupled: the spring and the damper between device and body, and the body. Defaults: for a light desktop stylus (b 1 N s/m,
    /// a tick of delay); choose_coupling takes a device's own numbers. A light body is not felt in free air.
    double coupling_stiffness = 450, coupling_rotational = 0.18;        ///< N/m, N m/rad
    double mass = 0.005, inertia = 2e-6;                                ///< kg, kg m^2 about every axis
    double coupling_damping = 0.2, coupling_rotational_damping = 8e-5;  ///< N s/m, N m s/rad
};

/// The same surface with more points.
struct DenserPoints {
    const query::Probe* probe = nullptr;  ///< in metres, the zone's frame
    std::span<const float> weights{};     ///< area a point; outlives the state
};

/// An impact zone (section 6.1): a part of the tool that feels as one.
struct Zone {
    const query::Probe* probe = nullptr;  ///< in metres; zones in a row with one probe and one pose are asked once
    bool in_world = false;                ///< the probe's points are in the world (Probe::move), not in the zone's frame
    std::uint32_t first = 0, count = std::numeric_limits<std::uint32_t>::max();  ///< the probe's points that belong to it
    Vec3d tip{};                       ///< Stencil and Ball: the centre of the points, the zone's frame
    std::span<const float> weights{};  ///< Patch: area a point, #points of the probe; empty: all alike. Outlives the state
    /// Patch, and only a zone that has all of its probe: ever more points, one set a tick. A denser one follows while it would
    /// not have more than max_touching points in contact, so that few large triangles are felt between their corners and many
    /// small ones cost no more. A change of the force is blended. Outlives the state.
    std::span<const DenserPoints> denser{};
    std::uint32_t max_touching = 1200;
    double radius = std::numeric_limits<double>::infinity();  ///< m, of the impact sphere about the zone's pose
    ZoneOptions options{};
};

/// What happened; bits.
enum StepStatus : std::uint32_t {
    k_step_ok = 0,
    k_step_contact = 1,
    k_step_full = 2,        ///< more contacts than the state holds: the rest does not count
    k_step_not_finite = 4,  ///< a pose, a solid or dt was not: that zone's wrench is zero and its memory is cleared
    k_step_degraded = 8,    ///< answered from the last tangent planes
    k_step_blended = 16,    ///< a jump of the force is being blended
    k_step_slipping = 32,
    k_step_no_surface = 64,   ///< some contact had no surface to push to and was left out
    k_step_short_span = 128,  ///< wrenches or on_touched holds fewer than there are: the rest is lost
    k_step_teleport = 256,    ///< the device jumped by more than k_teleport or k_teleport_turn: its zone's memory was cleared
};

/// What a zone felt in the last tick, for traces and pictures. World, metres.
struct ZoneReport {
    double depth = 0;    ///< effective: spring force over stiffness
    double deepest = 0;  ///< of its contacts; of a stencil or ball its own depth, before smoothing
    Vec3d normal{};      ///< unit, the way out; zero where free
    Vec3d point{};       ///< centre of the contacts on the surface
    std::uint32_t contacts = 0;
    std::uint32_t points = 0;  ///< 0: the zone's own; i: those of denser[i - 1]
    std::uint32_t status = k_step_ok;
    Pose body{};           ///< where the zone's points stood: the device's pose, the proxy or the coupled body
    double potential = 0;  ///< J, stored in the contact spring
    double push = 0;       ///< N, of all its springs before opposite walls cancel: what SafetyInput::pushes asks for
};

struct StepInput {
    std::span<const TouchedBody> touched{};
    std::span<const Pose> poses{};    ///< one a zone, world; their translation is what torque is about
    std::span<const Twist> twists{};  ///< one a zone where measured; empty: differences of poses
    double dt = 0.001;                ///< s since the last step, the real one
    /// No time for a query: every zone is answered from the tangent planes of its last one. Never by superquadrics alone.
    bool degraded = false;
};

struct StepResult {
    std::uint32_t status = k_step_ok;  ///< of all zones
    std::uint32_t contacts = 0;
    double deepest = 0;  ///< m
};

struct Sample;
struct Trail;

struct StateOptions {
    std::size_t max_contacts = 8192;  ///< of one probe with one solid
    std::size_t max_touched = 8;      ///< those beyond it are not felt, and k_step_full says so
};

/// What is remembered from tick to tick. Made outside the loop; one thread at a time.
class State {
public:
    /// Allocates. @pre every probe outlives the state
    explicit State(std::span<const Zone> zones, const StateOptions& options = {});

    [[nodiscard]] std::size_t zones() const noexcept { return zones_.size(); }
    /// To be changed between ticks; not the averaging, which the state made room for.
    [[nodiscard]] ZoneOptions& options(std::size_t zone) noexcept { return zones_[zone].options; }
    [[nodiscard]] const ZoneReport& report(std::size_t zone) const noexcept { return reports_[zone]; }
    /// Steps answered from old planes since the state was made.
    [[nodiscard]] std::uint64_t degraded_steps() const noexcept { return degraded_steps_; }
    /// Forgets contact, friction, proxies and bodies: after a teleport or another scene.
    void reset() noexcept;

    struct Memory;  ///< of a zone
    struct Touch;   ///< of a zone with a solid
    struct Asked;   ///< of a solid
    State(State&&) noexcept;
    State& operator=(State&&) noexcept;
    ~State();

private:
    friend struct Stepper;
    std::vector<Zone> zones_;
    std::vector<ZoneReport> reports_;
    std::vector<Memory> memory_;
    std::vector<Touch> touches_;  ///< zone by solid
    std::size_t max_touched_ = 0;
    std::vector<query::ProbeContact> found_;  ///< solid by contact
    std::vector<Asked> asked_;
    std::vector<Sample> samples_;  ///< of one stencil
    std::vector<Trail> trails_;    ///< zone by solid by sample
    std::uint64_t degraded_steps_ = 0;
};

/// One tick. wrenches: one a zone, on the hand, about its pose's translation. on_touched, where wanted: one a solid, what the
/// zones do to it, about its pose's translation: equal and opposite. Total, noexcept, no allocation; the same state and input
/// give the same bits.
/// Cost: a frame query a zone and a solid (once for zones that share probe and pose), then linear in the contacts.
StepResult step(State& state, const StepInput& input, std::span<Wrench> wrenches, std::span<Wrench> on_touched = {}) noexcept;

/// Damping of a coupling of stiffness K, N/m, to a body of mass m, kg, at period T, s, that leaves a device of damping b,
/// N s/m, passive: critical, but no more than b - K (T / 2 + delay) (Colgate and Brown 1994; with the delay as check_stiffness
/// has it) and m / T, and so little that a step of the encoder within a tick makes less force than the device's own friction
/// holds, f_c T / Delta (as Abbott and Okamura 2005 for stiffness). Rotation alike.
struct CouplingPhysics {
    double stiffness = 0, mass = 0, period = 0.001, device_damping = 0;
    double delay = 0;                     ///< s
    double friction = 0, resolution = 0;  ///< f_c, N; Delta, m; resolution 0: no such bound
};
[[nodiscard]] double coupling_damping(const CouplingPhysics& physics) noexcept;

/// Mode::Coupled for a device: coupling_stiffness is lowered to what 7/10 of the device's damping carries (and to 2 f_c / Delta),
/// the damping is coupling_damping of nine tenths of it, rotation as though at a lever of 2 cm; the resolution is the device's.
/// Mass and inertia stay. Numbers that the device does not tell: the careful ones of check_stiffness.
void choose_coupling(ZoneOptions& options, const DeviceLimits& device) noexcept;

/// Most torque_share with which a tool of stiffness K, N/m, whose points are up to `reach`, m, from its pose, turns the device no
/// more stiffly than it can show: a device whose damping is b at its tip is taken to turn with b (2 cm)^2. For Modes Direct and
/// Proxy; a coupling limits it by itself.
[[nodiscard]] double largest_torque_share(const DeviceLimits& device, double stiffness, double reach) noexcept;

}  // namespace sqmap::haptic
