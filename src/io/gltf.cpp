// glTF 2.0 (Khronos, ISO/IEC 12113:2022), JSON with buffers beside it or inside it, and GLB. Only what makes the surface
// is read: nodes, meshes, triangle primitives, positions and indices; and, in read_skin.cpp, of skins what moves it.
#include "gltf_file.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace sqmap::io {
namespace {

double determinant(const Mat3d& m) { return dot(m.row[0], cross(m.row[1], m.row[2])); }

void check_extensions(const json& root)
{
    const json* extensions = array_or_null(root, "extensionsRequired", "extensionsRequired");
    if (extensions != nullptr)
        for (const json& e : *extensions)
            if (e != "KHR_mesh_quantization" &&
                !(e.is_string() && e.get_ref<const std::string&>().starts_with("KHR_materials")) && e != "KHR_texture_transform")
                fail_format("extensionsRequired", "extension " +
                                                      TextCursor::printable(e.is_string() ? e.get<std::string>() : "?") +
                                                      " is not supported: export without it");
}

std::vector<std::uint64_t> root_nodes(const json& root, const json* nodes)
{
    std::vector<std::uint64_t> roots;
    if (const json* scenes = array_or_null(root, "scenes", "scenes"); scenes != nullptr && !scenes->empty()) {
        const std::uint64_t scene = whole(root, "scene", "scene", 0);
        if (const json* list = array_or_null(item(root, "scenes", scene), "nodes", name_of("scene", scene)))
            for (const json& n : *list) {
                if (!n.is_number_unsigned()) fail_format(name_of("scene", scene), "a root is not a node number");
                roots.push_back(n.get<std::uint64_t>());
            }
        return roots;
    }
    if (nodes == nullptr) return roots;
    std::vector<bool> is_child(nodes->size(), false);
    for (const json& node : *nodes)
        if (node.is_object())
            if (const json* children = array_or_null(node, "children", "nodes"))
                for (const json& c : *children)
                    if (c.is_number_unsigned() && c.get<std::uint64_t>() < is_child.size())
                        is_child[c.get<std::uint64_t>()] = true;
    for (std::uint64_t n = 0; n < is_child.size(); ++n)
        if (!is_child[n]) roots.push_back(n);
    if (roots.empty() && !is_child.empty()) fail_format("nodes", "every node is another's child: nodes must form a tree");
    return roots;
}

}  // namespace

void GltfTriangles::add_mesh(std::uint64_t index, const Affine& map)
{
    const std::string where = name_of("mesh", index);
    const json* primitives = array_or_null(item(file_.root(), "meshes", index), "primitives", where);
    if (primitives == nullptr) fail_format(where, "'primitives' is missing");
    for (const json& primitive : *primitives) {
        if (!primitive.is_object()) fail_format(where, "a primitive is not an object");
        const std::uint64_t mode = whole(primitive, "mode", where, 4);
        if (mode > 6) fail_format(where, "an unknown primitive mode");
        if (mode >= 4) add_primitive(primitive, mode, map, where);
    }
}

void GltfTriangles::add_primitive(const json& primitive, std::uint64_t mode, const Affine& map, const std::string& where)
{
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object()) fail_format(where, "'attributes' is missing");
    if (!attributes->contains("POSITION")) return;  // the specification: nothing to show
    const Accessor positions = file_.accessor(whole(*attributes, "POSITION", where));
    if (positions.type != "VEC3") fail_format(where, "POSITION is not VEC3");
    std::optional<Accessor> indices;
    if (primitive.contains("indices")) {
        indices = file_.accessor(whole(primitive, "indices", where));
        if (indices->type != "SCALAR" || (indices->component != 5121 && indices->component != 5123 && indices->component != 5125))
            fail_format(where, "indices are not whole numbers");
    }
    const std::uint64_t corners = indices ? indices->count : positions.count;
    if (mode == 4 && corners % 3 != 0) fail_format(where, std::to_string(corners) + " corners do not make triangles");
    const std::uint64_t triangles = mode == 4 ? corners / 3 : (corners < 3 ? 0 : corners - 2);
    check_face_limit(soup.polygon_offsets.size() - 1 + triangles, file_.limits());
    const std::uint64_t cost = positions.count * sizeof(Vec3d) + triangles * (3 * sizeof(std::int64_t) + sizeof(std::uint32_t));
    file_.spend(cost, where, "repeated instances unfold to far more than the file's size",
                "apply the instances you need in a modelling program");

    const auto base = static_cast<std::int64_t>(soup.positions.size());
    for (std::size_t v = 0; v < positions.count; ++v)
        soup.positions.push_back(map.linear * Vec3d{positions.real(v, 0), positions.real(v, 1), positions.real(v, 2)} +
                                 map.shift);
    // An index beyond this primitive's own vertices must not land in the next one's: -1 is for admission to refuse.
    const auto corner = [&](std::size_t i) -> std::int64_t {
        const std::int64_t local = indices ? indices->index(i) : static_cast<std::int64_t>(i);
        return local < static_cast<std::int64_t>(positions.count) ? base + local : -1;
    };
    const bool mirrored = determinant(map.linear) < 0;
    for (std::size_t t = 0; t < triangles; ++t) {
        std::array<std::size_t, 3> at{3 * t, 3 * t + 1, 3 * t + 2};
        if (mode == 5) at = t % 2 == 0 ? std::array{t, t + 1, t + 2} : std::array{t + 1, t, t + 2};
        if (mode == 6) at = {0, t + 1, t + 2};
        if (mirrored) std::swap(at[1], at[2]);
        for (const std::size_t i : at) soup.indices.push_back(corner(i));
        end_polygon(soup, file_.limits());
    }
}

PolygonSoup read_gltf(std::span<const std::byte> bytes, const std::filesystem::path& folder, const ReadLimits& limits)
{
    GltfFile file(bytes, folder, limits);
    const json& root = file.root();
    check_extensions(root);
    GltfTriangles triangles(file);
    const json* nodes = array_or_null(root, "nodes", "nodes");
    std::vector<bool> seen(nodes != nullptr ? nodes->size() : 0, false);
    std::vector<std::pair<std::uint64_t, Affine>> open;
    for (const std::uint64_t node : root_nodes(root, nodes)) open.emplace_back(node, Affine{});
    std::reverse(open.begin(), open.end());
    while (!open.empty()) {
        const auto [index, parent] = open.back();
        open.pop_back();
        const std::string where = name_of("node", index);
        const json& node = item(root, "nodes", index);
        if (seen[index]) fail_format(where, "a node is reached twice: nodes must form a tree");
        seen[index] = true;
        const Affine world = parent * affine_of(node, where);
        // The specification: a skinned mesh's own node does not move it.
        if (node.contains("mesh")) triangles.add_mesh(whole(node, "mesh", where), node.contains("skin") ? Affine{} : world);
        if (const json* children = array_or_null(node, "children", where))
            for (auto child = children->rbegin(); child != children->rend(); ++child) {
                if (!child->is_number_unsigned()) fail_format(where, "a child is not a node number");
                open.emplace_back(child->get<std::uint64_t>(), world);
                if (open.size() > seen.size()) fail_format(where, "a node is reached twice: nodes must form a tree");
            }
    }
    // Without scenes and nodes the meshes themselves are all there is.
    if (nodes == nullptr)
        if (const json* meshes = array_or_null(root, "meshes", "meshes"))
            for (std::uint64_t m = 0; m < meshes->size(); ++m) triangles.add_mesh(m, Affine{});
    return std::move(triangles.soup);
}

}  // namespace sqmap::io
