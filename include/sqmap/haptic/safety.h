// The safety filter between an algorithm and a hand: nine steps in every tick, the last a clamp; none can be switched off.
#pragma once

#include "sqmap/haptic/stiffness.h"
#include "sqmap/haptic/wrench.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace sqmap::haptic {

/// Largest number of zones of a filter.
inline constexpr std::size_t k_max_safe_zones = 16;

/// The filter's fixed numbers: no program can loosen them.
inline constexpr double k_stale_hold = 0.005;   ///< s after the last sample: the wrench is held, then it falls
inline constexpr double k_stale_zero = 0.020;   ///< s after the last sample: the wrench is zero
inline constexpr double k_stale_fault = 0.100;  ///< s after the last sample: FAULT
inline constexpr double k_engage_force = 0.2;   ///< N: forces begin after more than k_engage_ticks ticks with less commanded
inline constexpr int k_engage_ticks = 3;
inline constexpr double k_engage_ramp = 0.5;      ///< s from nothing to all of what is commanded
inline constexpr double k_teleport = 0.05;        ///< m between samples: more is a jump, not a motion
inline constexpr double k_teleport_turn = 1.0;    ///< rad between samples, likewise
inline constexpr double k_top_speed = 1.0;        ///< m/s: above it damping only
inline constexpr double k_top_turn = 20.0;        ///< rad/s
inline constexpr double k_fast_fault = 0.020;     ///< s above the top speed: FAULT
inline constexpr double k_duty_window = 10.0;     ///< s over which the root mean square of the force is kept
inline constexpr double k_default_force = 2.0;    ///< N, without a limit of the user
inline constexpr double k_default_torque = 0.1;   ///< N m
inline constexpr double k_unknown_force = 1.0;    ///< N, maximum of a device whose own is unknown
inline constexpr double k_unknown_torque = 0.05;  ///< N m

/// Choices of the user. A choice can make the filter stricter than the device allows, never laxer.
struct SafetyOptions {
    std::optional<double> force_limit{};   ///< N; default: 2 N or the device's maximum, whichever is less
    std::optional<double> torque_limit{};  ///< N m; default: 0.1 N m or the device's maximum, whichever is less
    double slew = 250;            ///< N/s, maximum growth of a force; at most 1000; of a torque, the same share of its limit
    double energy_margin = 1e-3;  ///< J that a zone may give before the passivity step acts; at most 10 mJ
    /// N/m, the softest spring that the algorithm shows: it bounds the energy that a zone can store. At least 20.
    double softest = 100;
    bool dead_man = false;  ///< force only while SafetyInput::held
};

/// Verdict on the limits of a filter.
enum class SetupStatus : std::uint8_t {
    Ok,
    NotFinite,         ///< a limit or a number of the device is NaN, infinite or negative
    LimitNotPositive,  ///< a limit of zero or less: to switch the force off, do not open the device
    LimitAboveDevice,  ///< more than the device holds
    BadOption,         ///< slew, margin or softest spring outside its range
    BadPeriod,         ///< a tick that is not between 0.1 and 20 ms
};
/// A sentence for people. Any thread.
[[nodiscard]] const char* describe(SetupStatus status) noexcept;

/// One tick's input.
struct SafetyInput {
    double time = 0;                      ///< s, monotonic: now
    double sample_time = 0;               ///< s, the same clock: when the newest sample was measured
    std::uint64_t sequence = 0;           ///< of the newest sample; the same number again is a stale one
    std::span<const Pose> poses{};        ///< one a zone
    std::span<const Twist> twists{};      ///< one a zone; empty where the device measures none
    std::span<const Wrench> commanded{};  ///< per zone, by the algorithm, world
    /// N, per zone, where the algorithm knows: the push of its springs before those of opposite walls cancel, since they hold the
    /// energy that the hand has put in; empty: as much as is commanded.
    std::span<const double> pushes{};
    /// J, per zone, that springs under load have gained since the last tick because the user made them stiffer; empty: none. They
    /// push the hand out, which the passivity step would else take for energy from nowhere. At most 50 mJ of a contact count.
    std::span<const double> stiffened{};
    bool connected = true;  ///< false: the device is gone
    bool held = true;       ///< the dead-man switch
    bool stop = false;      ///< STOP, which holds until resume
    bool resume = false;    ///< the user's act: clears STOP and FAULT
    bool restart = false;   ///< scene changed, reconnected: engage anew
};

