// Mode::Coupled. McNeely, Puterbaugh, Troy, "Six degree-of-freedom haptic rendering using voxel sampling", SIGGRAPH 1999 (virtual
// coupling); Colgate, Stanley, Brown, "Issues in the haptic display of tool use", IROS 1995; Otaduy, Lin, "A modular haptic
// rendering algorithm for stable and transparent 6-DOF manipulation", IEEE T-RO 2006 (the body stepped implicitly with linearised
// contacts).
#include "push.h"

namespace sqmap::haptic {

namespace {

using Matrix6 = double[6][6];

/// Solves a x = x in place by Cholesky: a is symmetric and positive definite. False if it is not.
bool solve(Matrix6& a, double (&x)[6])
{
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j <= i; ++j) {
            double s = a[i][j];
            for (int m = 0; m < j; ++m) s -= a[i][m] * a[j][m];
            if (i == j) {
                if (!(s > 0)) return false;
                a[i][i] = std::sqrt(s);
            } else {
                a[i][j] = s / a[j][j];
            }
        }
    for (int i = 0; i < 6; ++i) {
        for (int m = 0; m < i; ++m) x[i] -= a[i][m] * x[m];
        x[i] /= a[i][i];
    }
    for (int i = 5; i >= 0; --i) {
        for (int m = i + 1; m < 6; ++m) x[i] -= a[m][i] * x[m];
        x[i] /= a[i][i];
    }
    return true;
}

struct BodyStep {
    bool finite = false;  ///< false: the body has not moved
    Wrench on_hand{};
};

/// Moves the zone's body one step: (M + h B + h^2 (K + K_contact)) v' = M v + h (K stretch + B v_device + contact), backward
/// Euler.
BodyStep step_body(ZoneTick& tick, const BodyLoad& load)
{
    const ZoneOptions& o = tick.options;
    const Pose& device = tick.device();
    const Twist& device_twist = tick.memory.device_twist;
    Pose& body = tick.memory.body;
    Twist& body_twist = tick.memory.body_twist;
    const double dt = tick.in.dt;
    const Vec3d gap = device.translation - body.translation, turn = rotation_vector(device.rotation * transpose(body.rotation));
    const double mass[2] = {o.mass, o.inertia}, k[2] = {o.coupling_stiffness, o.coupling_rotational},
                 b[2] = {o.coupling_damping, o.coupling_rotational_damping};
    const Vec3d stretch[2] = {gap, turn}, speed[2] = {body_twist.linear, body_twist.angular},
                device_speed[2] = {device_twist.linear, device_twist.angular}, push[2] = {load.wrench.force, load.wrench.torque};
    Matrix6 a;
    double x[6];
    for (int i = 0; i < 6; ++i) {
        const int g = i / 3;
        for (int j = 0; j < 6; ++j) a[i][j] = dt * dt * load.stiffness[i][j];
        a[i][i] += mass[g] + dt * b[g] + dt * dt * k[g];
        x[i] = mass[g] * speed[g][i % 3] + dt * (k[g] * stretch[g][i % 3] + b[g] * device_speed[g][i % 3] + push[g][i % 3]);
    }
    if (!solve(a, x)) return {};
    const Twist moved{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
    if (!is_finite(moved)) return {};
    body.translation += dt * moved.linear;
    body.rotation = orthonormal(rotation_by(dt * moved.angular) * body.rotation);
    body_twist = moved;
    const Vec3d left = rotation_vector(body.rotation * transpose(device.rotation));
    return {true,
            {k[0] * (body.translation - device.translation) + b[0] * (moved.linear - device_twist.linear),
             k[1] * left + b[1] * (moved.angular - device_twist.angular)}};
}

}  // namespace

Wrench coupled(ZoneTick& tick)
{
    ZoneMemory& m = tick.memory;
    const ZoneOptions& o = tick.options;
    if (!m.has_body) {
        m.body = tick.device();
        m.body_twist = m.device_twist;
        m.has_body = true;
    }
    const Pose at = m.body;
    tick.report.body = at;
    Push p = push(tick, {at, m.body_twist});
    p.load.wrench = p.load.wrench + tick.with_torque_share(p.springs + p.rest);
    m.points_before = at;
    const BodyStep step = step_body(tick, p.load);
    if (!step.finite) {
        m.has_body = false;
        tick.report.status |= k_step_not_finite;
        return {};
    }
    // The body leaps when its surface does, so its own motion would explain any force: the device's motion counts. An encoder's
    // steps come now and then, and the body follows in between, so the resolution counts as motion.
    const double path = std::max(m.track.step(), tick.in.dt * norm(m.device_twist.linear)) + o.resolution;
    const double turn = std::max(m.track.turn(), tick.in.dt * norm(m.device_twist.angular)) + o.resolution / k_fade_arm;
    const Explained by_device{k_free_slope * o.coupling_stiffness * path, k_free_slope * o.coupling_rotational * turn,
                              path / k_free_turn};
    return tick.with_torque_share(blended(tick, {true, step.on_hand, step.on_hand, by_device}));
}

}  // namespace sqmap::haptic
