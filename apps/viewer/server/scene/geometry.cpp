// Bytes that the page draws: triangles, superquadrics, fields over the surface, unrolled maps, and the same as binary glTF.
#include "common/render/unrolled.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/query.h"
#include "viewer/server/protocol/bytes.h"
#include "viewer/server/scene/displacement.h"
#include "viewer/server/scene/object.h"

#include <cmath>
#include <limits>

namespace sqmap::viewer {
namespace {

/// |depth by layer 3 - exact depth| below a triangle's middle, percent of R_max; -1 missed, -2 too thin to say.
float depth_error(const Object& object, const mesh::Solid& solid, std::uint32_t triangle)
{
    const auto& [i, j, k] = object.mesh.triangles[triangle];
    const auto& v = object.mesh.vertices;
    const Vec3d normal = normalized(cross(v[j] - v[i], v[k] - v[i]));
    const Vec3d middle = mesh::triangle_centroid(object.mesh, triangle);
    const double r_max = object.view.header.r_max;
    for (double below = 0.01; below > 0.001; below /= 2) {
        const Vec3f p = cast<float>(middle - below * r_max * normal);
        if (!solid.inside(cast<double>(p))) continue;
        const query::Contact contact = query::query_point(object.view, p, query::Layer::Three);
        if (!contact.contact) return -1;
        return static_cast<float>(
            100 * std::abs(static_cast<double>(contact.depth) - solid.closest_boundary(cast<double>(p)).distance) / r_max);
    }
    return -2;
}

float projection_error(const Object& object, std::uint32_t triangle)
{
    float distance = 0;
    const Vec3f p = cast<float>(mesh::triangle_centroid(object.mesh, triangle));
    if (!query::distance_along_projection(object.view, object.parts.partition.part_of_triangle[triangle], p, query::Layer::Three,
                                          distance))
        return -2;
    return static_cast<float>(100 * std::abs(static_cast<double>(distance)) / object.view.header.r_max);
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
    if (field == Field::Error) {
        if (object.view.header.solid == 0) {
            for (std::uint32_t t = 0; t < count; ++t) out.put(projection_error(object, t));
            return out.take();
        }
        const mesh::Solid solid(object.mesh, mesh::find_self_intersections(object.mesh).crossed);
        for (std::uint32_t t = 0; t < count; ++t) out.put(depth_error(object, solid, t));
        return out.take();
    }
    const decompose::Decomposition d = decompose::decompose_with_diagnostics(object.mesh);
    const double r_max = object.view.header.r_max;
    for (std::uint32_t t = 0; t < count; ++t)
        out.put(static_cast<float>(field == Field::Protrusion ? d.protrusion[t] : d.curvature[t] * r_max * r_max));
    return out.take();
}

std::string map_bytes(const Object& object, std::uint32_t part, int side)
{
    const app::Unrolled map = app::unrolled_central(object.view, part, side);
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

constexpr int k_glb_along = 24, k_glb_around = 48, k_glb_texels = 128;

std::string glb_bytes(const Object& object, const Parts& parts)
{
    using nlohmann::ordered_json;
    std::string data;
    ordered_json root;
    root["asset"] = {{"version", "2.0"}, {"generator", "sqmap view"}};
    root["scene"] = 0;
    root["scenes"] = {{{"nodes", {0, 1}}}};
    root["nodes"] = {{{"name", object.name + " parts"}, {"children", ordered_json::array()}},
                     {{"name", object.name + " superquadrics"}, {"children", ordered_json::array()}}};
    for (const char* list : {"meshes", "materials", "accessors", "bufferViews"}) root[list] = ordered_json::array();

    const auto add_view = [&](const void* bytes, std::size_t size, int target) {
        ordered_json view{{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", size}};
        if (target != 0) view["target"] = target;
        root["bufferViews"].push_back(std::move(view));
        data.append(static_cast<const char*>(bytes), size);
        data.append((4 - data.size() % 4) % 4, '\0');
        return root["bufferViews"].size() - 1;
    };
    const auto add_floats = [&](const std::vector<float>& values, const char* type, std::size_t each) {
        root["accessors"].push_back({{"bufferView", add_view(values.data(), 4 * values.size(), 34962)},
                                     {"componentType", 5126},
                                     {"count", values.size() / each},
                                     {"type", type}});
        return root["accessors"].size() - 1;
    };
    const auto add_points = [&](const std::vector<Vec3f>& points) {
        std::vector<float> values;
        for (const Vec3f& p : points) values.insert(values.end(), {p.x, p.y, p.z});
        return add_floats(values, "VEC3", 3);
    };
    const auto add_positions = [&](const std::vector<Vec3f>& points) {
        Vec3f lo{1e30f, 1e30f, 1e30f}, hi{-1e30f, -1e30f, -1e30f};
        for (const Vec3f& p : points)
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], p[k]);
                hi[k] = std::max(hi[k], p[k]);
            }
        const auto accessor = add_points(points);
        root["accessors"][accessor]["min"] = {lo.x, lo.y, lo.z};
        root["accessors"][accessor]["max"] = {hi.x, hi.y, hi.z};
        return accessor;
    };
    const auto add_corners = [&](const void* corners, std::size_t count) {
        root["accessors"].push_back(
            {{"bufferView", add_view(corners, 4 * count, 34963)}, {"componentType", 5125}, {"count", count}, {"type", "SCALAR"}});
        return root["accessors"].size() - 1;
    };
    const auto add_material = [&](std::uint32_t part, bool translucent) {
        // Hues a golden section apart.
        const double hue = std::fmod(part * 0.61803398875, 1.0) * 6;
        const auto channel = [&](double shift) {
            const double x = std::fmod(hue + shift, 6.0);
            return 0.25 + 0.55 * std::clamp(std::abs(x - 3) - 1, 0.0, 1.0);
        };
        ordered_json material{{"pbrMetallicRoughness",
                               {{"baseColorFactor", {channel(0), channel(4), channel(2), translucent ? 0.35 : 1.0}},
                                {"metallicFactor", 0.0},
                                {"roughnessFactor", 0.8}}}};
        if (translucent) material["alphaMode"] = "BLEND";
        root["materials"].push_back(std::move(material));
        return root["materials"].size() - 1;
    };
    const auto add_node = [&](const std::string& name, const ordered_json& attributes, std::size_t indices, std::size_t material,
                              int parent) {
        root["meshes"].push_back(
            {{"name", name}, {"primitives", {{{"attributes", attributes}, {"indices", indices}, {"material", material}}}}});
        root["nodes"].push_back({{"name", name}, {"mesh", root["meshes"].size() - 1}});
        root["nodes"][static_cast<std::size_t>(parent)]["children"].push_back(root["nodes"].size() - 1);
        return root["nodes"].size() - 1;
    };

    const ordered_json parameters = superquadrics_json(object, parts);
    for (std::uint32_t p = 0; p < parts.partition.part_count; ++p) {
        mesh::Mesh own;
        std::vector<std::uint32_t> place(object.mesh.vertices.size(), std::numeric_limits<std::uint32_t>::max());
        for (std::uint32_t t = 0; t < object.mesh.triangles.size(); ++t) {
            if (parts.partition.part_of_triangle[t] != p) continue;
            mesh::Triangle corner{};
            for (std::size_t k = 0; k < 3; ++k) {
                std::uint32_t& at = place[object.mesh.triangles[t][k]];
                if (at == std::numeric_limits<std::uint32_t>::max()) {
                    at = static_cast<std::uint32_t>(own.vertices.size());
                    own.vertices.push_back(object.mesh.vertices[object.mesh.triangles[t][k]]);
                }
                corner[k] = at;
            }
            own.triangles.push_back(corner);
        }
        if (!own.triangles.empty()) {
            std::vector<Vec3f> positions;
            for (const Vec3d& v : own.vertices) positions.push_back(object.world(v));
            const auto position = add_positions(positions);
            const auto corners = add_corners(own.triangles.data(), 3 * own.triangles.size());
            add_node(parts.names[p], ordered_json::object({{"POSITION", position}}), corners, add_material(p, false), 0);
        }
        const Sheet sheet = superquadric_sheet(object, parts.superquadrics[p], k_glb_along, k_glb_around);
        const auto position = add_positions(sheet.positions), normal = add_points(sheet.normals),
                   uv = add_floats(sheet.uv, "VEC2", 2);
        const auto corners = add_corners(sheet.corners.data(), sheet.corners.size()), material = add_material(p, true);
        const auto node = add_node(parts.names[p] + " superquadric",
                                   ordered_json::object({{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}}),
                                   corners, material, 1);
        root["nodes"][node]["extras"] = {{"superquadric", parameters["parts"][p]}};
        if (own.triangles.empty()) continue;
        const Displacement map = displacement_of(object, parts, p, k_glb_texels, k_glb_texels / 2);
        const std::string png = displacement_png(map);
        root["images"].push_back({{"name", parts.names[p] + " displacement"},
                                  {"bufferView", add_view(png.data(), png.size(), 0)},
                                  {"mimeType", "image/png"}});
        root["textures"].push_back({{"source", root["images"].size() - 1}, {"sampler", 0}});
        root["materials"][material]["extras"] = {{"displacementTexture",
                                                  {{"index", root["textures"].size() - 1},
                                                   {"texCoord", 0},
                                                   {"scale", -map.most},
                                                   {"midlevel", 0},
                                                   {"space", "normal"}}}};
    }
    if (root.contains("textures"))
        root["samplers"] = {{{"magFilter", 9729}, {"minFilter", 9729}, {"wrapS", 10497}, {"wrapT", 33071}}};
    for (ordered_json* const node : {&root["nodes"][0], &root["nodes"][1]})
        if ((*node)["children"].empty()) node->erase("children");
    root["buffers"] = {{{"byteLength", data.size()}}};

    std::string text = root.dump();
    text.append((4 - text.size() % 4) % 4, ' ');
    data.append((4 - data.size() % 4) % 4, '\0');
    Bytes out("glTF");
    out.count(2);
    out.count(12 + 8 + text.size() + 8 + data.size());
    out.count(text.size());
    out.put(std::uint32_t{0x4e4f534a});  // JSON
    std::string glb = out.take() + text;
    Bytes chunk("????");
    chunk.count(data.size());
    chunk.put(std::uint32_t{0x004e4942});  // BIN
    return glb + chunk.take().substr(4) + data;
}

}  // namespace sqmap::viewer
