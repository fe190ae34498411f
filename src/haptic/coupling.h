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
    /// The same in the plane across n.
    void stiffen_across(double k, Vec3d n, Vec3d r)
    {
        const Vec3d least = std::fabs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, t = normalized(cross(n, least));
        stiffen(k, t, r);
        stiffen(k, cross(n, t), r);
    }
    void scale(double by)
    {
        for (auto& row : stiffness)
            for (double& x : row) x *= by;
    }
    /// k times other's springs.
    void add(double k, const BodyLoad& other)
    {
        for (int a = 0; a < 6; ++a)
            for (int b = 0; b < 6; ++b) stiffness[a][b] += k * other.stiffness[a][b];
    }
    /// Dampers where other's springs are, to what moves by minus `away` along n at r: what they do at the end of a step of dt.
    void damp(double b, double dt, Vec3d away, Vec3d n, Vec3d r, const BodyLoad& other)
    {
        add(b / dt, other);
        const Vec3d push = -b * dot(away, n) * n;
        wrench = wrench + Wrench{push, cross(r, push)};
    }
};

/// Moves the body one step of dt; the wrench on the hand. False where the numbers have left the finite: nothing is moved.
bool step_body(const ZoneOptions& options, const Pose& device, const Twist& device_twist, const BodyLoad& load, double dt,
               Pose& body, Twist& body_twist, Wrench& on_hand) noexcept;

}  // namespace sqmap::haptic
