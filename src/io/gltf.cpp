// glTF 2.0 (Khronos, ISO/IEC 12113:2022), JSON with buffers beside it or inside it, and GLB. Only what makes the surface
// is read: nodes, meshes, triangle primitives, positions and indices; and of skins what moves it.
#include "parse.h"
#include "sqmap/io/read_skin.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <vector>

namespace sqmap::io {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "glTF buffers are read in place");

constexpr std::uint32_t k_magic = 0x46546C67, k_chunk_json = 0x4E4F534A, k_chunk_binary = 0x004E4942;

/// Rows of an affine map.
struct Transform {
    Mat3d linear;
    Vec3d shift;
};

Transform operator*(const Transform& a, const Transform& b) { return {a.linear * b.linear, a.linear * b.shift + a.shift}; }

double determinant(const Mat3d& m) { return dot(m.row[0], cross(m.row[1], m.row[2])); }

std::string name_of(const char* array, std::uint64_t index) { return std::string(array) + " " + std::to_string(index); }

/// Element index of one of the file's top-level arrays.
const json& item(const json& root, const char* array, std::uint64_t index)
{
    const auto found = root.find(array);
    if (found == root.end() || !found->is_array() || index >= found->size() || !(*found)[index].is_object())
        fail_format(name_of(array, index), "the file has no such object");
    return (*found)[index];
}

/// A whole number that is not negative; fallback where the key is missing.
std::uint64_t whole(const json& object, const char* key, const std::string& where, std::optional<std::uint64_t> fallback = {})
{
    const auto found = object.find(key);
    if (found == object.end()) {
        if (fallback) return *fallback;
        fail_format(where, std::string("'") + key + "' is missing");
    }
    if (!found->is_number_unsigned()) fail_format(where, std::string("'") + key + "' is not a whole number");
    return found->get<std::uint64_t>();
}

template <std::size_t N>
std::array<double, N> reals(const json& object, const char* key, const std::string& where, const std::array<double, N>& fallback)
{
    const auto found = object.find(key);
    if (found == object.end()) return fallback;
    if (!found->is_array() || found->size() != N)
        fail_format(where, std::string("'") + key + "' is not " + std::to_string(N) + " numbers");
    std::array<double, N> out{};
    for (std::size_t i = 0; i < N; ++i) {
        if (!(*found)[i].is_number()) fail_format(where, std::string("'") + key + "' is not " + std::to_string(N) + " numbers");
        out[i] = (*found)[i].template get<double>();
    }
    return out;
}

const json* array_or_null(const json& object, const char* key, const std::string& where)
{
    const auto found = object.find(key);
    if (found == object.end()) return nullptr;
    if (!found->is_array()) fail_format(where, std::string("'") + key + "' is not an array");
    return &*found;
}

JointPlace place_of(const json& node, const std::string& where)
{
    const auto t = reals<3>(node, "translation", where, {0, 0, 0});
    const auto s = reals<3>(node, "scale", where, {1, 1, 1});
    return {{t[0], t[1], t[2]}, reals<4>(node, "rotation", where, {0, 0, 0, 1}), {s[0], s[1], s[2]}};
}

