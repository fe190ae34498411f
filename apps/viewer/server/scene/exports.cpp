#include "viewer/server/scene/exports.h"

#include "sqmap/collider/export.h"
#include "sqmap/io/write_mesh.h"
#include "viewer/server/scene/displacement.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace sqmap::viewer {
namespace {

constexpr int k_along = 24, k_around = 48, k_texels = 128;

/// Linear light. Hues of parts are a golden section apart.
std::array<float, 3> part_colour(std::uint32_t part)
{
    const double hue = std::fmod(part * 0.61803398875, 1.0) * 6;
    const auto channel = [&](double shift) {
        const double x = std::fmod(hue + shift, 6.0);
        return static_cast<float>(0.25 + 0.55 * std::clamp(std::abs(x - 3) - 1, 0.0, 1.0));
    };
    return {channel(0), channel(4), channel(2)};
}

io::MovingMesh part_as_gltf(const Object& object, const mesh::Mesh& own, std::uint32_t part, const std::string& name)
{
    io::MovingMesh out{.name = name,
                       .positions = {},
                       .triangles = own.triangles,
                       .colour = part_colour(part),
                       .flat = true,
                       .group = object.name + " parts"};
    for (const Vec3d& v : own.vertices) out.positions.push_back(cast<double>(object.world(v)));
    return out;
}

io::MovingMesh superquadric_as_gltf(const Object& object, const Sheet& sheet, std::uint32_t part, const std::string& name)
{
    io::MovingMesh out{.name = name + " superquadric",
                       .positions = {},
                       .triangles = {},
                       .colour = part_colour(part),
                       .opacity = 0.35f,
                       .group = object.name + " superquadrics"};
    for (const Vec3f& p : sheet.positions) out.positions.push_back(cast<double>(p));
    for (const Vec3f& n : sheet.normals) out.normals.push_back(cast<double>(n));
    for (std::size_t i = 0; i < sheet.uv.size(); i += 2) out.texture_coordinates.push_back({sheet.uv[i], sheet.uv[i + 1]});
    for (std::size_t i = 0; i < sheet.corners.size(); i += 3)
        out.triangles.push_back({sheet.corners[i], sheet.corners[i + 1], sheet.corners[i + 2]});
    return out;
}

}  // namespace

std::string json_text(const Object& object, const Parts& parts)
{
    const collider::Colliders superquadrics =
        collider::colliders_of(object.view, {parts.partition, parts.superquadrics, parts.largest_f, parts.names}, object.name,
                               {.kind = collider::Kind::Superquadric}, 1);
    return collider::files_of(superquadrics, collider::Format::Json, object.name + ".json").back().bytes;
}

std::string glb_bytes(const Object& object, const Parts& parts)
{
    std::vector<io::MovingMesh> scene;
    const auto exported = nlohmann::ordered_json::parse(json_text(object, parts));
    for (std::uint32_t p = 0; p < parts.partition.part_count; ++p) {
        const std::string& name = parts.names[p];
        const mesh::Mesh own = part_mesh(object, parts, p);
        if (!own.triangles.empty()) scene.push_back(part_as_gltf(object, own, p, name));
        const Sheet sheet = superquadric_sheet(object, parts.superquadrics[p], k_along, k_around);
        io::MovingMesh& superquadric = scene.emplace_back(superquadric_as_gltf(object, sheet, p, name));
        superquadric.extras = nlohmann::ordered_json{{"collider", exported["parts"][p]}}.dump();
        if (own.triangles.empty()) continue;
        const Displacement map = displacement_of(object, parts, p, k_texels, k_texels / 2);
        superquadric.displacement = {name + " displacement", displacement_png(map), static_cast<double>(-map.max)};
    }
    const std::vector<std::byte> bytes = io::glb_bytes(scene);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace sqmap::viewer
