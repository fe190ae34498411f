#include "touch/objects.h"

#include <cmath>
#include <numbers>

namespace sqmap::app {
namespace {

/// Axis times angle, 0 to less than pi.
Vec3d turn_of(const Mat3d& m)
{
    const Vec3d s = 0.5 * Vec3d{m.row[2].y - m.row[1].z, m.row[0].z - m.row[2].x, m.row[1].x - m.row[0].y};
    const double sine = norm(s);
    return sine > 1e-9 ? std::atan2(sine, 0.5 * (m.row[0].x + m.row[1].y + m.row[2].z - 1)) / sine * s : s;
}

/// m turned further by |by| about by, and still a rotation: to first order, which a tick's turn is.
Mat3d turned(const Mat3d& m, const Vec3d& by)
{
    Vec3d x{m.row[0].x, m.row[1].x, m.row[2].x}, y{m.row[0].y, m.row[1].y, m.row[2].y};
    x = normalized(x + cross(by, x));
    y += cross(by, y);
    y = normalized(y - dot(x, y) * x);
    const Vec3d z = cross(x, y);
    return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}};
}

}  // namespace

MovingObjects::MovingObjects(const TouchOptions& options, std::span<haptic::TouchedBody> solids) : options_(options.body)
{
    for (std::size_t i = 0; i < solids.size(); ++i) {
        const model::Header& h = solids[i].model->header;
        const double radius = 0.5 * h.unit * h.r_max;
        bodies_.push_back({.position = options.objects[i].position,
                           .centre = {h.origin[0], h.origin[1], h.origin[2]},
                           .inertia = 0.4 * options_.mass * radius * radius});
        put(bodies_.back(), solids[i]);
    }
}

void MovingObjects::put(const Body& b, haptic::TouchedBody& solid) const noexcept
{
    const double phase = 2 * std::numbers::pi * time_ / options_.sway_period;
    const Vec3d centre = b.position + std::sin(phase) * options_.sway + b.off;
    const Vec3d speed = (2 * std::numbers::pi / options_.sway_period * std::cos(phase)) * options_.sway + b.speed;
    const Vec3d arm = b.turn * b.centre;  // from the mesh's origin to the centre
    solid.pose = {b.turn, centre - arm};
    solid.twist = {speed - cross(b.spin, arm), b.spin};
}

/// Backward Euler in spring and damper, what touches held over the tick.
void MovingObjects::move(double dt, std::span<const haptic::Wrench> pushes, std::span<haptic::TouchedBody> solids) noexcept
{
    time_ += dt;
    const BodyOptions& o = options_;
    if (!(o.mass > 0) && norm_sq(o.sway) == 0) return;
    for (std::size_t i = 0; i < solids.size(); ++i) {
        Body& b = bodies_[i];
        if (o.mass > 0) {
            const double per_mass = o.spring / o.mass, drag = 2 * std::sqrt(per_mass);
            const double give = 1 / (1 + dt * drag + dt * dt * per_mass);
            const haptic::Wrench& push = pushes[i];
            const Vec3d torque = push.torque - cross(b.turn * b.centre, push.force);
            b.speed = give * (b.speed + dt * (push.force / o.mass - per_mass * b.off));
            b.spin = give * (b.spin + dt * (torque / b.inertia - per_mass * turn_of(b.turn)));
            b.off += dt * b.speed;
            b.turn = turned(b.turn, dt * b.spin);
        }
        put(b, solids[i]);
    }
}

}  // namespace sqmap::app
