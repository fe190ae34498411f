// A simulated device in a simulated hand: a mechanism with mass, friction, encoder and delay, held by a mass, a spring and a
// damper. In steps for tests, and by the clock as a Device.
#pragma once

#include "sqmap/device/device.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace sqmap::device {

/// How a hand holds the tool: a mass on a spring and a damper whose other end is the hand's target.
struct HandProfile {
    const char* name = "";
    double mass = 0;            ///< kg that moves with the tool
    double damping = 0;         ///< N s/m
    double stiffness = 0;       ///< N/m
    double inertia = 0;         ///< kg m^2
    double turn_damping = 0;    ///< N m s/rad
    double turn_stiffness = 0;  ///< N m/rad
};

/// From a fingertip that just rests on the tool to a fist. The second-order model of Hogan (1989) and Hajian and Howe (1997);
/// stiffness and damping grow together with the grip as Hasser and Cutkosky (2002) and Kuchenbecker, Park and Niemeyer (2003)
/// found for a pinch and for a stylus. The numbers are ours: they span from below to above what those measured, not any one hand.
inline constexpr std::array<HandProfile, 5> k_hand_profiles{{
    {"relaxed", 0.006, 0.5, 40, 1e-6, 0.0003, 0.02},
    {"fingertip", 0.010, 2, 200, 4e-6, 0.001, 0.1},
    {"pen", 0.030, 4, 400, 1e-5, 0.002, 0.3},
    {"firm", 0.080, 8, 800, 3e-5, 0.005, 0.8},
    {"stiff", 0.150, 15, 1500, 8e-5, 0.01, 2},
}};

/// By its name. @throw DeviceError that names them all
[[nodiscard]] const HandProfile& hand_profile(std::string_view name);

/// The mechanism. Defaults: a light desktop stylus.
struct Mechanism {
    double mass = 0.07;                        ///< kg, at the tip
    double damping = 1.0;                      ///< b, N s/m
    double coulomb_friction = 0.05;            ///< f_c, N
    double inertia = 2e-5;                     ///< kg m^2
    double turn_damping = 5e-4;                ///< N m s/rad
    double resolution = 25e-6;                 ///< m, of the encoder, along each axis
    int delay_ticks = 1;                       ///< ticks from a wrench written to the same wrench exerted; at most 8
    double timeout = 0.020;                    ///< s after the last wrench until the motors let go by themselves
    double max_force = 3.3, max_torque = 0.2;  ///< N, N m: limits of the motors
    double continuous_force = 0;               ///< N that motors could hold for long; 0: there are no motors that heat
};

/// Pose and twist that the hand aims at.
struct HandTarget {
    Pose pose{};
    Twist twist{};
};

/// One zone of the device in a hand, in steps of any length; no clock, no thread, no allocation. The same steps give the same
/// bits. Semi-implicit Euler in substeps of at most 50 us. Thread safety: one thread at a time.
class HeldTool {
public:
    /// Starts at rest at the origin.
    HeldTool(const Mechanism& mechanism, const HandProfile& hand) noexcept : mechanism_(mechanism), hand_(hand) {}

    /// Puts the tool at rest at a pose, without force.
    void reset(const Pose& pose) noexcept;
    /// dt seconds. written: the wrench of this tick; null if none came.
    void step(const Wrench* written, const HandTarget& target, double dt) noexcept;
    /// Removes the force until the next wrench.
    void zero() noexcept;

    [[nodiscard]] Pose measured() const noexcept;                         ///< as the encoder sees it
    [[nodiscard]] const Pose& pose() const noexcept { return pose_; }     ///< true, without the encoder's steps
    [[nodiscard]] const Twist& twist() const noexcept { return twist_; }  ///< true
    /// Wrench of the motors now.
    [[nodiscard]] const Wrench& exerted() const noexcept { return exerted_; }
    /// Work of the motors since reset, J.
    [[nodiscard]] double work() const noexcept { return work_; }
    /// Energy, J, that the mechanism's own friction has dissipated since reset.
    [[nodiscard]] double dissipated() const noexcept { return dissipated_; }

private:
    Mechanism mechanism_;
    HandProfile hand_;
    Pose pose_{};
    Twist twist_{};
    std::array<Wrench, 9> queue_{};  ///< newest first
    bool written_ = false;
    double since_write_ = 0;
    Wrench exerted_{};
    double work_ = 0, dissipated_ = 0;
};

/// The motors of a SimulatedDevice, for watching. Any number of threads or processes may read it: lock-free, so that it may lie
/// in shared memory.
struct MotorRecord {
    std::atomic<double> force{0};      ///< N, the largest of the zones, exerted now
    std::atomic<double> max_force{0};  ///< N, since the start
    std::atomic<std::uint64_t> writes{0}, zeros{0};
    std::atomic<double> last_write{0};  ///< s, steady clock
    std::atomic<double> let_go{0};      ///< s, steady clock: when the force last fell to zero
    static_assert(std::atomic<double>::is_always_lock_free && std::atomic<std::uint64_t>::is_always_lock_free);
};

/// Target of a zone's hand, time seconds after the device was made.
using HandScript = HandTarget (*)(const void* context, double time, std::size_t zone) noexcept;

/// A simulated device and the hand that holds it.
struct SimulatedOptions {
    Mechanism mechanism{};
    HandProfile hand = k_hand_profiles[2];
    std::size_t zones = 1;
    HandScript script = nullptr;  ///< null: a hand at rest at the origin
    const void* script_context = nullptr;
    MotorRecord* motors = nullptr;  ///< null: no record
    double step = 0;                ///< s that every read() simulates, whole milliseconds; 0: the time since the last one
};

/// Each read() simulates the time since the last one by the steady clock, or SimulatedOptions::step; the script starts with the
/// first read(). capabilities().simulated.
/// Thread safety: as every Device; unplug, freeze and poison by any thread.
class SimulatedDevice final : public Device {
public:
    /// @throw std::invalid_argument for zones outside 1 to k_max_zones
    explicit SimulatedDevice(const SimulatedOptions& options = {});
    ~SimulatedDevice() override;

    [[nodiscard]] const Capabilities& capabilities() const noexcept override { return capabilities_; }
    bool read(Sample& sample) noexcept override;
    bool write(std::span<const Wrench> wrenches) noexcept override;
    void zero() noexcept override;

    /// For tests: the device is gone from now on.
    void unplug() noexcept { plugged_ = false; }
    /// For tests: while frozen, the device gives no fresh samples.
    void freeze(bool frozen) noexcept { frozen_ = frozen; }
    /// For tests: while poisoned, the device reports numbers that are not finite.
    void poison(bool poisoned) noexcept { poisoned_ = poisoned; }

private:
    void pass(double until) noexcept;

    SimulatedOptions options_;
    Capabilities capabilities_;
    std::vector<HeldTool> tools_;
    std::vector<Wrench> written_;
    bool fresh_write_ = false;
    double begin_ = 0, time_ = 0;
    std::uint64_t sequence_ = 0;
    MotorRecord own_motors_;
    MotorRecord& motors_;
    std::atomic<bool> cancelled_{false}, plugged_{true}, frozen_{false}, poisoned_{false};
};

/// Capabilities of a mechanism with a number of zones. Any thread.
[[nodiscard]] Capabilities capabilities_of(const Mechanism& mechanism, std::size_t zones);

}  // namespace sqmap::device
