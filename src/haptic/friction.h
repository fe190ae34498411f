// Friction at the centre of a contact.
#pragma once

#include "zone_tick.h"

namespace sqmap::haptic {

struct Sliding {
    Vec3d normal{};    ///< unit, outwards, world
    double load = 0;   ///< N, along the normal
    double depth = 0;  ///< m
    Vec3d motion{};    ///< m, of the contact over the body since the last step, world
};

/// N, world. Coulomb: stretches the sticking spring of body s or lets it slip, and reports slipping.
[[nodiscard]] Vec3d friction_force(ZoneTick& tick, std::size_t s, const Sliding& sliding);

}  // namespace sqmap::haptic
