// Bytes that the page draws: triangles, superquadrics, fields over the surface, unrolled maps, and the same as binary glTF.
#include "object.h"
#include "render/unrolled.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/query.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace sqmap::viewer {
namespace {

static_assert(std::endian::native == std::endian::little, "bytes are copied as they are");

class Bytes {
public:
    explicit Bytes(const char* magic) : out_(magic, 4) {}
    template <class T>
    void put(T value)
    {
        static_assert(sizeof(T) == 4);
        const auto at = out_.size();
        out_.resize(at + 4);
        std::memcpy(out_.data() + at, &value, 4);
    }
    void count(std::size_t n) { put(static_cast<std::uint32_t>(n)); }
    void point(Vec3f p)
    {
        put(p.x);
        put(p.y);
        put(p.z);
    }
    [[nodiscard]] std::string take() { return std::move(out_); }

private:
    std::string out_;
};

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
        root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", size}, {"target", target}});
        data.append(static_cast<const char*>(bytes), size);
        return root["bufferViews"].size() - 1;
    };
    const auto add_mesh = [&](const std::string& name, const mesh::Mesh& m, std::uint32_t part, bool translucent) {
        std::vector<float> positions;
        Vec3f lo{1e30f, 1e30f, 1e30f}, hi{-1e30f, -1e30f, -1e30f};
        for (const Vec3d& v : m.vertices) {
            const Vec3f p = object.world(v);
            for (int k = 0; k < 3; ++k) {
                positions.push_back(p[k]);
                lo[k] = std::min(lo[k], p[k]);
                hi[k] = std::max(hi[k], p[k]);
            }
        }
        const auto position_view = add_view(positions.data(), 4 * positions.size(), 34962);
        const auto index_view = add_view(m.triangles.data(), 12 * m.triangles.size(), 34963);
        const auto position = root["accessors"].size();
        root["accessors"].push_back({{"bufferView", position_view},
                                     {"componentType", 5126},
                                     {"count", m.vertices.size()},
                                     {"type", "VEC3"},
                                     {"min", {lo.x, lo.y, lo.z}},
                                     {"max", {hi.x, hi.y, hi.z}}});
        root["accessors"].push_back(
            {{"bufferView", index_view}, {"componentType", 5125}, {"count", 3 * m.triangles.size()}, {"type", "SCALAR"}});
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
        root["materials"].push_back(material);
        root["meshes"].push_back({{"name", name},
                                  {"primitives",
                                   {{{"attributes", {{"POSITION", position}}},
                                     {"indices", position + 1},
                                     {"material", root["materials"].size() - 1}}}}});
        ordered_json node{{"name", name}, {"mesh", root["meshes"].size() - 1}};
        root["nodes"].push_back(node);
        root["nodes"][translucent ? 1 : 0]["children"].push_back(root["nodes"].size() - 1);
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
        if (!own.triangles.empty()) add_mesh(parts.names[p], own, p, false);
        const auto node =
            add_mesh(parts.names[p] + " superquadric", mesh::superquadric_surface(parts.superquadrics[p], 12), p, true);
        root["nodes"][node]["extras"] = {{"superquadric", parameters["parts"][p]}};
    }
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
