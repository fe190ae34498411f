// One tick of haptic rendering: poses of a tool's zones in, one wrench per zone out (section 6).
#pragma once

#include "sqmap/haptic/zone.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace sqmap::haptic {

/// The same model with its lengths in metres. Shares the model's bytes, but for the caller's coordinates, which are in mesh
/// units: exact distances of the view are in float, unless a unit is a metre. Any thread.
/// @pre metres_per_unit > 0
[[nodiscard]] model::ModelView in_metres(const model::ModelView& model, double metres_per_unit) noexcept;

/// Events of a step, as bits.
enum StepStatus : std::uint32_t {
    k_step_ok = 0,
    k_step_contact = 1,
    k_step_full = 2,        ///< more contacts or bodies than the state holds, the rest does not count: raise
                            ///< StateOptions::max_contacts or max_touched
    k_step_not_finite = 4,  ///< a pose, a touched body or dt was not finite: that zone's wrench is zero and its memory is cleared
    k_step_degraded = 8,    ///< answered from the last tangent planes, since StepInput::degraded was set
    k_step_blended = 16,    ///< a jump of the force is being blended, over ZoneOptions::blend_time
    k_step_slipping = 32,
    k_step_no_surface = 64,   ///< some contact had no surface to push to and was left out
    k_step_short_span = 128,  ///< wrenches or on_touched has too few elements: the rest is lost
    k_step_teleport = 256,    ///< the device jumped by more than k_teleport or k_teleport_turn: its zone's memory was cleared
};

/// The contact of a zone in the last tick, for traces and pictures. World, metres.
struct ZoneReport {
    double depth = 0;    ///< effective penetration depth: spring force over stiffness
    double deepest = 0;  ///< of its contacts; for a stencil or ball its own depth before smoothing
    Vec3d normal{};      ///< unit, outwards; zero where free
    Vec3d point{};       ///< centre of the contacts on the surface
    std::uint32_t contacts = 0;
    std::uint32_t points = 0;  ///< 0: the zone's own; i: those of denser[i - 1]
    std::uint32_t status = k_step_ok;
    Pose body{};           ///< the pose of the zone's points: the device's, the proxy's or the coupled body's
    double potential = 0;  ///< J, stored in the contact spring
    double push = 0;       ///< N, of all its springs before opposite walls cancel: for SafetyInput::pushes
};

/// Input of a tick.
struct StepInput {
    std::span<const TouchedBody> touched{};
    std::span<const Pose> poses{};    ///< per zone, world; torque is about their translation
    std::span<const Twist> twists{};  ///< per zone where measured, world; empty: differences of poses
    double dt = 0.001;                ///< s since the last step, the real one
    /// Set if there is no time for a query: every zone is answered from the tangent planes of its last one. Never by
    /// superquadrics alone.
    bool degraded = false;
};

/// Outcome of a tick.
struct StepResult {
    std::uint32_t status = k_step_ok;  ///< of all zones, bits of StepStatus
    std::uint32_t contacts = 0;
    double deepest = 0;  ///< m
};

/// Capacity of a state.
struct StateOptions {
    std::size_t max_contacts = 8192;  ///< of one probe with one touched body
    std::size_t max_touched = 8;      ///< bodies beyond it have no contacts, and k_step_full says so
};

class State;

/// One tick. wrenches: per zone, on the hand, N and N m in world axes, about its pose's translation. on_touched, where wanted:
/// per touched body, the zones' reaction on it, about its pose's translation. Total: bad input gives zero wrenches and a status
/// bit. No allocation; the same state and input give the same bits.
/// Cost: a probe query per zone and body (one for zones that share probe and pose), then linear in the contacts.
/// Thread safety: one thread per state at a time; any number of states at once.
StepResult step(State& state, const StepInput& input, std::span<Wrench> wrenches, std::span<Wrench> on_touched = {}) noexcept;

/// Memory of step() from tick to tick. Made outside the loop. Movable, not copyable; a moved-from state may only be
/// destroyed or assigned to.
/// Thread safety: one thread at a time, const functions included.
class State {
public:
    /// Allocates all that step() needs. @pre every probe outlives the state (not checked) @throw std::bad_alloc
    explicit State(std::span<const Zone> zones, const StateOptions& options = {});
    State(State&&) noexcept;
    State& operator=(State&&) noexcept;
    ~State();

    /// Number of zones.
    [[nodiscard]] std::size_t zones() const noexcept;
    /// Options of a zone. They may change between ticks, except the averaging, for which the state has allocated.
    /// @pre zone < zones()
    [[nodiscard]] ZoneOptions& options(std::size_t zone) noexcept;
    /// @pre zone < zones()
    [[nodiscard]] const ZoneReport& report(std::size_t zone) const noexcept;
    /// Steps answered from old planes since the state was made.
    [[nodiscard]] std::uint64_t degraded_steps() const noexcept;
    /// Forgets contact, friction, proxies and bodies: after a teleport or another scene.
    void reset() noexcept;

    struct Data;

private:
    friend StepResult step(State& state, const StepInput& input, std::span<Wrench> wrenches,
                           std::span<Wrench> on_touched) noexcept;
    std::unique_ptr<Data> data_;
};

}  // namespace sqmap::haptic