/// Bits of SafetyReport::acted: the steps that changed the wrench.
enum SafetyStep : std::uint32_t {
    k_acted_finite = 1u << 0,
    k_acted_stale = 1u << 1,
    k_acted_engage = 1u << 2,
    k_acted_clamp = 1u << 3,
    k_acted_slew = 1u << 4,
    k_acted_speed = 1u << 5,
    k_acted_passivity = 1u << 6,
    k_acted_duty = 1u << 7,
    k_acted_last = 1u << 8,     ///< the final clamp
    k_acted_off = 1u << 9,      ///< FAULT, STOP, dead-man switch or no device: zero
    k_acted_inside = 1u << 10,  ///< beside k_acted_engage: a zone was commanded a force before it was free, see waiting
};

/// Bits of SafetyReport::faults; any of them means zero until the user acts.
enum SafetyFault : std::uint32_t {
    k_fault_setup = 1u << 0,       ///< refused limits: cannot be cleared
    k_fault_not_finite = 1u << 1,  ///< within 100 ms, three samples not finite or with a matrix that is no rotation
    k_fault_stale = 1u << 2,       ///< no fresh sample for 100 ms
    k_fault_fast = 1u << 3,        ///< faster than the top speed for 20 ms
    k_fault_stop = 1u << 4,        ///< the user's STOP
};

/// A tick's outcome.
struct SafetyReport {
    std::uint32_t acted = 0;   ///< bits of SafetyStep
    std::uint32_t faults = 0;  ///< bits of SafetyFault
    bool engaged = false;      ///< every zone gets all that is commanded, within limits
    double age = 0;            ///< s since the last sample
    /// A bit per zone that was inside a body when forces were to begin: it gets no force until it has left the body
    /// (k_engage_force). The user's cure is to lift the tool out once.
    std::uint32_t waiting = 0;
};

/// A report in a word, for traces and devices: acted, and faults from bit 16 on. Any thread.
[[nodiscard]] constexpr std::uint32_t bits(const SafetyReport& report) noexcept { return report.acted | report.faults << 16; }

/// Ticks in which each thing happened, since construction.
struct SafetyCounters {
    std::uint64_t ticks = 0, not_finite = 0, held = 0, stale = 0, teleports = 0, engagements = 0, clamped = 0, slewed = 0,
                  fast = 0, passivity = 0, duty = 0, last_clamped = 0, off = 0, faults = 0;
};

/// Deterministic: the same inputs give the same wrenches, bit for bit. Total, noexcept, no allocation; cost: linear in the zones.
/// Promises, for any input whatever: |force| and |torque| never exceed the limits; both are exactly zero in a tick with a number
/// that is not finite or a matrix that is no rotation, from 20 ms after the last sample on, and while a fault is latched. A
/// filter that was set up with refused limits always answers zero. Steps, defaults and limits: docs/algorithms/safety.md. Thread
/// safety: none; one thread at a time, const functions included (the servo's, where one runs it).
class SafetyFilter {
public:
    /// Refused limits: setup_status() says why, and every wrench is zero.
    SafetyFilter(const DeviceLimits& device, const SafetyOptions& options) noexcept;

    /// Ok, or the reason why the constructor refused its limits.
    [[nodiscard]] SetupStatus setup_status() const noexcept { return setup_status_; }
    [[nodiscard]] double force_limit() const noexcept { return force_limit_; }           ///< N, in force
    [[nodiscard]] double torque_limit() const noexcept { return torque_limit_; }         ///< N m
    [[nodiscard]] const SafetyCounters& counters() const noexcept { return counters_; }  ///< since the construction
    /// Energy, J, that a zone has given the hand since it came into contact, less the loss in the device's own damping: the
    /// passivity step bounds it. 0 for a zone that does not exist.
    [[nodiscard]] double energy(std::size_t zone) const noexcept { return zone < k_max_safe_zones ? zones_[zone].energy : 0; }

