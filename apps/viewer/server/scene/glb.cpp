#include "viewer/server/scene/glb.h"

#include "viewer/server/protocol/bytes.h"
#include "viewer/server/scene/displacement.h"
#include "viewer/server/scene/facts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

constexpr int k_along = 24, k_around = 48, k_texels = 128;
// Numbers of glTF and of OpenGL in it.
constexpr int k_vertices = 34962, k_indices = 34963, k_float = 5126, k_uint = 5125;
constexpr std::uint32_t k_chunk_json = 0x4e4f534a, k_chunk_binary = 0x004e4942;

/// A file that grows: what is added comes back as its number.
class Glb {
public:
    /// groups: names of the scene's nodes, under which all others hang.
    explicit Glb(const std::vector<std::string>& groups)
    {
        root_["asset"] = {{"version", "2.0"}, {"generator", "sqmap view"}};
        root_["scene"] = 0;
        root_["scenes"] = {{{"nodes", ordered_json::array()}}};
        root_["nodes"] = ordered_json::array();
        for (std::size_t i = 0; i < groups.size(); ++i) {
            root_["scenes"][0]["nodes"].push_back(i);
            root_["nodes"].push_back({{"name", groups[i]}, {"children", ordered_json::array()}});
        }
        groups_ = groups.size();
        for (const char* list : {"meshes", "materials", "accessors", "bufferViews"}) root_[list] = ordered_json::array();
    }

    std::size_t add_floats(const std::vector<float>& values, const char* type, std::size_t each)
    {
        root_["accessors"].push_back({{"bufferView", add_view(values.data(), 4 * values.size(), k_vertices)},
                                      {"componentType", k_float},
                                      {"count", values.size() / each},
                                      {"type", type}});
        return root_["accessors"].size() - 1;
    }
    std::size_t add_points(const std::vector<Vec3f>& points)
    {
        std::vector<float> values;
        for (const Vec3f& p : points) values.insert(values.end(), {p.x, p.y, p.z});
        return add_floats(values, "VEC3", 3);
    }
    /// With their box, as glTF wants of positions.
    std::size_t add_positions(const std::vector<Vec3f>& points)
    {
        Vec3f lo{1e30f, 1e30f, 1e30f}, hi{-1e30f, -1e30f, -1e30f};
        for (const Vec3f& p : points)
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], p[k]);
                hi[k] = std::max(hi[k], p[k]);
            }
        const std::size_t accessor = add_points(points);
        root_["accessors"][accessor]["min"] = {lo.x, lo.y, lo.z};
        root_["accessors"][accessor]["max"] = {hi.x, hi.y, hi.z};
        return accessor;
    }
    std::size_t add_corners(const void* corners, std::size_t count)
    {
        root_["accessors"].push_back({{"bufferView", add_view(corners, 4 * count, k_indices)},
                                      {"componentType", k_uint},
                                      {"count", count},
                                      {"type", "SCALAR"}});
        return root_["accessors"].size() - 1;
    }
    /// Hues of parts are a golden section apart.
    std::size_t add_material(std::uint32_t part, bool translucent)
    {
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
        root_["materials"].push_back(std::move(material));
        return root_["materials"].size() - 1;
    }
    /// A mesh and its node, under a group. primitive: attributes, indices, material.
    std::size_t add_node(const std::string& name, const ordered_json& primitive, std::size_t group)
    {
        root_["meshes"].push_back({{"name", name}, {"primitives", {primitive}}});
        root_["nodes"].push_back({{"name", name}, {"mesh", root_["meshes"].size() - 1}});
        root_["nodes"][group]["children"].push_back(root_["nodes"].size() - 1);
        return root_["nodes"].size() - 1;
    }
    std::size_t add_texture(const std::string& name, const std::string& png)
    {
        root_["images"].push_back(
            {{"name", name}, {"bufferView", add_view(png.data(), png.size(), 0)}, {"mimeType", "image/png"}});
        root_["textures"].push_back({{"source", root_["images"].size() - 1}, {"sampler", 0}});
        return root_["textures"].size() - 1;
    }
    [[nodiscard]] ordered_json& node(std::size_t number) { return root_["nodes"][number]; }
    [[nodiscard]] ordered_json& material(std::size_t number) { return root_["materials"][number]; }

    /// The whole file.
    [[nodiscard]] std::string take()
    {
        if (root_.contains("textures"))
            root_["samplers"] = {{{"magFilter", 9729}, {"minFilter", 9729}, {"wrapS", 10497}, {"wrapT", 33071}}};
        for (std::size_t i = 0; i < groups_; ++i)
            if (root_["nodes"][i]["children"].empty()) root_["nodes"][i].erase("children");
        root_["buffers"] = {{{"byteLength", data_.size()}}};
        std::string text = root_.dump();
        text.append((4 - text.size() % 4) % 4, ' ');
        data_.append((4 - data_.size() % 4) % 4, '\0');
        Bytes out("glTF");
        out.count(2);
        out.count(12 + 8 + text.size() + 8 + data_.size());
        out.count(text.size());
        out.put(k_chunk_json);
        std::string glb = out.take() + text;
        Bytes chunk("????");
        chunk.count(data_.size());
        chunk.put(k_chunk_binary);
        return glb + chunk.take().substr(4) + data_;
    }