Transform transform_of(const JointPlace& place)
{
    const auto [x, y, z, w] = place.rotation;
    const Mat3d rotation{{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                          {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                          {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
    const Mat3d scale{{{place.scale.x, 0, 0}, {0, place.scale.y, 0}, {0, 0, place.scale.z}}};
    return {rotation * scale, place.translation};
}

Transform transform_of(const json& node, const std::string& where)
{
    if (node.contains("matrix")) {
        const auto m = reals<16>(node, "matrix", where, {});  // columns first
        return {{{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}}}, {m[12], m[13], m[14]}};
    }
    return transform_of(place_of(node, where));
}

std::vector<std::byte> decoded_base64(std::string_view text, const std::string& where)
{
    std::vector<std::byte> out;
    out.reserve(text.size() / 4 * 3);
    std::uint32_t bits = 0;
    int bit_count = 0;
    for (char c : text) {
        if (c == '=') break;
        constexpr std::string_view k_alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        const std::size_t value = k_alphabet.find(c);
        if (value == std::string_view::npos) fail_format(where, "the data URI is not base64");
        bits = (bits << 6) | static_cast<std::uint32_t>(value);
        if ((bit_count += 6) >= 8) out.push_back(static_cast<std::byte>(bits >> (bit_count -= 8)));
    }
    return out;
}

/// The file beside the glTF file; only plain relative names, so that a file can make us read nothing else.
std::vector<std::byte> read_beside(const std::filesystem::path& folder, const std::string& uri, const std::string& where,
                                   const ReadLimits& limits)
{
    std::string name;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        unsigned code = 0;
        if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(&uri[i + 1], &uri[i + 3], code, 16).ptr == &uri[i + 3]) {
            name += static_cast<char>(code);
            i += 2;
        } else {
            name += uri[i];
        }
    }
    const std::filesystem::path relative(name);
    const bool climbs = std::find(relative.begin(), relative.end(), "..") != relative.end();
    if (name.empty() || name.find('\0') != std::string::npos || relative.is_absolute() || climbs ||
        name.find("://") != std::string::npos)
        fail_format(where, "the buffer's uri is not a file beside this one");
    std::error_code status;
    const std::filesystem::path path = folder / relative;
    if (folder.empty() || !std::filesystem::is_regular_file(path, status))
        fail_truncated(where, "its file '" + TextCursor::printable(name) + "' is not there");
    const std::uintmax_t size = std::filesystem::file_size(path, status);
    if (status) fail_truncated(where, "its file cannot be read");
    check_byte_limit(where, size, limits);
    std::vector<std::byte> bytes(size);
    std::ifstream stream(path, std::ios::binary);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (!stream && size > 0) fail_truncated(where, "its file cannot be read");
    return bytes;
}

/// Numbers of an accessor, bounds checked once.
struct Accessor {
    std::span<const std::byte> bytes;
    std::size_t count = 0, stride = 0;
    std::uint64_t component = 0;
    bool is_normalized = false;
    std::string type;

    [[nodiscard]] double real(std::size_t element, std::size_t k) const
    {
        switch (component) {
            case 5120:
                return scaled(raw<std::int8_t>(element, k), 127);
            case 5121:
                return scaled(raw<std::uint8_t>(element, k), 255);
            case 5122:
                return scaled(raw<std::int16_t>(element, k), 32767);
            case 5123:
                return scaled(raw<std::uint16_t>(element, k), 65535);
            case 5125:
                return raw<std::uint32_t>(element, k);
            default:
                return raw<float>(element, k);
        }
    }
    [[nodiscard]] std::int64_t index(std::size_t element) const
    {
        switch (component) {
            case 5121:
                return raw<std::uint8_t>(element, 0);
            case 5123:
                return raw<std::uint16_t>(element, 0);
            default:
                return raw<std::uint32_t>(element, 0);
        }
    }

private:
    template <class T>
    [[nodiscard]] T raw(std::size_t element, std::size_t k) const
    {
        T value;
        std::memcpy(&value, bytes.data() + element * stride + k * sizeof(T), sizeof(T));
        return value;
    }
    [[nodiscard]] double scaled(int value, int largest) const
    {
        return is_normalized ? std::max(double(value) / largest, -1.0) : value;
    }
};

class Document {
public:
    Document(json root, std::span<const std::byte> binary, std::filesystem::path folder, const ReadLimits& limits)
        : root_(std::move(root)), binary_(binary), folder_(std::move(folder)), limits_(limits)
    {
        if (const json* buffers = array_or_null(root_, "buffers", "buffers")) buffers_.resize(buffers->size());
    }

    PolygonSoup soup(std::uint64_t file_bytes)
    {
        // Nodes may show one mesh many times; what they unfold to is held to the size of the file.
        budget_ = (std::uint64_t{32} << 20) + 32 * file_bytes;
        const json* extensions = array_or_null(root_, "extensionsRequired", "extensionsRequired");
        if (extensions != nullptr)
            for (const json& e : *extensions)
                if (e != "KHR_mesh_quantization" &&
                    !(e.is_string() && e.get_ref<const std::string&>().starts_with("KHR_materials")) &&
                    e != "KHR_texture_transform")
                    fail_format("extensionsRequired", "extension " +
                                                          TextCursor::printable(e.is_string() ? e.get<std::string>() : "?") +
                                                          " is not supported: export without it");
        const json* nodes = array_or_null(root_, "nodes", "nodes");
        seen_.assign(nodes != nullptr ? nodes->size() : 0, false);
        std::vector<std::pair<std::uint64_t, Transform>> open;
        for (const std::uint64_t node : root_nodes(nodes)) open.emplace_back(node, Transform{});
        std::reverse(open.begin(), open.end());
        while (!open.empty()) {
            const auto [index, parent] = open.back();
            open.pop_back();
            const std::string where = name_of("node", index);
            const json& node = item(root_, "nodes", index);
            if (seen_[index]) fail_format(where, "a node is reached twice: nodes must form a tree");
            seen_[index] = true;
            const Transform world = parent * transform_of(node, where);
            // The specification: a skinned mesh's own node does not move it.
            if (node.contains("mesh")) add_mesh(whole(node, "mesh", where), node.contains("skin") ? Transform{} : world);
            if (const json* children = array_or_null(node, "children", where))
                for (auto child = children->rbegin(); child != children->rend(); ++child) {
                    if (!child->is_number_unsigned()) fail_format(where, "a child is not a node number");
                    open.emplace_back(child->get<std::uint64_t>(), world);
                    if (open.size() > seen_.size()) fail_format(where, "a node is reached twice: nodes must form a tree");
                }
        }
        // Without scenes and nodes the meshes themselves are all there is.
        if (nodes == nullptr)
            if (const json* meshes = array_or_null(root_, "meshes", "meshes"))
                for (std::uint64_t m = 0; m < meshes->size(); ++m) add_mesh(m, Transform{});
        return std::move(soup_);
    }

    SkinnedSoup skinned(std::uint64_t file_bytes)
    {
        budget_ = (std::uint64_t{32} << 20) + 32 * file_bytes;
        const json* nodes = array_or_null(root_, "nodes", "nodes");
        for (std::uint64_t n = 0; nodes != nullptr && n < nodes->size(); ++n) {
            const std::string where = name_of("node", n);
            const json& node = item(root_, "nodes", n);
            if (!node.contains("mesh") || !node.contains("skin")) continue;
            SkinnedSoup out;
            const std::uint64_t mesh = whole(node, "mesh", where);
            const std::vector<std::int64_t> joint_of = add_joints(whole(node, "skin", where), *nodes, out.skeleton);
            add_animations(joint_of, out);
            const json* primitives = array_or_null(item(root_, "meshes", mesh), "primitives", name_of("mesh", mesh));
            for (const json& primitive : primitives != nullptr ? *primitives : json::array())
                add_influences(primitive, name_of("mesh", mesh), out);
            add_mesh(mesh, Transform{});
            if (out.joints.size() != soup_.positions.size())
                fail_format(name_of("mesh", mesh), "a primitive has no joints or is not made of triangles");
            out.soup = std::move(soup_);
            return out;
        }
        fail_format("nodes", "no node has both a mesh and a skin");
    }

private:
    /// Returns of each node which joint it is, or -1.
    std::vector<std::int64_t> add_joints(std::uint64_t index, const json& nodes, std::vector<SkinJoint>& out)
    {
        const std::string where = name_of("skin", index);
        const json& skin = item(root_, "skins", index);
        const json* list = array_or_null(skin, "joints", where);
        if (list == nullptr || list->empty() || list->size() > 65535)
            fail_format(where, "'joints' is missing, empty or too long");
        std::vector<std::int64_t> parent(nodes.size(), -1), joint_of(nodes.size(), -1);
        for (std::uint64_t n = 0; n < nodes.size(); ++n)
            if (const json* children = array_or_null(item(root_, "nodes", n), "children", name_of("node", n)))
                for (const json& c : *children)
                    if (c.is_number_unsigned() && c.get<std::uint64_t>() < nodes.size())
                        parent[c.get<std::uint64_t>()] = static_cast<std::int64_t>(n);
        std::vector<std::uint64_t> node_of;
        for (const json& j : *list) {
            if (!j.is_number_unsigned() || j.get<std::uint64_t>() >= nodes.size())
                fail_format(where, "a joint is not a node number");
            node_of.push_back(j.get<std::uint64_t>());
            joint_of[node_of.back()] = static_cast<std::int64_t>(node_of.size()) - 1;
        }
        std::optional<Accessor> bind;
        if (skin.contains("inverseBindMatrices")) {
            bind = accessor(whole(skin, "inverseBindMatrices", where));
            if (bind->type != "MAT4" || bind->component != 5126 || bind->count < node_of.size())
                fail_format(where, "inverseBindMatrices are not a matrix a joint");
        }
        for (std::size_t j = 0; j < node_of.size(); ++j) {
            SkinJoint joint;
            const json& node = item(root_, "nodes", node_of[j]);
            if (const auto name = node.find("name"); name != node.end() && name->is_string())
                joint.name = name->get<std::string>();
            const Transform own = transform_of(node, name_of("node", node_of[j]));
            Transform above;
            joint.has_matrix = node.contains("matrix");
            if (!joint.has_matrix) joint.rest = place_of(node, name_of("node", node_of[j]));
            // Nodes between a joint and the joint above it do not move by themselves.
            std::int64_t up = parent[node_of[j]];
            for (std::size_t steps = 0; up >= 0 && joint_of[static_cast<std::size_t>(up)] < 0; ++steps) {
                if (steps > nodes.size()) fail_format("nodes", "every node is another's child: nodes must form a tree");
                above = transform_of(item(root_, "nodes", static_cast<std::uint64_t>(up)),
                                     name_of("node", static_cast<std::uint64_t>(up))) *
                        above;
                up = parent[static_cast<std::size_t>(up)];
            }
            joint.parent = up < 0 ? -1 : static_cast<int>(joint_of[static_cast<std::size_t>(up)]);
            const Transform local = above * own;
            joint.above = {above.linear, above.shift};
            joint.local = {local.linear, local.shift};
            if (bind) {
                const auto m = [&](std::size_t row, std::size_t column) { return bind->real(j, 4 * column + row); };
                joint.inverse_bind = {{{{m(0, 0), m(0, 1), m(0, 2)}, {m(1, 0), m(1, 1), m(1, 2)}, {m(2, 0), m(2, 1), m(2, 2)}}},
                                      {m(0, 3), m(1, 3), m(2, 3)}};
            }
            out.push_back(std::move(joint));
        }
        for (const SkinJoint& joint : out) {
            std::size_t steps = 0;
            for (int up = joint.parent; up >= 0; up = out[static_cast<std::size_t>(up)].parent)
                if (++steps > out.size()) fail_format(where, "a joint is above itself: nodes must form a tree");
        }
        return joint_of;
    }

    void add_animations(std::span<const std::int64_t> joint_of, SkinnedSoup& out)
    {
        const json* animations = array_or_null(root_, "animations", "animations");
        for (std::uint64_t a = 0; animations != nullptr && a < animations->size(); ++a) {
            const std::string where = name_of("animation", a);
            const json& animation = item(root_, "animations", a);
            SkinAnimation& to = out.animations.emplace_back();
            if (const auto name = animation.find("name"); name != animation.end() && name->is_string())
                to.name = name->get<std::string>();
            const json *channels = array_or_null(animation, "channels", where),
                       *samplers = array_or_null(animation, "samplers", where);
            if (channels == nullptr || samplers == nullptr) fail_format(where, "'channels' or 'samplers' is missing");
            for (const json& channel : *channels) {
                const auto target = channel.is_object() ? channel.find("target") : channel.end();
                if (!channel.is_object() || target == channel.end() || !target->is_object())
                    fail_format(where, "a channel has no target");
                const auto path = target->find("path");
                const bool named = path != target->end() && path->is_string();
                const std::string text = named ? path->get<std::string>() : "";
                const std::uint64_t node = whole(*target, "node", where, joint_of.size());
                const std::int64_t joint = node < joint_of.size() ? joint_of[node] : -1;
                if (joint < 0 || (text != "translation" && text != "rotation" && text != "scale")) {
                    ++to.ignored;
                    continue;
                }
                if (out.skeleton[static_cast<std::size_t>(joint)].has_matrix)
                    fail_format(where, "a node with a matrix is animated");
                const std::uint64_t sampler = whole(channel, "sampler", where);
                if (sampler >= samplers->size() || !(*samplers)[sampler].is_object())
                    fail_format(where, "a channel's sampler is not there");
                to.tracks.push_back(track_of((*samplers)[sampler], static_cast<std::uint32_t>(joint), text, where));
                to.duration = std::max(to.duration, to.tracks.back().times.back());
            }
        }
    }

    JointTrack track_of(const json& sampler, std::uint32_t joint, const std::string& path, const std::string& where)
    {
        JointTrack track;
        track.joint = joint;
        track.path = path == "rotation" ? JointTrack::Path::Rotation
                     : path == "scale"  ? JointTrack::Path::Scale
                                        : JointTrack::Path::Translation;
        if (const auto kind = sampler.find("interpolation"); kind != sampler.end()) {
            if (*kind == "STEP")
                track.between = JointTrack::Between::Step;
            else if (*kind == "CUBICSPLINE")
                track.between = JointTrack::Between::Cubic;
            else if (*kind != "LINEAR")
                fail_format(where, "an unknown interpolation");
        }
        const bool turns = track.path == JointTrack::Path::Rotation;
        const Accessor times = accessor(whole(sampler, "input", where)), values = accessor(whole(sampler, "output", where));
        const std::size_t each = track.between == JointTrack::Between::Cubic ? 3 : 1, width = turns ? 4 : 3;
        if (times.type != "SCALAR" || times.component != 5126 || values.type != (turns ? "VEC4" : "VEC3") || times.count == 0 ||
            values.count != each * times.count)
            fail_format(where, "a sampler's input and output do not match");
        const std::uint64_t cost = times.count * (sizeof(double) + each * sizeof(track.values.front()));
        if (cost > budget_) fail_limit(where, "its channels unfold to far more than the file's size", "export fewer channels");
        budget_ -= cost;
        for (std::size_t k = 0; k < times.count; ++k) {
            track.times.push_back(times.real(k, 0));
            if (!std::isfinite(track.times.back()) || (k > 0 && !(track.times[k] > track.times[k - 1])))
                fail_format(where, "times do not ascend");
        }
        for (std::size_t k = 0; k < values.count; ++k) {
            std::array<double, 4>& value = track.values.emplace_back();
            double length_sq = 0;
            for (std::size_t i = 0; i < width; ++i) {
                value[i] = values.real(k, i);
                if (!std::isfinite(value[i])) fail_format(where, "a key is not finite");
                length_sq += value[i] * value[i];
            }
            if (turns && k % each == each / 2 && !(length_sq > 0.25)) fail_format(where, "a key is no rotation");
        }
        return track;
    }

    void add_influences(const json& primitive, const std::string& where, SkinnedSoup& out)
    {
        const auto attributes = primitive.is_object() ? primitive.find("attributes") : primitive.end();
        if (attributes == primitive.end() || !attributes->is_object() || !attributes->contains("JOINTS_0") ||
            !attributes->contains("WEIGHTS_0"))
            fail_format(where, "a primitive of a skinned mesh has no JOINTS_0 and WEIGHTS_0");
        const Accessor joints = accessor(whole(*attributes, "JOINTS_0", where)),
                       weights = accessor(whole(*attributes, "WEIGHTS_0", where));
        if (joints.type != "VEC4" || weights.type != "VEC4" || joints.count != weights.count)
            fail_format(where, "JOINTS_0 and WEIGHTS_0 do not match");
        check_face_limit(joints.count, limits_);
        for (std::size_t v = 0; v < joints.count; ++v) {
            std::array<std::uint16_t, 4> j{};
            std::array<double, 4> w{};
            double sum = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                const double number = joints.real(v, k);
                w[k] = weights.real(v, k);
                if (!(w[k] >= 0)) w[k] = 0;
                if (w[k] > 0 && !(number >= 0 && number < static_cast<double>(out.skeleton.size())))
                    fail_format(where, "a vertex names a joint that the skin does not have");
                j[k] = w[k] > 0 ? static_cast<std::uint16_t>(number) : std::uint16_t{0};
                sum += w[k];
            }
            if (!(sum > 0) || !std::isfinite(sum)) fail_format(where, "a vertex has no weights");
            for (double& x : w) x /= sum;
            out.joints.push_back(j);
            out.weights.push_back(w);
        }
    }

    std::vector<std::uint64_t> root_nodes(const json* nodes) const
    {
        std::vector<std::uint64_t> roots;
        if (const json* scenes = array_or_null(root_, "scenes", "scenes"); scenes != nullptr && !scenes->empty()) {
            const std::uint64_t scene = whole(root_, "scene", "scene", 0);
            if (const json* list = array_or_null(item(root_, "scenes", scene), "nodes", name_of("scene", scene)))
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

    std::span<const std::byte> buffer(std::uint64_t index)
    {
        const std::string where = name_of("buffer", index);
        const json& description = item(root_, "buffers", index);
        const std::uint64_t length = whole(description, "byteLength", where);
        auto& loaded = buffers_[index];
        if (!loaded.has_value()) {
            const auto uri = description.find("uri");
            if (uri == description.end()) {
                loaded = Buffer{{}, index == 0 ? binary_ : std::span<const std::byte>{}};
            } else {
                if (!uri->is_string()) fail_format(where, "'uri' is not text");
                const std::string& text = uri->get_ref<const std::string&>();
                if (text.starts_with("data:")) {
                    const std::size_t comma = text.find(";base64,");
                    if (comma == std::string::npos) fail_format(where, "the data URI is not base64");
                    loaded = Buffer{decoded_base64(std::string_view(text).substr(comma + 8), where), {}};
                } else {
                    loaded = Buffer{read_beside(folder_, text, where, limits_), {}};
                }
                loaded->bytes = loaded->owned;
            }
        }
        if (length > loaded->bytes.size())
            fail_truncated(where,
                           std::to_string(length) + " bytes declared, " + std::to_string(loaded->bytes.size()) + " are there");
        return loaded->bytes.first(length);
    }

    Accessor accessor(std::uint64_t index)
    {
        const std::string where = name_of("accessor", index);
        const json& a = item(root_, "accessors", index);
        if (a.contains("sparse") || !a.contains("bufferView"))
            fail_format(where, "sparse accessors are not read: export without them");
        Accessor out;
        out.component = whole(a, "componentType", where);
        const auto type = a.find("type");
        if (type == a.end() || !type->is_string()) fail_format(where, "'type' is missing");
        out.type = type->get<std::string>();
        out.is_normalized = a.contains("normalized") && a["normalized"].is_boolean() && a["normalized"].get<bool>();
        const std::uint64_t components = out.type == "SCALAR" ? 1
                                         : out.type == "VEC3" ? 3
                                         : out.type == "VEC4" ? 4
                                         : out.type == "MAT4" ? 16
                                                              : 0;
        const std::uint64_t size = out.component == 5120 || out.component == 5121   ? 1
                                   : out.component == 5122 || out.component == 5123 ? 2
                                   : out.component == 5125 || out.component == 5126 ? 4
                                                                                    : 0;
        if (components == 0 || size == 0) fail_format(where, "not of a kind that is read");
        const std::uint64_t element_bytes = components * size;
        const std::uint64_t view_index = whole(a, "bufferView", where);
        const json& view = item(root_, "bufferViews", view_index);
        const std::string view_where = name_of("bufferView", view_index);
        std::span<const std::byte> bytes = buffer(whole(view, "buffer", view_where));
        const std::uint64_t view_offset = whole(view, "byteOffset", view_where, 0),
                            view_length = whole(view, "byteLength", view_where);
        if (view_offset > bytes.size() || view_length > bytes.size() - view_offset)
            fail_truncated(view_where, "it reaches beyond its buffer of " + std::to_string(bytes.size()) + " bytes");
        bytes = bytes.subspan(view_offset, view_length);
        const std::uint64_t offset = whole(a, "byteOffset", where, 0), count = whole(a, "count", where);
        const std::uint64_t stride = whole(view, "byteStride", view_where, element_bytes);
        if (stride < element_bytes) fail_format(view_where, "byteStride is smaller than an element");
        if (count > 0 && (offset > bytes.size() || element_bytes > bytes.size() - offset ||
                          count - 1 > (bytes.size() - offset - element_bytes) / stride))
            fail_truncated(where, std::to_string(count) + " elements reach beyond the buffer view of " +
                                      std::to_string(bytes.size()) + " bytes");
        if (count > 0) out.bytes = bytes.subspan(offset);
        out.count = count;
        out.stride = stride;
        return out;
    }

    void add_mesh(std::uint64_t index, const Transform& transform)
    {
        const std::string where = name_of("mesh", index);
        const json* primitives = array_or_null(item(root_, "meshes", index), "primitives", where);
        if (primitives == nullptr) fail_format(where, "'primitives' is missing");
        for (const json& primitive : *primitives) {
            if (!primitive.is_object()) fail_format(where, "a primitive is not an object");
            const std::uint64_t mode = whole(primitive, "mode", where, 4);
            if (mode > 6) fail_format(where, "an unknown primitive mode");
            if (mode >= 4) add_triangles(primitive, mode, transform, where);
        }
    }

    void add_triangles(const json& primitive, std::uint64_t mode, const Transform& transform, const std::string& where)
    {
        const auto attributes = primitive.find("attributes");
        if (attributes == primitive.end() || !attributes->is_object()) fail_format(where, "'attributes' is missing");
        if (!attributes->contains("POSITION")) return;  // the specification: nothing to show
        const Accessor positions = accessor(whole(*attributes, "POSITION", where));
        if (positions.type != "VEC3") fail_format(where, "POSITION is not VEC3");
        std::optional<Accessor> indices;
        if (primitive.contains("indices")) {
            indices = accessor(whole(primitive, "indices", where));
            if (indices->type != "SCALAR" ||
                (indices->component != 5121 && indices->component != 5123 && indices->component != 5125))
                fail_format(where, "indices are not whole numbers");
        }
        const std::uint64_t corners = indices ? indices->count : positions.count;
        if (mode == 4 && corners % 3 != 0) fail_format(where, std::to_string(corners) + " corners do not make triangles");
        const std::uint64_t triangles = mode == 4 ? corners / 3 : (corners < 3 ? 0 : corners - 2);
        check_face_limit(soup_.polygon_offsets.size() - 1 + triangles, limits_);
        const std::uint64_t cost =
            positions.count * sizeof(Vec3d) + triangles * (3 * sizeof(std::int64_t) + sizeof(std::uint32_t));
        if (cost > budget_)
            fail_limit(where, "repeated instances unfold to far more than the file's size",
                       "apply the instances you need in a modelling program");
        budget_ -= cost;

        const auto base = static_cast<std::int64_t>(soup_.positions.size());
        for (std::size_t v = 0; v < positions.count; ++v)
            soup_.positions.push_back(transform.linear * Vec3d{positions.real(v, 0), positions.real(v, 1), positions.real(v, 2)} +
                                      transform.shift);
        // An index beyond this primitive's own vertices must not land in the next one's: -1 is for the gate to refuse.
        const auto corner = [&](std::size_t i) -> std::int64_t {
            const std::int64_t local = indices ? indices->index(i) : static_cast<std::int64_t>(i);
            return local < static_cast<std::int64_t>(positions.count) ? base + local : -1;
        };
        const bool mirrored = determinant(transform.linear) < 0;
        for (std::size_t t = 0; t < triangles; ++t) {
            std::array<std::size_t, 3> at{3 * t, 3 * t + 1, 3 * t + 2};
            if (mode == 5) at = t % 2 == 0 ? std::array{t, t + 1, t + 2} : std::array{t + 1, t, t + 2};
            if (mode == 6) at = {0, t + 1, t + 2};
            if (mirrored) std::swap(at[1], at[2]);
            for (const std::size_t i : at) soup_.indices.push_back(corner(i));
            end_polygon(soup_, limits_);
        }
    }

    struct Buffer {
        std::vector<std::byte> owned;
        std::span<const std::byte> bytes;
    };

    json root_;
    std::span<const std::byte> binary_;
    std::filesystem::path folder_;
    ReadLimits limits_;
    std::vector<std::optional<Buffer>> buffers_;
    std::vector<bool> seen_;
    std::uint64_t budget_ = 0;
    PolygonSoup soup_;
};

std::uint32_t word(std::span<const std::byte> bytes, std::size_t at)
{
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

}  // namespace

namespace {

Document document_of(std::span<const std::byte> bytes, const std::filesystem::path& folder, const ReadLimits& limits)
{
    std::span<const std::byte> text = bytes, binary;
    if (bytes.size() >= 4 && word(bytes, 0) == k_magic) {
        if (bytes.size() < 20) fail_truncated("header", std::to_string(bytes.size()) + " bytes; a GLB header has 20");
        if (word(bytes, 4) != 2) fail_format("byte 4", "GLB version " + std::to_string(word(bytes, 4)) + "; version 2 is read");
        const std::size_t length = word(bytes, 8);
        if (length > bytes.size())
            fail_truncated("byte 8", std::to_string(length) + " bytes declared, the file has " + std::to_string(bytes.size()));
        bool is_first = true;
        for (std::size_t at = 12; at + 8 <= length;) {
            const std::size_t chunk = word(bytes, at);
            const std::uint32_t type = word(bytes, at + 4);
            if (chunk > length - at - 8)
                fail_truncated("byte " + std::to_string(at),
                               "a chunk of " + std::to_string(chunk) + " bytes reaches beyond the file");
            if (is_first) {
                if (type != k_chunk_json) fail_format("byte 16", "the first chunk is not JSON");
                text = bytes.subspan(at + 8, chunk);
            } else if (type == k_chunk_binary && binary.empty()) {
                binary = bytes.subspan(at + 8, chunk);
            }
            is_first = false;
            at += 8 + (chunk + 3) / 4 * 4;
        }
        if (is_first) fail_format("byte 12", "no JSON chunk");
    }
    const char* begin = reinterpret_cast<const char*>(text.data());
    json root = json::parse(begin, begin + text.size(), nullptr, false);
    if (root.is_discarded()) {
        // What a cut leaves has no closing brace; anything else is not JSON.
        std::size_t last = text.size();
        while (last > 0 && (begin[last - 1] <= ' ' && begin[last - 1] >= '\0')) --last;
        const std::size_t first = std::string_view(begin, last).find_first_not_of(" \t\r\n");
        if (first != std::string_view::npos && begin[first] == '{' && begin[last - 1] != '}')
            fail_truncated("JSON", "it ends before its closing brace");
        fail_format("JSON", "the text is not JSON");
    }
    if (!root.is_object()) fail_format("JSON", "a glTF file is one JSON object");
    const auto asset = root.find("asset");
    if (asset == root.end() || !asset->is_object() || !asset->contains("version") || !(*asset)["version"].is_string() ||
        !(*asset)["version"].get_ref<const std::string&>().starts_with("2"))
        fail_format("asset", "a glTF file of version 2 says so in asset.version");
    return {std::move(root), binary, folder, limits};
}

}  // namespace

PolygonSoup read_gltf(std::span<const std::byte> bytes, const std::filesystem::path& folder, const ReadLimits& limits)
{
    return document_of(bytes, folder, limits).soup(bytes.size());
}

SkinResult read_skinned_file(const std::filesystem::path& path, const ReadLimits& limits)
{
    SkinResult result;
    try {
        std::error_code status;
        const std::uintmax_t size = std::filesystem::is_regular_file(path, status) ? std::filesystem::file_size(path, status) : 0;
        if (status || size == 0) fail_truncated("file", "it cannot be read, or is empty");
        check_byte_limit("file", size, limits);
        std::vector<std::byte> bytes(size);
        std::ifstream in(path, std::ios::binary);
        in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
        if (!in) fail_truncated("file", "it cannot be read");
        result.skin = document_of(bytes, path.parent_path(), limits).skinned(size);
    } catch (const ReadFailure& failure) {
        result.error = failure.error;
    }
    return result;
}

namespace {

using Quaternion = std::array<double, 4>;

Quaternion normalized(Quaternion q)
{
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& v : q) v /= length;
    return q;
}

/// About one axis, the short way (Shoemake 1985).
Quaternion between(const Quaternion& a, Quaternion b, double share)
{
    double cosine = 0;
    for (std::size_t i = 0; i < 4; ++i) cosine += a[i] * b[i];
    if (cosine < 0) {
        cosine = -cosine;
        for (double& v : b) v = -v;
    }
    double of_a = 1 - share, of_b = share;
    if (cosine < 0.9999) {
        const double angle = std::acos(cosine);
        of_a = std::sin((1 - share) * angle) / std::sin(angle);
        of_b = std::sin(share * angle) / std::sin(angle);
    }
    Quaternion q;
    for (std::size_t i = 0; i < 4; ++i) q[i] = of_a * a[i] + of_b * b[i];
    return normalized(q);
}

Quaternion value_at(const JointTrack& track, double time)
{
    const bool turns = track.path == JointTrack::Path::Rotation, cubic = track.between == JointTrack::Between::Cubic;
    const auto value = [&](std::size_t k) {
        const Quaternion& v = track.values[cubic ? 3 * k + 1 : k];
        return turns ? normalized(v) : v;
    };
    const auto next = std::upper_bound(track.times.begin(), track.times.end(), time);
    if (next == track.times.begin()) return value(0);
    const auto k = static_cast<std::size_t>(next - track.times.begin()) - 1;
    if (next == track.times.end() || track.between == JointTrack::Between::Step) return value(k);
    const double span = track.times[k + 1] - track.times[k], t = (time - track.times[k]) / span;
    if (turns && !cubic) return between(value(k), value(k + 1), t);
    Quaternion out;
    for (std::size_t i = 0; i < 4; ++i) {
        const double a = track.values[cubic ? 3 * k + 1 : k][i], b = track.values[cubic ? 3 * k + 4 : k + 1][i];
        if (!cubic) {
            out[i] = a + t * (b - a);
            continue;
        }
        const double t2 = t * t, t3 = t2 * t, leaves = track.values[3 * k + 2][i], comes = track.values[3 * k + 3][i];
        out[i] = (2 * t3 - 3 * t2 + 1) * a + span * (t3 - 2 * t2 + t) * leaves + (3 * t2 - 2 * t3) * b + span * (t3 - t2) * comes;
    }
    return turns ? normalized(out) : out;
}

}  // namespace

std::vector<JointPlace> rest_places(const SkinnedSoup& skin)
{
    std::vector<JointPlace> places;
    for (const SkinJoint& joint : skin.skeleton) places.push_back(joint.rest);
    return places;
}

std::vector<JointPlace> places_at(const SkinnedSoup& skin, const SkinAnimation& animation, double time)
{
    std::vector<JointPlace> places = rest_places(skin);
    for (const JointTrack& track : animation.tracks) {
        const Quaternion v = value_at(track, time);
        JointPlace& place = places[track.joint];
        if (track.path == JointTrack::Path::Rotation)
            place.rotation = v;
        else
            (track.path == JointTrack::Path::Scale ? place.scale : place.translation) = {v[0], v[1], v[2]};
    }
    return places;
}

std::vector<JointPlace> blended(std::span<const JointPlace> a, std::span<const JointPlace> b, double share)
{
    std::vector<JointPlace> out;
    for (std::size_t j = 0; j < a.size(); ++j)
        out.push_back({a[j].translation + share * (b[j].translation - a[j].translation),
                       between(normalized(a[j].rotation), normalized(b[j].rotation), share),
                       a[j].scale + share * (b[j].scale - a[j].scale)});
    return out;
}

std::vector<Affine> joint_maps(const SkinnedSoup& skin, std::span<const JointPlace> places)
{
    const std::size_t n = skin.skeleton.size();
    std::vector<Affine> world(n), maps;
    std::vector<std::uint8_t> done(n, 0);
    std::vector<std::size_t> chain;
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t at = j; done[at] == 0;) {
            chain.push_back(at);
            if (skin.skeleton[at].parent < 0) break;
            at = static_cast<std::size_t>(skin.skeleton[at].parent);
        }
        for (; !chain.empty(); chain.pop_back()) {
            const SkinJoint& joint = skin.skeleton[chain.back()];
            const Transform own = transform_of(places[chain.back()]);
            const Affine local = joint.has_matrix ? joint.local : joint.above * Affine{own.linear, own.shift};
            world[chain.back()] = joint.parent < 0 ? local : world[static_cast<std::size_t>(joint.parent)] * local;
            done[chain.back()] = 1;
        }
        maps.push_back(world[j] * skin.skeleton[j].inverse_bind);
    }
    return maps;
}

}  // namespace sqmap::io
