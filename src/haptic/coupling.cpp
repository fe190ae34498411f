// Colgate, Stanley, Brown, "Issues in the haptic display of tool use", IROS 1995 (virtual coupling); Colgate, Brown, "Factors
// affecting the Z-width of a haptic display", ICRA 1994 (b > K T / 2 + |B|); Abbott, Okamura, "Effects of position quantization
// and sampling rate on virtual-wall passivity", IEEE T-RO 2005 (an encoder's step against friction); Otaduy, Lin, "A modular
// haptic rendering algorithm for stable and transparent 6-DOF manipulation", IEEE T-RO 2006 (the body stepped implicitly with
// linearised contacts).
#include "coupling.h"

namespace sqmap::haptic {

namespace {

constexpr double k_spring_share = 0.7, k_share = 0.9;  // of the device's damping: for the spring; for spring and damper
constexpr double k_lever = 0.02;                       // m: as SafetyFilter takes what turns

}  // namespace

double coupling_damping(const CouplingPhysics& p) noexcept
{
    if (!(p.stiffness > 0) || !(p.mass > 0) || !(p.period > 0)) return 0;
    const double critical = 2 * std::sqrt(p.stiffness * p.mass);
    const double quiet = p.resolution > 0 ? p.friction * p.period / p.resolution : INFINITY;
    return std::max(0.,
                    std::min({critical, p.device_damping - p.stiffness * (0.5 * p.period + p.delay), p.mass / p.period, quiet}));
}

void choose_coupling(ZoneOptions& o, const DeviceLimits& device) noexcept
{
    const DeviceLimits d = with_careful_numbers(device);
    DeviceLimits spring = d;
    spring.damping *= k_spring_share;
    o.coupling_stiffness = std::min(o.coupling_stiffness, check_stiffness(spring, 0).largest);
    o.coupling_damping = coupling_damping({.stiffness = o.coupling_stiffness,
                                           .mass = o.mass,
                                           .period = d.period,
                                           .device_damping = k_share * d.damping,
                                           .delay = d.delay,
                                           .friction = d.coulomb_friction,
                                           .resolution = d.resolution});
    o.coupling_rotational = k_lever * k_lever * o.coupling_stiffness;
    o.coupling_rotational_damping = k_lever * k_lever * o.coupling_damping;
    o.resolution = device.resolution;
}

double largest_torque_share(const DeviceLimits& device, double stiffness, double reach) noexcept
{
    if (!(stiffness > 0) || !(reach > 0)) return 1;
    return std::min(1., check_stiffness(device, stiffness).largest * k_lever * k_lever / (stiffness * reach * reach));
}

bool step_body(const ZoneOptions& o, const Pose& device, const Twist& device_twist, const BodyLoad& load, double dt, Pose& body,
               Twist& body_twist, Wrench& on_hand) noexcept
{
    const Vec3d gap = device.translation - body.translation, turn = rotation_vector(device.rotation * transpose(body.rotation));
    const double mass[2] = {o.mass, o.inertia}, k[2] = {o.coupling_stiffness, o.coupling_rotational},
                 b[2] = {o.coupling_damping, o.coupling_rotational_damping};
    const Vec3d stretch[2] = {gap, turn}, speed[2] = {body_twist.linear, body_twist.angular},
                device_speed[2] = {device_twist.linear, device_twist.angular}, push[2] = {load.wrench.force, load.wrench.torque};

    // (M + h B + h^2 (K + K_contact)) v' = M v + h (K stretch + B v_device + contact): backward Euler.
    double a[6][6], x[6];
    for (int i = 0; i < 6; ++i) {
        const int g = i / 3;
        for (int j = 0; j < 6; ++j) a[i][j] = dt * dt * load.stiffness[i][j];
        a[i][i] += mass[g] + dt * b[g] + dt * dt * k[g];
        x[i] = mass[g] * speed[g][i % 3] + dt * (k[g] * stretch[g][i % 3] + b[g] * device_speed[g][i % 3] + push[g][i % 3]);
    }
    // Cholesky: the matrix is symmetric and positive definite.
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
    const Twist moved{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
    if (!is_finite(moved)) return false;
    body.translation += dt * moved.linear;
    body.rotation = orthonormal(rotation_by(dt * moved.angular) * body.rotation);
    body_twist = moved;
    const Vec3d left = rotation_vector(body.rotation * transpose(device.rotation));
    on_hand.force = k[0] * (body.translation - device.translation) + b[0] * (moved.linear - device_twist.linear);
    on_hand.torque = k[1] * left + b[1] * (moved.angular - device_twist.angular);
    return true;
}

}  // namespace sqmap::haptic
