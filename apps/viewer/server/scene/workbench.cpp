// What the workbench shows and does beside pictures of the parts: hidden surface, samples, the offset, moved cuts.
#include "common/render/unrolled.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/query/normal_projection.h"
#include "sqmap/query/point.h"
#include "viewer/server/protocol/bytes.h"
#include "viewer/server/scene/object.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <queue>

namespace sqmap::viewer {

namespace {

/// Where the ray of a part's projection to a point begins: the centre of its chart, or just outside the point's foot.
Vec3d projection_origin(const model::ModelView& view, std::uint32_t part, Vec3d point)
{
    if (!model::is_normal(view)) return cast<double>(model::vec3(view.parts[part].chart_centre));
    const shape::Foot<float> foot =
        query::find_foot(model::normal_map_of(view, part), cast<float>(point), query::Projector::Newton);
    return cast<double>(foot.point) + 1e-5 * view.header.r_max * cast<double>(foot.normal);
}

}  // namespace

std::string hidden_bytes(const Object& object)
{
    Bytes out("SQF1");
    out.count(object.mesh.triangles.size());
    if (object.mesh.triangles.empty()) return out.take();
    const mesh::Bvh bvh(object.mesh);
    const auto winding_at = [&](Vec3d p) { return object.view.header.solid != 0 ? bvh.winding_number(p) : 0; };
    const bool is_normal = model::is_normal(object.view);
    std::vector<int> start;  // of charts: all rays of one begin at its centre
    for (std::uint32_t i = 0; !is_normal && i < object.view.parts.size(); ++i)
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
        int winding = is_normal ? winding_at(centre) : start[p];
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
        if (model::is_normal(object.view)) {
            const model::NormalMapView map = model::normal_map_of(object.view, index);
            const std::uint32_t every = 1u << map.subdivisions;
            for (std::uint32_t row = 0; row < map.eta_count; row += every)
                for (std::uint32_t column = 0; column < map.omega_count; column += every)
                    add(app::mapped_sample(map, row, column));
            continue;
        }
        const model::Part& part = object.view.parts[index];
        for (std::uint32_t i = 0; i < part.sample_count; ++i) add(model::sample_point(object.view, part, i));
    }
    out.count(points.size());
    for (const Vec3f& p : points) out.point(p);
    for (const std::uint32_t p : part_of) out.put(p);
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
    const double r_max = object.view.header.r_max, metres = object.view.header.unit * object.metres_per_unit;
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

std::vector<std::vector<std::uint32_t>> neighbours_of(const Object& object, const decompose::Partition& partition)
{
    std::vector<std::vector<std::uint32_t>> out(partition.part_count);
    for (std::uint32_t t = 0; t < object.dual.neighbours.size(); ++t)
        for (const std::uint32_t n : object.dual.neighbours[t]) {
            if (n == mesh::k_no_triangle) continue;
            const std::uint32_t a = partition.part_of_triangle[t], b = partition.part_of_triangle[n];
            if (a != b && std::find(out[a].begin(), out[a].end(), b) == out[a].end()) out[a].push_back(b);
        }
    for (auto& list : out) std::sort(list.begin(), list.end());
    return out;
}

std::optional<decompose::Partition> moved_cut(const Object& object, const decompose::Partition& partition, std::uint32_t part,
                                              std::uint32_t other, double distance)
{
    const std::vector<std::uint32_t>& label = partition.part_of_triangle;
    const double reach = distance / (object.view.header.unit * object.metres_per_unit);  // model units
    const std::size_t n = label.size();
    struct Reach {
        double distance;
        std::uint32_t triangle;
        bool operator<(const Reach& o) const { return distance > o.distance; }
    };
    // Along the surface, from the border into the other part.
    std::vector<std::uint8_t> taken(n, 0);
    std::priority_queue<Reach> queue;
    for (std::uint32_t t = 0; t < n; ++t)
        for (const std::uint32_t next : object.dual.neighbours[t])
            if (label[t] == other && next != mesh::k_no_triangle && label[next] == part) queue.push({0, t});
    if (queue.empty()) return std::nullopt;  // no cut between them
    std::size_t count = 0;
    while (!queue.empty()) {
        const Reach at = queue.top();
        queue.pop();
        if (taken[at.triangle] != 0) continue;
        taken[at.triangle] = 1;
        ++count;
        for (const std::uint32_t next : object.dual.neighbours[at.triangle]) {
            if (next == mesh::k_no_triangle || label[next] != other || taken[next] != 0) continue;
            const double along = at.distance + norm(mesh::triangle_centroid(object.mesh, next) -
                                                    mesh::triangle_centroid(object.mesh, at.triangle));
            if (along <= reach) queue.push({along, next});
        }
    }
    // The largest piece that is left stays the other part; smaller ones that the cut leaves behind go with it.
    std::vector<std::uint32_t> piece(n, 0);
    std::uint32_t pieces = 0, largest = 0;
    std::size_t max = 0;
    std::vector<std::uint32_t> stack;
    for (std::uint32_t t = 0; t < n; ++t) {
        if (label[t] != other || taken[t] != 0 || piece[t] != 0) continue;
        piece[t] = ++pieces;
        stack = {t};
        std::size_t size = 0;
        while (!stack.empty()) {
            const std::uint32_t at = stack.back();
            stack.pop_back();
            ++size;
            for (const std::uint32_t next : object.dual.neighbours[at])
                if (next != mesh::k_no_triangle && label[next] == other && taken[next] == 0 && piece[next] == 0) {
                    piece[next] = pieces;
                    stack.push_back(next);
                }
        }
        if (size > max) max = size, largest = pieces;
    }
    constexpr std::size_t k_least = 16;  // triangles: fewer are no part
    if (max < k_least) return std::nullopt;
    decompose::Partition out = partition;
    out.boundaries.clear();
    for (std::uint32_t t = 0; t < n; ++t)
        if (label[t] == other && piece[t] != largest) out.part_of_triangle[t] = part;
    return out;
}

}  // namespace sqmap::viewer
