#include "viewer/server/touch/frame.h"

#include "sqmap/query/point.h"

#include <cmath>

namespace sqmap::viewer {

void set_contact(TouchFrame& frame, const sqmap::Pose& device, const Forces::Found& found, std::span<const ObjectPtr> objects)
{
    const sqmap::Pose& drawn = found.contacts > 0 ? found.body : device;
    frame.tool = drawn.translation;
    frame.turn = drawn.rotation;
    frame.hand = device.translation;
    if (found.contacts == 0) return;
    frame.contacts = found.contacts;
    frame.depth = found.depth;
    frame.point = found.point;
    frame.normal = found.normal;
    // The surface belongs to the object that holds a point below it: in a crease the middle of the contacts may lie off the
    // surface.
    for (const double below : {2e-4, 1e-3, 2e-3, 4e-3, 8e-3, 16e-3})
        for (std::size_t i = 0; i < objects.size() && frame.object < 0; ++i) {
            if (objects[i] == nullptr) continue;
            const Vec3d in_metres = apply(inverse(objects[i]->pose()), frame.point - below * frame.normal);
            const query::PointResult contact = query::query_point(objects[i]->metres, in_metres);
            if (!contact.contact) continue;
            frame.object = static_cast<int>(i);
            frame.part = contact.part;
        }
}

std::vector<float> frame_floats(const TouchFrame& f, std::uint64_t number, std::size_t recorded)
{
    std::vector<float> out{1, static_cast<float>(number & 0xffff)};
    const auto vector = [&](Vec3d v) {
        for (int k = 0; k < 3; ++k) out.push_back(static_cast<float>(v[k]));
    };
    vector(f.tool);
    vector(f.force);
    vector(f.torque);
    vector(f.point);
    vector(f.normal);
    for (const double x :
         {f.depth, static_cast<double>(f.contacts), static_cast<double>(f.object), static_cast<double>(f.part),
          static_cast<double>(f.acted), static_cast<double>(f.faults), f.late * 1e3, f.degraded ? 1.0 : 0.0,
          f.engaged ? 1.0 : 0.0, f.connected ? 1.0 : 0.0, static_cast<double>(f.ticks.size()), static_cast<double>(recorded)})
        out.push_back(static_cast<float>(x));
    for (int row = 0; row < 3; ++row) vector(f.turn.row[row]);
    vector(f.hand);
    // A float alone would lose the milliseconds of an hour.
    const double whole = std::floor(f.time);
    out.insert(out.end(), {static_cast<float>(whole), static_cast<float>(f.time - whole)});
    for (const TickPoint& t : f.ticks) out.insert(out.end(), {t.force, t.torque, t.depth, t.cpu, t.since});
    return out;
}

}  // namespace sqmap::viewer
