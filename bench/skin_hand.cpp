// The skinned hand that contacts are measured on: posed, as one closed mesh, and as rigid solids.
#include "skin_hand.h"

#include "clock.h"
#include "math/turns.h"
#include "sqmap/bake/skin_lattice.h"
#include "sqmap/bake_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <utility>

namespace sqmap::bench {
namespace {

/// How far a joint is bent, radians, when the finger is fully closed.
double curl_of(const std::string& name)
{
    const bool thumb = name.find("thumb") != std::string::npos;
    if (name.find("proximal") != std::string::npos) return thumb ? 0.5 : 1.2;
    if (name.find("intermediate") != std::string::npos) return 1.4;
    if (name.find("distal") != std::string::npos) return thumb ? 0.9 : 0.9;
    return 0;
}

/// The joint that each hangs on, -1 for none. The WebXR hand's file has its joints side by side, since a runtime gives each its
/// own pose: there it is the one before it of the same finger, and the wrist for the first.
std::vector<int> parents_of(const io::SkinnedSoup& skin)
{
    const std::vector<io::SkinJoint>& joints = skin.skeleton;
    std::vector<int> parents;
    for (const io::SkinJoint& j : joints) parents.push_back(j.parent);
    if (std::any_of(parents.begin(), parents.end(), [](int p) { return p >= 0; })) return parents;
    const auto finger = [&](std::size_t j) { return joints[j].name.substr(0, joints[j].name.find('-')); };
    const auto wrist = std::find_if(joints.begin(), joints.end(), [](const io::SkinJoint& j) { return j.name == "wrist"; });
    if (wrist == joints.end()) return parents;
    for (std::size_t j = 0; j < joints.size(); ++j)
        if (joints[j].name != "wrist")
            parents[j] = j > 0 && finger(j) == finger(j - 1) ? static_cast<int>(j) - 1 : static_cast<int>(wrist - joints.begin());
    return parents;
}

/// Inverse of a rigid motion.
Affine inverse(const Affine& map)
{
    const Pose pose = sqmap::inverse({map.linear, map.shift});
    return {pose.rotation, pose.translation};
}

}  // namespace

std::optional<io::SkinnedSoup> read_skin(const char* file)
{
    io::SkinResult read = io::read_skinned_file(file);
    if (!read.error) return std::move(read.skin);
    std::fprintf(stderr, "%s: %s\n", file, read.error->message.c_str());
    return std::nullopt;
}

std::vector<Affine> maps_of(const io::SkinnedSoup& skin, double curl, bool pointing)
{
    const std::vector<int> parents = parents_of(skin);
    std::vector<Affine> world(skin.skeleton.size());
    std::vector<bool> done(world.size());
    const auto position = [&](auto&& self, std::size_t j) -> const Affine& {
        if (done[j]) return world[j];
        const io::SkinJoint& joint = skin.skeleton[j];
        Affine local = joint.local;
        const bool hangs = parents[j] >= 0;
        const auto parent = static_cast<std::size_t>(hangs ? parents[j] : 0);
        // Side by side in the file, both are in the scene's frame.
        if (hangs && joint.parent < 0) local = inverse(skin.skeleton[parent].local) * local;
        const bool index = joint.name.find("index") != std::string::npos;
        local.linear = local.linear * about_x(-(pointing && index ? 0 : curl) * curl_of(joint.name));
        world[j] = hangs ? self(self, parent) * local : local;
        done[j] = true;
        return world[j];
    };
    std::vector<Affine> maps;
    for (std::size_t j = 0; j < world.size(); ++j) maps.push_back(position(position, j) * skin.skeleton[j].inverse_bind);
    return maps;
}

Bound welded(const io::SkinnedSoup& skin)
{
    Bound bound;
    std::map<std::array<double, 3>, std::uint32_t> positions;
    std::vector<std::uint32_t> number;
    for (std::size_t v = 0; v < skin.soup.positions.size(); ++v) {
        const Vec3d p = skin.soup.positions[v];
        const auto [at, fresh] = positions.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(bound.mesh.vertices.size()));
        if (fresh) {
            bound.mesh.vertices.push_back(p);
            bound.influences.joints.push_back(skin.joints[v]);
            bound.influences.weights.push_back(skin.weights[v]);
        }
        number.push_back(at->second);
    }
    for (std::size_t i = 0; i + 2 < skin.soup.indices.size(); i += 3) {
        mesh::Triangle t;
        for (std::size_t k = 0; k < 3; ++k) t[k] = number[static_cast<std::size_t>(skin.soup.indices[i + k])];
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) bound.mesh.triangles.push_back(t);
    }
    return bound;
}

BakedSkin::BakedSkin(const io::SkinnedSoup& skin, double cell)
    : bound(welded(skin)), r_max(mesh::largest_vertex_distance(bound.mesh))
{
    const double start = thread_seconds();
    bytes = bake_mesh(bound.mesh).bytes();
    if (model::parse(bytes, model) != model::ParseStatus::Ok) throw std::runtime_error("the bound model does not parse");
    const double baked = thread_seconds();
    lattice = bake::skin_lattice(bound.mesh, bound.influences, {.cell = cell});
    lattice.bones = static_cast<std::uint32_t>(skin.skeleton.size());
    posed.emplace(lattice);
    bake_seconds = baked - start;
    lattice_seconds = thread_seconds() - baked;
}

Solids::Solids(const Bound& bound, std::size_t joints, double least_weight)
{
    models_.reserve(joints);
    for (std::uint16_t j = 0; j < joints; ++j) {
        const auto solid = mesh::joint_solid(bound.mesh, bound.influences, j, least_weight);
        if (!solid) continue;
        Model& m = models_.emplace_back();
        m.joint = j;
        m.bytes = bake_mesh(*solid).bytes();
        if (model::parse(m.bytes, m.view) != model::ParseStatus::Ok) std::exit(70);
    }
}

void Solids::query_depths(const std::vector<Affine>& maps, const std::vector<Vec3d>& points, query::Layer layer,
                          std::vector<double>& depth) const
{
    query::Probe probe(points);
    std::vector<query::Contact> contacts(points.size());
    for (const Model& m : models_) {
        // A bone's map is rigid.
        const query::Body touched{.model = &m.view, .pose = {maps[m.joint].linear, maps[m.joint].shift}};
        const auto r = query::query_probe(touched, {.probe = &probe}, {.layer = layer}, contacts);
        for (std::size_t c = 0; c < std::min(r.contacts, contacts.size()); ++c)
            depth[contacts[c].index] = std::max(depth[contacts[c].index], static_cast<double>(contacts[c].depth));
    }
}

}  // namespace sqmap::bench
