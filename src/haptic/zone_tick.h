// One zone in one tick: its input, its memory, its report.
#pragma once

#include "memory.h"
#include "rigid.h"

#include <span>

namespace sqmap::haptic {

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