private:
    std::size_t add_view(const void* bytes, std::size_t size, int target)
    {
        ordered_json view{{"buffer", 0}, {"byteOffset", data_.size()}, {"byteLength", size}};
        if (target != 0) view["target"] = target;
        root_["bufferViews"].push_back(std::move(view));
        data_.append(static_cast<const char*>(bytes), size);
        data_.append((4 - data_.size() % 4) % 4, '\0');
        return root_["bufferViews"].size() - 1;
    }

    std::string data_;
    ordered_json root_;
    std::size_t groups_ = 0;
};

/// The superquadric's node; its material comes back.
std::size_t add_superquadric(Glb& glb, const Sheet& sheet, std::uint32_t part, const std::string& name, const ordered_json& facts)
{
    const std::size_t position = glb.add_positions(sheet.positions), normal = glb.add_points(sheet.normals),
                      uv = glb.add_floats(sheet.uv, "VEC2", 2);
    const std::size_t corners = glb.add_corners(sheet.corners.data(), sheet.corners.size()),
                      material = glb.add_material(part, true);
    const std::size_t node =
        glb.add_node(name,
                     {{"attributes", ordered_json::object({{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}})},
                      {"indices", corners},
                      {"material", material}},
                     1);
    glb.node(node)["extras"] = {{"superquadric", facts}};
    return material;
}

}  // namespace

std::string glb_bytes(const Object& object, const Parts& parts)
{
    Glb glb({object.name + " parts", object.name + " superquadrics"});
    const ordered_json parameters = superquadrics_json(object, parts);
    for (std::uint32_t p = 0; p < parts.partition.part_count; ++p) {
        const mesh::Mesh own = part_mesh(object, parts, p);
        if (!own.triangles.empty()) {
            std::vector<Vec3f> positions;
            for (const Vec3d& v : own.vertices) positions.push_back(object.world(v));
            const std::size_t position = glb.add_positions(positions);
            const std::size_t corners = glb.add_corners(own.triangles.data(), 3 * own.triangles.size());
            glb.add_node(parts.names[p],
                         {{"attributes", ordered_json::object({{"POSITION", position}})},
                          {"indices", corners},
                          {"material", glb.add_material(p, false)}},
                         0);
        }
        const std::size_t material = add_superquadric(glb, superquadric_sheet(object, parts.superquadrics[p], k_along, k_around),
                                                      p, parts.names[p] + " superquadric", parameters["parts"][p]);
        if (own.triangles.empty()) continue;
        const Displacement map = displacement_of(object, parts, p, k_texels, k_texels / 2);
        const std::size_t texture = glb.add_texture(parts.names[p] + " displacement", displacement_png(map));
        glb.material(material)["extras"] = {
            {"displacementTexture",
             {{"index", texture}, {"texCoord", 0}, {"scale", -map.max}, {"midlevel", 0}, {"space", "normal"}}}};
    }
    return glb.take();
}

}  // namespace sqmap::viewer
