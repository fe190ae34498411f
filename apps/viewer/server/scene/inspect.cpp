#include "viewer/server/scene/inspect.h"

#include "common/layer_name.h"
#include "common/render/unrolled.h"
#include "sqmap/math/assert.h"
#include "sqmap/paper/projection.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/point.h"
#include "viewer/server/protocol/bytes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

constexpr int k_side = 128;                // points of F along each edge of a section
constexpr std::size_t k_max_steps = 4096;  // of a search: the whole grid coarsely, then downhill
constexpr double k_margin = 1.15;          // of the part's sphere
constexpr float k_max_f = 1e6f;            // far outside a superquadric with sharp edges F is beyond float

ordered_json status_json(std::uint8_t status)
{
    constexpr std::pair<std::uint8_t, const char*> k_words[] = {{query::k_no_exact, "no triangles stored: layer 3"},
                                                                {query::k_no_surface, "no map shows the surface"},
                                                                {query::k_made_up, "the surface there is made up"},
                                                                {paper::k_not_given, "not of this projection"}};
    ordered_json out = ordered_json::array();
    for (const auto& [bit, words] : k_words)
        if ((status & bit) != 0) out.push_back(words);
    return out;
}

/// A square of the plane, model space: corner + x along + y up, x and y from 0 to 1.
struct Square {
    Vec3d corner, along, up, normal;

    Square(const Object& object, const Parts& parts, const SectionPlane& plane)
    {
        const shape::Superquadricd& s = parts.superquadrics[plane.part];
        const auto axis = [&](int k) { return s.rotation.row[(plane.axis + k) % 3]; };
        normal = axis(0);
        const Vec3d through = cast<double>(object.model_space(plane.through));
        const auto& [centre, radius] = parts.spheres[plane.part];
        const double half = k_margin * radius;
        const Vec3d middle = centre + dot(through - centre, normal) * normal;
        along = 2 * half * axis(1);
        up = 2 * half * axis(2);
        corner = middle - 0.5 * (along + up);
    }
    [[nodiscard]] Vec3d at(double x, double y) const { return corner + x * along + y * up; }
    [[nodiscard]] std::array<float, 2> shares(Vec3d p) const
    {
        const Vec3d d = p - corner;
        return {static_cast<float>(dot(d, along) / norm_sq(along)), static_cast<float>(dot(d, up) / norm_sq(up))};
    }
};

struct Cut {
    std::uint32_t part = 0;
    std::array<float, 2> from{}, to{};
};

/// The plane's cuts through triangles within the square.
std::vector<Cut> cuts_of(const Object& object, const Parts& parts, const Square& square)
{
    std::vector<Cut> out;
    std::vector<double> above;
    for (const Vec3d& v : object.mesh.vertices) above.push_back(dot(v - square.corner, square.normal));
    for (std::uint32_t t = 0; t < object.mesh.triangles.size(); ++t) {
        const mesh::Triangle& corners = object.mesh.triangles[t];
        std::vector<std::array<float, 2>> ends;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = corners[k], b = corners[(k + 1) % 3];
            if ((above[a] < 0) == (above[b] < 0)) continue;
            const double share = above[a] / (above[a] - above[b]);
            ends.push_back(square.shares(object.mesh.vertices[a] + share * (object.mesh.vertices[b] - object.mesh.vertices[a])));
        }
        const auto inside = [](const std::array<float, 2>& p) { return std::min(p[0], p[1]) > 0 && std::max(p[0], p[1]) < 1; };
        if (ends.size() == 2 && (inside(ends[0]) || inside(ends[1])))
            out.push_back({parts.partition.part_of_triangle[t], ends[0], ends[1]});
    }
    return out;
}

}  // namespace

ordered_json answers_json(const Object& object, Vec3d point)
{
    std::vector<query::Layer> layers{query::Layer::One, query::Layer::Two, query::Layer::Three};
    if (model::has_exact(object.metres)) layers.push_back(query::Layer::Exact);
    ordered_json out{{"projection", paper::is_paper(object.view) ? "normal" : "central"}, {"layers", ordered_json::array()}};
    for (const query::Layer layer : layers) {
        const query::PointResult r =
            query::query_point({.model = &object.metres, .pose = object.pose()}, point, {.layer = layer});
        out["layers"].push_back({{"layer", app::layer_name(layer)},
                                 {"contact", r.contact},
                                 {"certain", r.certain},
                                 {"depth", r.depth},
                                 {"normal", {r.normal.x, r.normal.y, r.normal.z}},
                                 {"part", r.part},
                                 {"status", status_json(r.status)}});
    }
    return out;
}

