#include "viewer/server/scene/fields.h"

#include "decompose/locales.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/math/assert.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/paper/model.h"
#include "sqmap/paper/projection.h"
#include "sqmap/query/point.h"
#include "viewer/server/protocol/bytes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace sqmap::viewer {
namespace {

query::Layer layer_of(Field field) { return field == Field::ErrorOfTwo ? query::Layer::Two : query::Layer::Three; }

constexpr double k_judged = bake::EvaluateOptions{}.verdict_band;  // of R_max: the bake counts no verdict nearer to the surface

/// |depth by the field's layer - exact depth| below a triangle's middle, percent of R_max; -1 missed, -2 too thin to say. A point
/// is missed as the bake counts it: a layer calls it free that lies farther inside than k_judged. One that lies nearer to the
/// surface and is called free has depth 0.
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
        const double exact = solid.closest_boundary(p).distance;
        if (!contact.contact && exact > k_judged * r_max) return -1;
        return static_cast<float>(100 * std::abs((contact.contact ? contact.depth : 0) - exact) / r_max);
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

/// The ray of a part's projection to a point begins at the centre of its chart, or just outside the point's foot.
Vec3d projection_origin(const model::ModelView& view, std::uint32_t part, Vec3d point)
{
    if (!paper::is_paper(view)) return cast<double>(model::vec3(view.parts[part].chart_centre));
    const shape::Foot<float> foot = paper::find_foot(paper::map_of(view, part), cast<float>(point), paper::Projector::Newton);
    return cast<double>(foot.point) + 1e-5 * view.header.r_max * cast<double>(foot.normal);
}

/// Number and Boundary Strength of the locale that a triangle's middle is in: see Field.
void put_locales(const Object& object, const decompose::Decomposition& found, Field field, Bytes& out)
{
    constexpr float k_no_locale = -2, k_no_strength = -20;
    const decompose::LocaleBands bands = decompose::locale_bands(object.mesh, found, decompose::printed_cuts());
    for (std::uint32_t t = 0; t < object.mesh.triangles.size(); ++t) {
        const std::uint32_t feature = bands.feature[t];
        if (feature == decompose::LocaleBands::k_none) {
            out.put(field == Field::Locales ? k_no_locale : k_no_strength);
            continue;
        }
        double distance = 0;
        for (const std::uint32_t corner : object.mesh.triangles[t]) distance += bands.distance[corner] / 3;
        const std::size_t locale = std::min(static_cast<std::size_t>(distance / bands.width), bands.strength[feature].size() - 1);
        out.put(field == Field::Locales ? static_cast<float>(2 * feature + locale % 2)
                                        : static_cast<float>(bands.strength[feature][locale]));
    }
}

void put_regions(const Object& object, Bytes& out)
{
    std::span<const std::uint16_t> labels;
    if (paper::is_paper(object.view)) labels = paper::Reading::of(object.view).model().maps.labels;
    const bool is_known = labels.size() == object.mesh.triangles.size();
    for (std::size_t t = 0; t < object.mesh.triangles.size(); ++t)
        out.put(is_known ? static_cast<float>(paper::decode_label(labels[t]).region) : -2.f);
}

}  // namespace

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
    if (field == Field::Regions) {
        put_regions(object, out);
        return out.take();
    }
    const decompose::Decomposition d = decompose::decompose_with_diagnostics(object.mesh);
    if (field == Field::Locales || field == Field::Strength) {
        put_locales(object, d, field, out);
        return out.take();
    }
    const double r_max = object.view.header.r_max;
    for (std::uint32_t t = 0; t < count; ++t)
        out.put(static_cast<float>(field == Field::Protrusion ? d.protrusion[t] : d.curvature[t] * r_max * r_max));
    return out.take();
}

