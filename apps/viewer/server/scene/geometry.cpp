// Bytes that the page draws: triangles, superquadrics, fields over the surface, unrolled maps, and the same as binary glTF.
#include "common/render/unrolled.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/point.h"
#include "viewer/server/protocol/bytes.h"
#include "viewer/server/scene/displacement.h"
#include "viewer/server/scene/object.h"

#include <cmath>
#include <limits>

namespace sqmap::viewer {
namespace {

query::Layer layer_of(Field field) { return field == Field::ErrorOfTwo ? query::Layer::Two : query::Layer::Three; }

/// |depth by the field's layer - exact depth| below a triangle's middle, percent of R_max; -1 missed, -2 too thin to say.
float depth_error(const Object& object, const mesh::Solid& solid, std::uint32_t triangle, Field field)
{
    const auto& [i, j, k] = object.mesh.triangles[triangle];
    const auto& v = object.mesh.vertices;
    const Vec3d normal = normalized(cross(v[j] - v[i], v[k] - v[i]));
    const Vec3d middle = mesh::triangle_centroid(object.mesh, triangle);
    const double r_max = object.view.header.r_max;
    for (double below = 0.01; below > 0.001; below /= 2) {
        const Vec3d p = middle - below * r_max * normal;
        if (!solid.inside(p)) continue;
        const query::PointResult contact = query::query_point(model::normalized(object.view), p, {.layer = layer_of(field)});
        if (!contact.contact) return -1;
        return static_cast<float>(100 * std::abs(contact.depth - solid.closest_boundary(p).distance) / r_max);
    }
    return -2;
}

float projection_error(const Object& object, std::uint32_t triangle, Field field)
{
    const std::optional<double> distance =
        query::distance_along_projection(model::normalized(object.view), object.parts.partition.part_of_triangle[triangle],
                                         mesh::triangle_centroid(object.mesh, triangle), layer_of(field));
    return distance ? static_cast<float>(100 * std::abs(*distance) / object.view.header.r_max) : -2;
}

/// Of the paper's map the grid as it is, as long as that is no wider than eight faces.
app::Unrolled unrolled(const model::ModelView& view, std::uint32_t part, int side)
{
    if (!model::is_normal(view)) return app::unrolled_central(view, part, side);
    const model::NormalMapView map = model::normal_map_of(view, part);
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
    for (const mesh::Triangle& t : object.mesh.triangles)
        for (const std::uint32_t v : t) out.put(v);
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
        for (const mesh::Triangle& t : surface.triangles)
            for (const std::uint32_t v : t) out.put(v);
    }
    return out.take();
}

std::string field_bytes(const Object& object, Field field)
{
    Bytes out("SQF1");
    const auto count = static_cast<std::uint32_t>(object.mesh.triangles.size());
    out.count(count);
    if (count == 0) return out.take();
    if (field == Field::MadeUp) {
        const std::vector<std::uint8_t> made_up = made_up_triangles(object);
        for (std::uint32_t t = 0; t < count; ++t) out.put(!made_up.empty() && made_up[t] != 0 ? 1.f : 0.f);
        return out.take();
    }
    if (field == Field::Error || field == Field::ErrorOfTwo) {
        if (object.view.header.solid == 0) {
            for (std::uint32_t t = 0; t < count; ++t) out.put(projection_error(object, t, field));
            return out.take();
        }
        const mesh::Solid solid(object.mesh, mesh::find_self_intersections(object.mesh).crossed);
        for (std::uint32_t t = 0; t < count; ++t) out.put(depth_error(object, solid, t, field));
        return out.take();
    }
    const decompose::Decomposition d = decompose::decompose_with_diagnostics(object.mesh);
    const double r_max = object.view.header.r_max;
    for (std::uint32_t t = 0; t < count; ++t)
        out.put(static_cast<float>(field == Field::Protrusion ? d.protrusion[t] : d.curvature[t] * r_max * r_max));
    return out.take();
}

std::string difference_bytes(const Object& object, const Object& other)
{
    Bytes out("SQF1");
    out.count(object.mesh.triangles.size());
    const model::Header& h = object.view.header;
    for (std::uint32_t t = 0; t < object.mesh.triangles.size(); ++t) {
        const auto& [i, j, k] = object.mesh.triangles[t];
        const auto& v = object.mesh.vertices;
        const Vec3d normal = normalized(cross(v[j] - v[i], v[k] - v[i]));
        const Vec3d below = mesh::triangle_centroid(object.mesh, t) - 0.01 * h.r_max * normal;
        const Vec3d p = h.unit * below + Vec3d{h.origin[0], h.origin[1], h.origin[2]};
        const query::PointResult a = query::query_point(object.view, p), b = query::query_point(other.view, p);
        out.put(a.contact != b.contact ? -1.f
                : !a.contact           ? -2.f
                                       : static_cast<float>(100 * std::abs(a.depth - b.depth) / (h.r_max * h.unit)));
    }
    return out.take();
}

std::string map_bytes(const Object& object, std::uint32_t part, int side)
{
    const app::Unrolled map = unrolled(object.view, part, side);
    Bytes out("SQU1");
    out.count(static_cast<std::size_t>(map.width));
    out.count(static_cast<std::size_t>(map.height));
    const auto metres = static_cast<float>(object.view.header.unit * object.metres_per_unit);
    for (std::size_t i = 0; i < map.distance.size(); ++i) {
        const bool hit = map.distance[i] >= 0;
        out.put(hit ? metres * map.distance[i] : map.distance[i]);
        out.point(hit ? object.world(cast<double>(map.surface[i])) : Vec3f{});
    }
    return out.take();
}

}  // namespace sqmap::viewer
