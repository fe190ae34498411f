// The push of all touched bodies on a zone: springs, damping, friction, braking. Modes Direct and Coupled.
#pragma once

#include "blend.h"
#include "body_load.h"

namespace sqmap::haptic {

struct Push {
    Wrench springs{};
    Wrench rest{};  ///< friction, braking; Mode::Direct: damping too
    Explained explained{};
    BodyLoad load{};  ///< Mode::Coupled: how the forces weaken as the body yields, and damping in its wrench
};

/// Pose and twist of the zone's points.
struct PointsMotion {
    Pose pose{};
    Twist twist{};
};
/// Sums the pushes of all touched bodies and fills the zone's report.
[[nodiscard]] Push push(ZoneTick& tick, const PointsMotion& points);

}  // namespace sqmap::haptic
