#include "viewer/server/touch/feet.h"

#include "common/render/unrolled.h"
#include "sqmap/math/assert.h"
#include "sqmap/paper/projection.h"

namespace sqmap::viewer {

std::optional<Foot> foot_of(const Object& object, std::uint32_t part, Vec3d point)
{
    const Vec3f p = object.model_space(point);
    Foot out{.part = part};
    if (paper::is_paper(object.view)) {
        const paper::MapView map = paper::map_of(object.view, part);
        const shape::Foot<float> foot = paper::find_foot(map, p, paper::Projector::Newton);
        const app::MapPosition at = app::position_on_grid(map, shape::angles_of(foot.position));
        out.x = at.x, out.y = at.y;
        return out;
    }
    const std::optional<app::MapPosition> at = app::position_on_cross(object.view.parts[part], p);
    if (!at) return std::nullopt;
    out.x = at->x, out.y = at->y;
    return out;
}

std::vector<Foot> feet_of(const Forces& forces, const sqmap::Pose& pose, std::size_t object, query::Layer layer)
{
    SQMAP_ASSERT(object < forces.objects().size());
    const ObjectPtr& touched = forces.objects()[object];
    std::vector<Foot> out;
    if (touched == nullptr) return out;
    std::vector<query::Contact> contacts(forces.points().size());
    const query::ProbeResult result = query::query_probe({.model = &touched->metres, .pose = touched->pose()},
                                                         {.probe = &forces.probe(), .pose = pose}, {.layer = layer}, contacts);
    const std::span<const query::Contact> found = result.written(contacts);
    const std::size_t every = found.size() / k_max_feet + 1;
    for (std::size_t i = 0; i < found.size(); i += every) {
        const query::Contact& contact = found[i];
        if (contact.part < 0) continue;
        std::optional<Foot> foot =
            foot_of(*touched, static_cast<std::uint32_t>(contact.part), apply(pose, forces.points()[contact.index]));
        if (!foot) continue;
        foot->depth = contact.depth;
        out.push_back(*foot);
    }
    return out;
}

}  // namespace sqmap::viewer
