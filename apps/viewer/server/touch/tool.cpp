#include "viewer/server/touch/tool.h"

#include "sqmap/math/box.h"
#include "sqmap/mesh/shapes.h"
#include "viewer/server/protocol/bytes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace sqmap::viewer {
namespace {

/// One vertex a cell of a grid: the mean of those in it.
mesh::Mesh clustered(const mesh::Mesh& in, double cell)
{
    std::map<std::array<std::int64_t, 3>, std::uint32_t> cells;
    std::vector<std::uint32_t> to(in.vertices.size());
    std::vector<double> count;
    mesh::Mesh out;
    for (std::size_t v = 0; v < in.vertices.size(); ++v) {
        std::array<std::int64_t, 3> key{};
        for (int k = 0; k < 3; ++k) key[static_cast<std::size_t>(k)] = std::llround(in.vertices[v][k] / cell);
        const auto [at, fresh] = cells.emplace(key, static_cast<std::uint32_t>(out.vertices.size()));
        if (fresh) {
            out.vertices.push_back({});
            count.push_back(0);
        }
        to[v] = at->second;
        out.vertices[at->second] += in.vertices[v];
        ++count[at->second];
    }
    for (std::size_t v = 0; v < out.vertices.size(); ++v) out.vertices[v] = out.vertices[v] / count[v];
    for (const auto& [i, j, k] : in.triangles)
        if (to[i] != to[j] && to[j] != to[k] && to[k] != to[i]) out.triangles.push_back({to[i], to[j], to[k]});
    return out;
}

mesh::Mesh shape_of(const Settings& settings, const Object* object)
{
    if (settings.tool == ToolKind::Hand) {
        static const mesh::Mesh k_hand = mesh::polygonized(mesh::hand_capsules(), 0.03);  // takes a second
        return k_hand;
    }
    mesh::Mesh out;
    out.triangles = object->mesh.triangles;
    for (const Vec3d& v : object->mesh.vertices) out.vertices.push_back(cast<double>(object->world(v)));
    return out;
}

}  // namespace

Tool make_tool(const Settings& settings, const Object* object)
{
    Tool out;
    if (settings.tool == ToolKind::Ball ||
        (settings.tool == ToolKind::Mesh && (object == nullptr || object->mesh.triangles.empty()))) {
        out.mesh = mesh::sphere(settings.tool_radius, 3);
    } else {
        out.mesh = shape_of(settings, object);
        const Box box = box_of(out.mesh.vertices);
        const double scale = settings.tool_size / size(box)[longest_axis(box)];
        const double turn = settings.tool_turn * std::numbers::pi / 180, tilt = settings.tool_tilt * std::numbers::pi / 180;
        const double c = std::cos(turn), s = std::sin(turn), ct = std::cos(tilt), st = std::sin(tilt);
        for (Vec3d& v : out.mesh.vertices) {
            const Vec3d p = scale * (v - centre(box));
            const Vec3d turned{c * p.x + s * p.z, p.y, c * p.z - s * p.x};
            v = {turned.x, ct * turned.y - st * turned.z, st * turned.y + ct * turned.z};
        }
        for (double cell = settings.tool_size / 80; out.mesh.vertices.size() > k_max_tool_points; cell *= 1.2)
            out.mesh = clustered(out.mesh, cell);
    }
    out.weights.assign(out.mesh.vertices.size(), 0);
    for (std::uint32_t t = 0; t < out.mesh.triangles.size(); ++t)
        for (const std::uint32_t v : out.mesh.triangles[t])
            out.weights[v] += static_cast<float>(mesh::triangle_area(out.mesh, t) / 3);
    return out;
}

std::string tool_bytes(const Tool& tool)
{
    Bytes out("SQT1");
    out.count(tool.mesh.vertices.size());
    out.count(tool.mesh.triangles.size());
    for (const Vec3d& v : tool.mesh.vertices) out.point(cast<float>(v));
    out.corners(tool.mesh.triangles);
    return out.take();
}

}  // namespace sqmap::viewer