std::string difference_bytes(const Object& object, const Object& other)
{
    SQMAP_ASSERT(are_of_one_mesh(object, other));
    Bytes out("SQF1");
    out.count(object.mesh.triangles.size());
    const model::Header& h = object.view.header;
    for (std::uint32_t t = 0; t < object.mesh.triangles.size(); ++t) {
        const auto& [i, j, k] = object.mesh.triangles[t];
        const auto& v = object.mesh.vertices;
        const Vec3d normal = normalized(cross(v[j] - v[i], v[k] - v[i]));
        const Vec3d below = mesh::triangle_centroid(object.mesh, t) - 0.01 * h.r_max * normal;
        const Vec3d p = h.unit * below + object.frame().origin;
        const query::PointResult a = query::query_point(object.view, p), b = query::query_point(other.view, p);
        out.put(a.contact != b.contact ? -1.f
                : !a.contact           ? -2.f
                                       : static_cast<float>(100 * std::abs(a.depth - b.depth) / (h.r_max * h.unit)));
    }
    return out.take();
}

std::string hidden_bytes(const Object& object)
{
    Bytes out("SQF1");
    out.count(object.mesh.triangles.size());
    if (object.mesh.triangles.empty()) return out.take();
    const mesh::Bvh bvh(object.mesh);
    const auto winding_at = [&](Vec3d p) { return object.view.header.solid != 0 ? bvh.winding_number(p) : 0; };
    const bool is_paper_model = paper::is_paper(object.view);
    std::vector<int> start;  // of charts: all rays of one begin at its centre
    for (std::uint32_t i = 0; !is_paper_model && i < object.view.parts.size(); ++i)
        start.push_back(winding_at(projection_origin(object.view, i, {})));
    std::vector<mesh::Bvh::Crossing> crossings;
    for (std::uint32_t t = 0; t < object.mesh.triangles.size(); ++t) {
        const std::uint32_t p = object.parts.partition.part_of_triangle[t];
        const Vec3d centre = projection_origin(object.view, p, mesh::triangle_centroid(object.mesh, t));
        if (!bvh.ray_crossings(centre, mesh::triangle_centroid(object.mesh, t) - centre, crossings)) {
            out.put(-2.f);
            continue;
        }
        // Seen where the first change of verdict on the ray is at the triangle itself: as bake counts it (max_q2_share). A
        // surface without inside changes it at every crossing.
        int winding = is_paper_model ? winding_at(centre) : start[p];
        bool seen = false;
        for (const mesh::Bvh::Crossing& c : crossings) {
            const int next = winding - c.sign;
            if (object.view.header.solid == 0 || (next > 0) != (winding > 0)) {
                seen = c.triangle == t;
                break;
            }
            winding = next;
        }
        out.put(seen ? 0.f : 1.f);
    }
    return out.take();
}

std::string offset_bytes(const Object& object)
{
    Bytes out("SQF1");
    out.count(object.mesh.vertices.size());
    std::vector<Vec3d> normal(object.mesh.vertices.size());
    for (const auto& [i, j, k] : object.mesh.triangles) {
        const auto& v = object.mesh.vertices;
        const Vec3d n = cross(v[j] - v[i], v[k] - v[i]);
        for (const std::uint32_t c : {i, j, k}) normal[c] += n;
    }
    const double r_max = object.view.header.r_max, metres = object.metres_per_model_unit();
    const model::ModelView model = model::normalized(object.view);
    for (std::size_t v = 0; v < normal.size(); ++v) {
        const double length = norm(normal[v]);
        // A hair below the surface, so that both questions are about the same contact.
        const Vec3d p = object.mesh.vertices[v] - (length > 0 ? 2e-3 * r_max / length : 0) * normal[v];
        const query::PointResult as_is = query::query_point(model, p), moved = query::query_point(model, p, {.offset = true});
        out.put(as_is.contact && moved.contact ? static_cast<float>(metres * std::max(0.0, moved.depth - as_is.depth)) : 0.f);
    }
    return out.take();
}

}  // namespace sqmap::viewer
