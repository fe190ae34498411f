// A frame of touch, as it is streamed and as a recording is drawn: the newest tick, and the ticks since the frame before.
#pragma once

#include "viewer/server/touch/forces.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::viewer {

/// One tick, as charts draw it.
struct TickPoint {
    float force = 0, torque = 0;  ///< N, N m, as sent
    float depth = 0;              ///< m
    float cpu = 0;                ///< us
    float since = 0;              ///< s since the frame's first tick, by the servo's clock
};

struct TouchFrame {
    std::uint64_t tick = 0;
    Vec3d tool{}, force{}, torque{};  ///< m, N, N m; the tool as it is drawn; the force as it is sent to the hand
    Vec3d hand{};                     ///< m, of the device: with a proxy it goes below what the tool lies on
    Mat3d turn{};                     ///< of the tool: world = turn x + tool
    Vec3d point{}, normal{};          ///< of the contact; zero where free
    double depth = 0;                 ///< m, of the hand below the surface
    double late = 0;                  ///< s, the most
    std::uint32_t contacts = 0, acted = 0, faults = 0;
    int object = -1, part = -1;  ///< that is touched
    bool engaged = false, degraded = false, connected = true;
    std::vector<TickPoint> ticks;  ///< at most 256
    double time = 0;               ///< s from the touch's first tick to the first of these
    bool cut = false;              ///< there were more: those that came last are left out
};

/// Sets where the tool is drawn and what it touches: frame.object is a number in objects, of which null ones are not there.
void set_contact(TouchFrame& frame, const sqmap::Pose& device, const Forces::Found& found, std::span<const ObjectPtr> objects);

/// As the page reads it: 1, number, 41 numbers, 5 a tick. recorded: ticks that are recorded, these included.
[[nodiscard]] std::vector<float> frame_floats(const TouchFrame& frame, std::uint64_t number, std::size_t recorded);

}  // namespace sqmap::viewer
