#include "viewer/server/scene/geometry.h"

#include "common/render/unrolled.h"
#include "sqmap/math/assert.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/model.h"
#include "viewer/server/protocol/bytes.h"

#include <optional>

namespace sqmap::viewer {
namespace {

/// A part's map as a picture. The grid of a paper map is thinned only where it is wider than eight faces.
app::Unrolled unrolled(const model::ModelView& view, std::uint32_t part, int side)
{
    if (!paper::is_paper(view)) return app::unrolled_central(view, part, side);
    const paper::MapView map = paper::map_of(view, part);
    const std::uint32_t thin = (map.omega_count - 1) / static_cast<std::uint32_t>(8 * side) + 1;
    return app::unrolled_normal(view, part, static_cast<int>(map.omega_count / thin), static_cast<int>(map.eta_count / thin));
}

}  // namespace

std::string mesh_bytes(const Object& object, const Parts& parts)
{
    Bytes out("SQM1");
    out.count(object.mesh.vertices.size());
    out.count(object.mesh.triangles.size());
    out.count(parts.partition.part_count);
    for (const Vec3d& v : object.mesh.vertices) out.point(object.world(v));
    out.corners(object.mesh.triangles);
    for (const std::uint32_t p : parts.partition.part_of_triangle) out.put(p);
    return out.take();
}

std::string superquadric_bytes(const Object& object, const Parts& parts, int segments)
{
    Bytes out("SQS1");
    out.count(parts.superquadrics.size());
    for (const shape::Superquadricd& s : parts.superquadrics) {
        const mesh::Mesh surface = mesh::superquadric_surface(s, segments);
        out.count(surface.vertices.size());
        out.count(surface.triangles.size());
        for (const Vec3d& v : surface.vertices) out.point(object.world(v));
        out.corners(surface.triangles);
    }
    return out.take();
}

std::string sample_bytes(const Object& object)
{
    Bytes out("SQP1");
    std::vector<Vec3f> points;
    std::vector<std::uint32_t> part_of;
    for (std::uint32_t index = 0; index < object.view.parts.size(); ++index) {
        const auto add = [&](std::optional<Vec3f> point) {
            if (!point) return;
            points.push_back(object.world(cast<double>(*point)));
            part_of.push_back(index);
        };
        if (paper::is_paper(object.view)) {
            const paper::MapView map = paper::map_of(object.view, index);
            const std::uint32_t every = 1u << map.subdivisions;
            for (std::uint32_t row = 0; row < map.eta_count; row += every)
                for (std::uint32_t column = 0; column < map.omega_count; column += every)
                    add(app::mapped_sample(map, row, column));
            continue;
        }
        const model::Part& part = object.view.parts[index];
        for (std::uint32_t i = 0; i < part.samples.count; ++i) add(model::sample_point(object.view, part, i));
    }
    out.count(points.size());
    for (const Vec3f& p : points) out.point(p);
    for (const std::uint32_t p : part_of) out.put(p);
    return out.take();
}

std::string map_bytes(const Object& object, std::uint32_t part, int side)
{
    SQMAP_ASSERT(part < object.view.parts.size());
    const app::Unrolled map = unrolled(object.view, part, side);
    Bytes out("SQU1");
    out.count(static_cast<std::size_t>(map.width));
    out.count(static_cast<std::size_t>(map.height));
    const auto metres = static_cast<float>(object.metres_per_model_unit());
    for (std::size_t i = 0; i < map.distance.size(); ++i) {
        const bool hit = map.distance[i] >= 0;
        out.put(hit ? metres * map.distance[i] : map.distance[i]);
        out.point(hit ? object.world(cast<double>(map.surface[i])) : Vec3f{});
    }
    return out.take();
}

}  // namespace sqmap::viewer
