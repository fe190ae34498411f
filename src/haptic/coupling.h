// The body of Mode::Coupled: joined to the device by springs and dampers, pushed by contacts, stepped implicitly.
#pragma once

#include "rigid.h"
#include "sqmap/haptic/step.h"

namespace sqmap::haptic {

/// What pushes the body: force and torque about its centre now, and how they weaken as it yields.
struct BodyLoad {
    Wrench wrench{};
    double stiffness[6][6] = {};  ///< positive semi-definite: minus the derivative by (translation, rotation)

    /// A spring along unit n at the lever r.
    void stiffen(double k, Vec3d n, Vec3d r)
    {
        const Vec3d t = cross(r, n);
        const double j[6] = {n.x, n.y, n.z, t.x, t.y, t.z};
        for (int a = 0; a < 6; ++a)
            for (int b = 0; b < 6; ++b) stiffness[a][b] += k * j[a] * j[b];
    }
};

/// Moves the body one step of dt; the wrench on the hand. False where the numbers have left the finite: nothing is moved.
bool step_body(const ZoneOptions& options, const Pose& device, const Twist& device_twist, const BodyLoad& load, double dt,
               Pose& body, Twist& body_twist, Wrench& on_hand) noexcept;

}  // namespace sqmap::haptic
