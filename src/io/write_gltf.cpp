#include "sqmap/io/write_mesh.h"

#include "io/replace_file.h"
#include "sqmap/math/box.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace sqmap::io {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "glTF buffers are little-endian");

constexpr std::uint32_t k_float = 5126, k_uint = 5125;
constexpr std::uint32_t k_vertices = 34962, k_indices = 34963;

void need(bool holds, const MovingMesh& mesh, const char* what)
{
    if (!holds) throw std::invalid_argument("mesh '" + mesh.name + "': " + what);
}

void check(const MovingMesh& m)
{
    need(!m.positions.empty() && !m.triangles.empty(), m, "it is empty");
    for (const auto& t : m.triangles)
        for (const std::uint32_t v : t) need(v < m.positions.size(), m, "a triangle names a vertex that is not there");
    need(m.normals.empty() || m.normals.size() == m.positions.size(), m, "not one normal a position");
    need(m.texture_coordinates.empty() || m.texture_coordinates.size() == m.positions.size(), m,
         "not one texture coordinate a position");
    need(!m.displacement || !m.texture_coordinates.empty(), m, "a texture without coordinates");
    need(m.keys.empty() || m.keys.size() == m.times.size(), m, "not one key a time");
    need(m.shapes.empty() || m.shapes.size() == m.times.size(), m, "not one shape a time");
    need(std::is_sorted(m.times.begin(), m.times.end(), [](double a, double b) { return a <= b; }), m, "times do not ascend");
    for (const double t : m.times) need(std::isfinite(t) && t >= 0, m, "a time is negative or not finite");
    for (const Vec3d& p : m.positions) need(is_finite(p), m, "a position is not finite");
    for (const auto& shape : m.shapes) {
        need(shape.size() == m.positions.size(), m, "a shape has another number of positions");
        for (const Vec3d& p : shape) need(is_finite(p), m, "a position is not finite");
    }
}

/// Mean of the triangles' normals by area; +z if that is zero.
std::vector<Vec3d> normals_of(std::span<const Vec3d> p, std::span<const std::array<std::uint32_t, 3>> triangles)
{
    std::vector<Vec3d> out(p.size());
    for (const auto& t : triangles) {
        const Vec3d n = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
        for (const std::uint32_t v : t) out[v] += n;
    }
    for (Vec3d& n : out) n = norm(n) > 1e-30 ? normalized(n) : Vec3d{0, 0, 1};
    return out;
}

/// Unit quaternion (x, y, z, w) of a rotation (Shepperd 1978).
std::array<double, 4> quaternion_of(const Mat3d& m)
{
    const double d[4] = {m.row[0].x, m.row[1].y, m.row[2].z, m.row[0].x + m.row[1].y + m.row[2].z};
    const int k = static_cast<int>(std::max_element(d, d + 4) - d);
    std::array<double, 4> q{};
    if (k == 3) {
        q = {m.row[2].y - m.row[1].z, m.row[0].z - m.row[2].x, m.row[1].x - m.row[0].y, 1 + d[3]};
    } else {
        const int i = k, j = (k + 1) % 3, l = (k + 2) % 3;
        q[static_cast<std::size_t>(i)] = 1 + 2 * d[k] - d[3];
        q[static_cast<std::size_t>(j)] = m.row[i][j] + m.row[j][i];
        q[static_cast<std::size_t>(l)] = m.row[i][l] + m.row[l][i];
        q[3] = m.row[l][j] - m.row[j][l];
    }
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& v : q) v /= length;
    return q;
}

class Writer {
public:
    explicit Writer(std::span<const MovingMesh> meshes)
    {
        root_["asset"] = {{"version", "2.0"}, {"generator", "sqmap"}};
        root_["scene"] = 0;
        for (const MovingMesh& m : meshes) add(m);
        json top = json::array();
        for (std::size_t i = 0; i < meshes.size(); ++i)
            if (meshes[i].group.empty()) top.push_back(i);
        for (const auto& [name, children] : groups_) {
            root_["nodes"].push_back({{"name", name}, {"children", children}});
            top.push_back(root_["nodes"].size() - 1);
        }
        root_["scenes"] = json::array({{{"nodes", top}}});
        if (!channels_.empty())
            root_["animations"] = json::array({{{"name", "motion"}, {"channels", channels_}, {"samplers", samplers_}}});
        if (root_.contains("textures"))  // linear, repeated around the axis and clamped at its poles
            root_["samplers"] = json::array({{{"magFilter", 9729}, {"minFilter", 9729}, {"wrapS", 10497}, {"wrapT", 33071}}});
        root_["buffers"] = json::array({{{"byteLength", binary_.size()}}});
    }

