// A touch with all that its forces depend on, so that they can be computed again: as they were, or over other objects.
#pragma once

#include "viewer/server/touch/forces.h"

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::viewer {

/// One recorded Touch from its first tick on: friction, filters and everything else with a memory began empty.
struct Take {
    struct Tick {
        ForceInput input{};
        haptic::Wrench commanded{};  ///< computed, before the safety filter
        haptic::Wrench sent{};       ///< behind it
        double depth = 0;
        double time = 0, cpu = 0;    ///< s since the take's first tick; s of CPU time
        std::uint64_t sequence = 0;  ///< of the device's reading
        std::uint32_t number = 0;    ///< of the settings
        std::uint32_t contacts = 0, status = 0, buttons = 0;
        std::uint32_t filter = 0;  ///< haptic::bits of the report
    };
    std::vector<ObjectPtr> objects;
    std::vector<Settings> settings;  ///< of the beginning, then one after the other: they differ in what is live
    std::vector<Tick> ticks;
    std::uint64_t lost = 0;  ///< ticks that the servo did and this did not hear of
};
using Recording = std::vector<std::shared_ptr<const Take>>;

inline constexpr std::size_t k_max_recorded = 120'000;  ///< ticks: two minutes
inline constexpr std::size_t k_max_takes = 256;

/// Objects and settings that replace those of then.
struct Other {
    std::vector<ObjectPtr> objects;
    Settings settings;
};

/// The same poses computed again. Forces and torques before the safety filter.
struct Again {
    struct Tick {
        float force = 0, torque = 0, depth = 0;  ///< N, N m, m
    };
    std::vector<Tick> ticks;
    std::uint64_t different = 0;  ///< ticks whose force, torque or depth is not the same to the bit
    std::uint64_t lost = 0;
    double largest_force = 0, rms_force = 0, largest_depth = 0;  ///< of the differences
};
/// Receives each tick as it was recorded, and its forces before the safety filter and its depth, m, as computed again.
using TickWitness = std::function<void(const Take::Tick& tick, const haptic::Wrench& wrench, double depth)>;
/// stop: called now and then; true ends it early.
[[nodiscard]] Again compute_again(const Recording& recording, const std::optional<Other>& other,
                                  const std::function<bool()>& stop = {}, const TickWitness& witness = {});

/// "SQR1", #ticks, #different, #lost; then 32-bit floats: largest and root mean square difference of force (N), largest of depth
/// (m); of each tick force, torque, depth.
[[nodiscard]] std::string again_bytes(const Again& again);

/// The recording as the page draws it, computed again as it was: "SQL1", #frames; then a frame: #floats, frame_floats.
/// scene: the objects of now, whose numbers the frames have.
[[nodiscard]] std::string frames_bytes(const Recording& recording, std::span<const ObjectPtr> scene,
                                       const std::function<bool()>& stop = {});

}  // namespace sqmap::viewer
