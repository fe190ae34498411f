// The load on the body of Mode::Coupled.
#pragma once

#include "rigid.h"

namespace sqmap::haptic {

/// A damper of b, N s/m, along a unit normal at a lever; away: minus the velocity, m/s, of the body it is fixed to.
struct Damper {
    double b = 0;
    Vec3d away{}, normal{}, lever{};
};

/// Force and torque about the body's centre now, and how they weaken as it yields.
struct BodyLoad {
    Wrench wrench{};
    double stiffness[6][6] = {};  ///< positive semi-definite: minus the derivative by (translation, rotation)

    /// A spring of k, N/m, along unit n at the lever r.
    void stiffen(double k, Vec3d n, Vec3d r)
    {
        const Vec3d t = cross(r, n);
        const double j[6] = {n.x, n.y, n.z, t.x, t.y, t.z};
        for (int a = 0; a < 6; ++a)
            for (int b = 0; b < 6; ++b) stiffness[a][b] += k * j[a] * j[b];
    }
    /// Two such springs in the plane across n.
    void stiffen_across(double k, Vec3d n, Vec3d r)
    {
        const Vec3d other = std::fabs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, t = normalized(cross(n, other));
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
    /// Adds a damper along each of other's springs, with its force at the end of a step of dt.
    void damp(const Damper& d, double dt, const BodyLoad& other)
    {
        add(d.b / dt, other);
        const Vec3d push = -d.b * dot(d.away, d.normal) * d.normal;
        wrench = wrench + Wrench{push, cross(d.lever, push)};
    }
};

}  // namespace sqmap::haptic