    /// safe[i]: the wrench that may be sent to zone i. As many zones as the shortest of poses, commanded and safe has; the rest
    /// of safe is zero.
    SafetyReport tick(const SafetyInput& in, std::span<Wrench> safe) noexcept;

private:
    static constexpr std::size_t k_history = 16;  ///< ticks of wrenches sent, for the delay
    enum class Phase : std::uint8_t { Waiting, Ramping, Engaged };

    struct Zone {
        Pose pose{};
        bool known = false;        ///< pose was measured
        Vec3d velocity{}, turn{};  ///< smoothed over a few samples
        Wrench held{};             ///< commanded at the last fresh sample
        std::array<Wrench, k_history> sent{};
        Wrench since{};  ///< sum of the wrenches in effect since the last fresh sample, and their number
        int since_count = 0;
        Phase phase = Phase::Waiting;
        int calm = 0;
        double ramp = 0;
        double ramp_store = 0;  ///< J that the ramp may yet give
        double fast = 0;        ///< s above the top speed
        double since_fast = 1;  ///< s since the last sample above the top speed; saturates
        double energy = 0;      ///< J
        double free_for = 0;    ///< s without force
        double spare = 1;       ///< share of the motors' heat that is left
    };
    struct Tick;

    Tick begin(const SafetyInput& in, std::size_t capacity) noexcept;
    void finite(const SafetyInput& in, Tick& tick) noexcept;
    void observe(const SafetyInput& in, Tick& tick) noexcept;
    void stale(const SafetyInput& in, Tick& tick) noexcept;
    void engage(const SafetyInput& in, Tick& tick) noexcept;
    void clamp(Tick& tick) noexcept;
    void slew(Tick& tick) noexcept;
    void speed(Tick& tick) noexcept;
    void passivity(Tick& tick) noexcept;
    void duty(Tick& tick) noexcept;
    void clamp_last(Tick& tick) noexcept;
    SafetyReport finish(Tick& tick, std::span<Wrench> safe) noexcept;

    void disengage() noexcept;
    void latch(std::uint32_t fault) noexcept;
    /// Energy, J, in springs that command this wrench at a share of their stiffness.
    [[nodiscard]] double stored(const Wrench& commanded, double share) const noexcept;
    [[nodiscard]] double heat(const Wrench& wrench) const noexcept;
    [[nodiscard]] Wrench slewed(const Wrench& from, const Wrench& to, double dt) const noexcept;
    [[nodiscard]] const Wrench& sent_before(const Zone& zone, std::size_t ticks) const noexcept;

    SetupStatus setup_status_ = SetupStatus::Ok;
    DeviceLimits device_{};
    double force_limit_ = 0, torque_limit_ = 0, force_slew_ = 0, torque_slew_ = 0, margin_ = 0, softest_ = 0,
           hold_ = k_stale_hold;
    double per_heat_force_ = 0, per_heat_torque_ = 0;  ///< 1/N^2, 1/(N m)^2: share of the continuous heat
    double peak_ = 0, duty_time_ = k_duty_window;      ///< largest heat, from cold; time constant, s
    bool dead_man_ = false;
    std::size_t delay_ticks_ = 0;

    std::array<Zone, k_max_safe_zones> zones_{};
    SafetyCounters counters_{};
    std::uint32_t faults_ = 0;
    std::uint64_t ticks_ = 0, sequence_ = 0;
    bool begun_ = false, sampled_ = false;
    double time_ = 0;                    ///< of the last tick
    double sampled_at_ = 0, stamp_ = 0;  ///< of the last fresh sample: when it came, and the earlier of that and its own time
    std::array<double, 3> bad_{};        ///< times of the last ticks with something not finite, newest first
    std::size_t bad_count_ = 0;
    std::uint64_t bad_sequence_ = 0;  ///< sequence number of the last of them
};

}  // namespace sqmap::haptic