ordered_json search_json(const Object& object, std::uint32_t part, Vec3d point)
{
    SQMAP_ASSERT(paper::is_paper(object.view) && part < object.view.parts.size());
    constexpr std::pair<paper::Projector, const char*> k_projectors[] = {
        {paper::Projector::Newton, "newton"}, {paper::Projector::Pyramid, "pyramid"}, {paper::Projector::Printed, "printed"}};
    const paper::MapView map = paper::map_of(object.view, part);
    const Vec3f p = object.model_space(point);
    const double metres = object.metres_per_model_unit();
    ordered_json out{{"held", false}, {"grid", {map.eta_count, map.omega_count}}, {"searches", ordered_json::array()}};
    for (const auto& [projector, name] : k_projectors) {
        std::vector<paper::FootSearchStep> steps(k_max_steps);
        steps.resize(std::min(k_max_steps, paper::record_foot_search(map, p, projector, steps)));
        if (steps.empty()) return out;
        const paper::PartAnswer answer = paper::project(map, p, {.projector = projector});
        ordered_json search{
            {"projector", name},
            {"contact", answer.verdict == paper::Verdict::Contact},
            {"proven", (answer.flags & paper::k_projection_unproven) == 0},
            {"wide", (answer.flags & paper::k_projection_wide) != 0},
            {"footDistance", metres * static_cast<double>(answer.foot_distance)},
            {"mapDistance", std::isfinite(answer.map_distance) ? ordered_json(metres * static_cast<double>(answer.map_distance))
                                                               : ordered_json()},
            {"depth", metres * static_cast<double>(answer.depth)},
            {"steps", ordered_json::array()}};
        for (const paper::FootSearchStep& step : steps) {
            const app::MapPosition at = app::position_on_grid(map, step.angles);
            const Vec3f on = object.world(cast<double>(shape::surface_point(map.superquadric, step.angles).point));
            search["steps"].push_back({at.x, at.y, on.x, on.y, on.z, metres * static_cast<double>(step.distance),
                                       step.collinearity, step.stride, step.better ? 1 : 0});
        }
        out["searches"].push_back(std::move(search));
    }
    out["held"] = true;
    return out;
}

std::string slice_bytes(const Object& object, int axis, Vec3d through)
{
    constexpr int k_slice_side = 144;
    constexpr double k_larger = 1.2, k_band = 0.1;  // m
    const int x = axis == 0 ? 2 : 0, y = axis == 1 ? 2 : 1;
    Vec3d corner = object.position - k_larger * object.half, along{}, up{};
    corner[axis] = through[axis];
    along[x] = 2 * k_larger * object.half[x];
    up[y] = 2 * k_larger * object.half[y];
    std::vector<Vec3d> points;
    for (int row = 0; row < k_slice_side; ++row)
        for (int column = 0; column < k_slice_side; ++column)
            points.push_back(corner + column / (k_slice_side - 1.) * along + row / (k_slice_side - 1.) * up);
    std::vector<query::SignedDistance> answers(points.size());
    query::distances(query::Body{&object.metres, nullptr, object.pose()}, points, answers, k_band);
    Bytes out("SLC1");
    out.count(k_slice_side);
    for (const Vec3d& v : {corner, along, up}) out.point(cast<float>(v));
    for (const query::SignedDistance& answer : answers) out.put(static_cast<float>(answer.distance));
    return out.take();
}

std::string section_bytes(const Object& object, const Parts& parts, const SectionPlane& plane)
{
    SQMAP_ASSERT(plane.part < object.view.parts.size());
    const Square square(object, parts, plane);
    const std::vector<Cut> cuts = cuts_of(object, parts, square);
    Bytes out("SQC1");
    out.count(k_side);
    out.count(cuts.size());
    const Vec3f corner = object.world(square.corner);
    out.point(corner);
    out.point(object.world(square.corner + square.along) - corner);
    out.point(object.world(square.corner + square.up) - corner);
    const auto put_least = [&](auto&& counts) {
        for (int y = 0; y < k_side; ++y)
            for (int x = 0; x < k_side; ++x) {
                const Vec3d p = square.at(x / (k_side - 1.0), y / (k_side - 1.0));
                double least = k_max_f;
                for (std::uint32_t i = 0; i < parts.superquadrics.size(); ++i)
                    if (counts(i)) least = std::fmin(least, shape::implicit(parts.superquadrics[i], p));
                out.put(static_cast<float>(least));
            }
    };
    put_least([&](std::uint32_t i) { return i == plane.part; });
    put_least([&](std::uint32_t i) { return i != plane.part; });
    for (const Cut& cut : cuts) {
        out.put(cut.part);
        for (const auto& end : {cut.from, cut.to})
            for (const float x : end) out.put(x);
    }
    return out.take();
}

}  // namespace sqmap::viewer
