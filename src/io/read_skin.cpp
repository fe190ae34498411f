#include "sqmap/io/read_skin.h"

#include "gltf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <utility>

namespace sqmap::io {
namespace {

/// The first skinned mesh of a file, with its joints and their animations.
class SkinReader {
public:
    explicit SkinReader(GltfFile& file) : file_(file), triangles_(file) {}

    SkinnedSoup read()
    {
        const json* nodes = array_or_null(file_.root(), "nodes", "nodes");
        for (std::uint64_t n = 0; nodes != nullptr && n < nodes->size(); ++n) {
            const std::string where = name_of("node", n);
            const json& node = item(file_.root(), "nodes", n);
            if (!node.contains("mesh") || !node.contains("skin")) continue;
            SkinnedSoup out;
            const std::uint64_t mesh = whole(node, "mesh", where);
            const std::vector<std::int64_t> joint_of = add_joints(whole(node, "skin", where), *nodes, out.skeleton);
            add_animations(joint_of, out);
            const json* primitives = array_or_null(item(file_.root(), "meshes", mesh), "primitives", name_of("mesh", mesh));
            for (const json& primitive : primitives != nullptr ? *primitives : json::array())
                add_influences(primitive, name_of("mesh", mesh), out);
            triangles_.add_mesh(mesh, Affine{});
            if (out.joints.size() != triangles_.soup.positions.size())
                fail_format(name_of("mesh", mesh), "a primitive has no joints or is not made of triangles");
            out.soup = std::move(triangles_.soup);
            return out;
        }
        fail_format("nodes", "no node has both a mesh and a skin");
    }

private:
    /// Returns of each node which joint it is, or -1.
    std::vector<std::int64_t> add_joints(std::uint64_t index, const json& nodes, std::vector<SkinJoint>& out)
    {
        const std::string where = name_of("skin", index);
        const json& skin = item(file_.root(), "skins", index);
        const json* list = array_or_null(skin, "joints", where);
        if (list == nullptr || list->empty() || list->size() > 65535)
            fail_format(where, "'joints' is missing, empty or too long");
        std::vector<std::int64_t> parent(nodes.size(), -1), joint_of(nodes.size(), -1);
        for (std::uint64_t n = 0; n < nodes.size(); ++n)
            if (const json* children = array_or_null(item(file_.root(), "nodes", n), "children", name_of("node", n)))
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
            bind = file_.accessor(whole(skin, "inverseBindMatrices", where));
            if (bind->type != "MAT4" || bind->component != 5126 || bind->count < node_of.size())
                fail_format(where, "inverseBindMatrices are not a matrix a joint");
        }
        for (std::size_t j = 0; j < node_of.size(); ++j) {
            SkinJoint joint;
            const json& node = item(file_.root(), "nodes", node_of[j]);
            if (const auto name = node.find("name"); name != node.end() && name->is_string())
                joint.name = name->get<std::string>();
            const Affine own = affine_of(node, name_of("node", node_of[j]));
            Affine above;
            joint.has_matrix = node.contains("matrix");
            if (!joint.has_matrix) joint.rest = pose_of(node, name_of("node", node_of[j]));
            // Nodes between a joint and the joint above it do not move by themselves.
            std::int64_t up = parent[node_of[j]];
            for (std::size_t steps = 0; up >= 0 && joint_of[static_cast<std::size_t>(up)] < 0; ++steps) {
                if (steps > nodes.size()) fail_format("nodes", "every node is another's child: nodes must form a tree");
                above = affine_of(item(file_.root(), "nodes", static_cast<std::uint64_t>(up)),
                                  name_of("node", static_cast<std::uint64_t>(up))) *
                        above;
                up = parent[static_cast<std::size_t>(up)];
            }
            joint.parent = up < 0 ? -1 : static_cast<int>(joint_of[static_cast<std::size_t>(up)]);
            joint.above = above;
            joint.local = above * own;
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
        const json* animations = array_or_null(file_.root(), "animations", "animations");
        for (std::uint64_t a = 0; animations != nullptr && a < animations->size(); ++a) {
            const std::string where = name_of("animation", a);
            const json& animation = item(file_.root(), "animations", a);
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
        const Accessor times = file_.accessor(whole(sampler, "input", where)),
                       values = file_.accessor(whole(sampler, "output", where));
        const std::size_t each = track.between == JointTrack::Between::Cubic ? 3 : 1, width = turns ? 4 : 3;
        if (times.type != "SCALAR" || times.component != 5126 || values.type != (turns ? "VEC4" : "VEC3") || times.count == 0 ||
            values.count != each * times.count)
            fail_format(where, "a sampler's input and output do not match");
        const std::uint64_t cost = times.count * (sizeof(double) + each * sizeof(track.values.front()));
        file_.spend(cost, where, "its channels unfold to far more than the file's size", "export fewer channels");
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
        const Accessor joints = file_.accessor(whole(*attributes, "JOINTS_0", where)),
                       weights = file_.accessor(whole(*attributes, "WEIGHTS_0", where));
        if (joints.type != "VEC4" || weights.type != "VEC4" || joints.count != weights.count)
            fail_format(where, "JOINTS_0 and WEIGHTS_0 do not match");
        check_face_limit(joints.count, file_.limits());
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

    GltfFile& file_;
    GltfTriangles triangles_;
};

}  // namespace

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
        GltfFile file(bytes, path.parent_path(), limits);
        result.skin = SkinReader(file).read();
    } catch (const ReadFailure& failure) {
        result.error = failure.error;
    }
    return result;
}

}  // namespace sqmap::io