    [[nodiscard]] std::vector<std::byte> bytes() const
    {
        std::string text = root_.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::vector<std::byte> out;
        const auto word = [&](std::uint64_t value) {
            if (value > 0xffffffffu)
                throw std::invalid_argument("the animation is larger than a GLB file can be: use fewer frames");
            for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::byte>(value >> shift & 0xff));
        };
        word(0x46546C67);
        word(2);
        word(12 + 8 + text.size() + 8 + binary_.size());
        word(text.size());
        word(0x4E4F534A);
        const auto* p = reinterpret_cast<const std::byte*>(text.data());
        out.insert(out.end(), p, p + text.size());
        word(binary_.size());
        word(0x004E4942);
        out.insert(out.end(), binary_.begin(), binary_.end());
        return out;
    }

private:
    template <class T>
    std::size_t add_view(std::span<const T> values, std::uint32_t target)
    {
        const std::size_t offset = binary_.size();
        const auto bytes = std::as_bytes(values);
        binary_.insert(binary_.end(), bytes.begin(), bytes.end());
        binary_.resize((binary_.size() + 3) / 4 * 4);
        json view{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}};
        if (target != 0) view["target"] = target;
        root_["bufferViews"].push_back(view);
        return root_["bufferViews"].size() - 1;
    }

    std::size_t add_accessor(json accessor)
    {
        root_["accessors"].push_back(std::move(accessor));
        return root_["accessors"].size() - 1;
    }

    std::size_t add_vectors(std::span<const Vec3d> values, bool with_bounds, std::uint32_t target)
    {
        std::vector<float> flat;
        flat.reserve(3 * values.size());
        Boxf box;
        for (const Vec3d& v : values) {
            const auto p = cast<float>(v);
            flat.insert(flat.end(), {p.x, p.y, p.z});
            extend(box, p);
        }
        json a{{"bufferView", add_view<float>(flat, target)},
               {"componentType", k_float},
               {"count", values.size()},
               {"type", "VEC3"}};
        if (with_bounds) {
            a["min"] = {box.lo.x, box.lo.y, box.lo.z};
            a["max"] = {box.hi.x, box.hi.y, box.hi.z};
        }
        return add_accessor(std::move(a));
    }

    std::size_t add_floats(std::span<const float> values, const char* type, std::size_t width, bool with_bounds)
    {
        json a{{"bufferView", add_view<float>(values, 0)},
               {"componentType", k_float},
               {"count", values.size() / width},
               {"type", type}};
        if (with_bounds) {
            a["min"] = {*std::min_element(values.begin(), values.end())};
            a["max"] = {*std::max_element(values.begin(), values.end())};
        }
        return add_accessor(std::move(a));
    }

    std::size_t add_texture(const DisplacementTexture& t)
    {
        root_["images"].push_back({{"name", t.name},
                                   {"bufferView", add_view<char>(std::span(t.png.data(), t.png.size()), 0)},
                                   {"mimeType", "image/png"}});
        root_["textures"].push_back({{"source", root_["images"].size() - 1}, {"sampler", 0}});
        return root_["textures"].size() - 1;
    }

    std::size_t add_material(const MovingMesh& m)
    {
        json material{{"name", m.name},
                      {"pbrMetallicRoughness",
                       {{"baseColorFactor", {m.colour[0], m.colour[1], m.colour[2], m.opacity}},
                        {"metallicFactor", 0},
                        {"roughnessFactor", 0.9}}},
                      {"doubleSided", m.two_sided}};
        if (m.opacity < 1) material["alphaMode"] = "BLEND";
        if (m.displacement)
            material["extras"]["displacementTexture"] = {{"index", add_texture(*m.displacement)},
                                                         {"texCoord", 0},
                                                         {"scale", m.displacement->scale},
                                                         {"midlevel", 0},
                                                         {"space", "normal"}};
        root_["materials"].push_back(std::move(material));
        return root_["materials"].size() - 1;
    }

    /// The mesh at its first shape, with the other shapes as morph targets.
    std::size_t add_mesh(const MovingMesh& m)
    {
        const std::span<const Vec3d> base = m.shapes.empty() ? std::span<const Vec3d>(m.positions) : m.shapes.front();
        const std::vector<Vec3d> normals = m.normals.empty() ? normals_of(base, m.triangles) : m.normals;
        std::vector<std::uint32_t> indices;
        for (const auto& t : m.triangles) indices.insert(indices.end(), t.begin(), t.end());
        const std::size_t index = add_accessor({{"bufferView", add_view<std::uint32_t>(indices, k_indices)},
                                                {"componentType", k_uint},
                                                {"count", indices.size()},
                                                {"type", "SCALAR"}});
        const std::size_t material = add_material(m);
        json attributes{{"POSITION", add_vectors(base, true, k_vertices)}};
        if (!m.flat) attributes["NORMAL"] = add_vectors(normals, false, k_vertices);
        if (!m.texture_coordinates.empty()) {
            std::vector<float> flat;
            for (const auto& [u, v] : m.texture_coordinates) flat.insert(flat.end(), {u, v});
            attributes["TEXCOORD_0"] = add_floats(flat, "VEC2", 2, false);
        }
        json primitive{{"attributes", attributes}, {"indices", index}, {"material", material}};
        for (std::size_t s = 1; s < m.shapes.size(); ++s) {
            const std::vector<Vec3d> bent = normals_of(m.shapes[s], m.triangles);
            std::vector<Vec3d> shift(base.size()), turn(base.size());
            for (std::size_t i = 0; i < base.size(); ++i) {
                shift[i] = m.shapes[s][i] - base[i];
                turn[i] = bent[i] - normals[i];
            }
            primitive["targets"].push_back(
                {{"POSITION", add_vectors(shift, true, k_vertices)}, {"NORMAL", add_vectors(turn, false, k_vertices)}});
        }
        json mesh{{"name", m.name}, {"primitives", json::array({primitive})}};
        if (m.shapes.size() > 1) mesh["weights"] = std::vector<float>(m.shapes.size() - 1, 0.f);
        root_["meshes"].push_back(std::move(mesh));
        return root_["meshes"].size() - 1;
    }

    void add_motion(const MovingMesh& m, std::size_t node)
    {
        const std::size_t targets = m.shapes.empty() ? 0 : m.shapes.size() - 1;
        if (m.times.size() < 2 || (targets == 0 && m.keys.empty())) return;
        std::vector<float> times;
        for (const double t : m.times) times.push_back(static_cast<float>(t));
        const std::size_t input = add_floats(times, "SCALAR", 1, true);
        const auto channel = [&](std::size_t output, const char* path) {
            channels_.push_back({{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", path}}}});
            samplers_.push_back({{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
        };
        if (targets > 0) {
            std::vector<float> weights(m.times.size() * targets, 0.f);
            for (std::size_t k = 1; k <= targets; ++k) weights[k * targets + k - 1] = 1.f;
            channel(add_floats(weights, "SCALAR", 1, false), "weights");
        }
        if (m.keys.empty()) return;
        std::vector<float> turns, shifts;
        std::array<double, 4> last{0, 0, 0, 1};
        for (const RigidKey& key : m.keys) {
            std::array<double, 4> q = quaternion_of(key.rotation);
            // The nearer of the two quaternions of a rotation, so that players take the short way.
            if (q[0] * last[0] + q[1] * last[1] + q[2] * last[2] + q[3] * last[3] < 0)
                for (double& v : q) v = -v;
            last = q;
            for (const double v : q) turns.push_back(static_cast<float>(v));
            for (int k = 0; k < 3; ++k) shifts.push_back(static_cast<float>(key.translation[k]));
        }
        channel(add_floats(turns, "VEC4", 4, false), "rotation");
        channel(add_floats(shifts, "VEC3", 3, false), "translation");
    }

    void add(const MovingMesh& m)
    {
        check(m);
        json node{{"name", m.name}, {"mesh", add_mesh(m)}};
        const std::size_t number = root_["nodes"].is_array() ? root_["nodes"].size() : 0;
        add_motion(m, number);
        if (!m.keys.empty()) {
            const auto q = quaternion_of(m.keys.front().rotation);
            const Vec3d t = m.keys.front().translation;
            node["rotation"] = {q[0], q[1], q[2], q[3]};
            node["translation"] = {t.x, t.y, t.z};
        }
        if (!m.extras.empty()) node["extras"] = json::parse(m.extras);
        if (!m.group.empty()) {
            const auto named = [&](const auto& group) { return group.first == m.group; };
            auto at = std::find_if(groups_.begin(), groups_.end(), named);
            if (at == groups_.end()) at = groups_.emplace(groups_.end(), m.group, std::vector<std::size_t>{});
            at->second.push_back(number);
        }
        root_["nodes"].push_back(std::move(node));
    }

    json root_ = json::object(), channels_ = json::array(), samplers_ = json::array();
    std::vector<std::pair<std::string, std::vector<std::size_t>>> groups_;  ///< name, and the nodes under it
    std::vector<std::byte> binary_;
};

}  // namespace

std::vector<std::byte> glb_bytes(std::span<const MovingMesh> meshes)
{
    if (meshes.empty()) throw std::invalid_argument("no mesh to write");
    return Writer(meshes).bytes();
}

void write_glb(const std::filesystem::path& path, std::span<const MovingMesh> meshes) { replace_file(path, glb_bytes(meshes)); }

}  // namespace sqmap::io
