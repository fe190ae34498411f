#include "common/dress/avatar.h"

#include "sqmap/bake/rebake.h"
#include "sqmap/bake/skin_lattice.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/math/box.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/model_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

namespace sqmap::app {
namespace {

void take_model(AvatarPart& part)
{
    if (const auto status = part.opened.parse(part.bytes); status != model::ParseStatus::Ok)
        throw io::ModelFileError(part.name + ": " + model::to_string(status) + "\n  cure: " + model::cure_of(status));
    part.model = part.opened.view();
}

double height_of(const Avatar& avatar)
{
    sqmap::Box box;
    for (const AvatarPart& part : avatar.parts) extend(box, box_of(part.mesh.vertices));
    return size(box).y;
}

/// The rigid motion nearest to a joint's map, about its bound position: rows made orthonormal in turn.
sqmap::Pose rigid(const Affine& map, Vec3d joint)
{
    Mat3d r = map.linear;
    r.row[0] = normalized(r.row[0]);
    r.row[1] = normalized(r.row[1] - dot(r.row[1], r.row[0]) * r.row[0]);
    r.row[2] = cross(r.row[0], r.row[1]);
    return {r, apply(map, joint) - r * joint};
}

/// Closed, with one vertex for each position: files double them along seams of textures.
void take_mesh(const std::filesystem::path& path, SkinnedBody& body)
{
    const io::SkinnedSoup& skin = body.file;
    // Vertices that a closing makes would follow no joint.
    const mesh::PolygonView polygons{skin.soup.positions, skin.soup.polygon_offsets, skin.soup.indices};
    const AdmittedMesh admitted = admit_mesh(polygons, {.admit = {.repair = mesh::Repair::Safe}});
    if (admitted.refused() || !admitted.solid)
        throw AvatarError(path.string() + ": its skinned mesh is no closed solid: see sqmap check " + path.string());
    std::map<std::array<double, 3>, std::size_t> positions;
    for (std::size_t v = 0; v < skin.soup.positions.size(); ++v) {
        const Vec3d p = skin.soup.positions[v];
        positions.try_emplace({p.x, p.y, p.z}, v);
    }
    body.bound = admitted.mesh;
    body.drawn = admitted.mesh.vertices;
    for (const Vec3d& p : admitted.mesh.vertices) {
        const auto found = positions.find({p.x, p.y, p.z});
        if (found == positions.end())
            throw AvatarError(path.string() + ": its skinned mesh has to be repaired first: see sqmap check " + path.string());
        body.influences.joints.push_back(skin.joints[found->second]);
        body.influences.weights.push_back(skin.weights[found->second]);
    }
}

/// For each joint the mean of the vertices that it moves: there the joint's rigid motion agrees with its map.
std::vector<Vec3d> bound_centres(const SkinnedBody& body)
{
    std::vector<Vec3d> sum(body.file.skeleton.size());
    std::vector<double> weight(sum.size());
    for (std::size_t v = 0; v < body.bound.vertices.size(); ++v)
        for (std::size_t k = 0; k < 4; ++k) {
            sum[body.influences.joints[v][k]] += body.influences.weights[v][k] * body.bound.vertices[v];
            weight[body.influences.joints[v][k]] += body.influences.weights[v][k];
        }
    for (std::size_t j = 0; j < sum.size(); ++j) sum[j] = weight[j] > 0 ? sum[j] / weight[j] : Vec3d{};
    return sum;
}

const io::SkinAnimation& animation_of(const std::filesystem::path& path, const io::SkinnedSoup& skin, const std::string& name)
{
    std::string all;
    for (const io::SkinAnimation& a : skin.animations) {
        if (name.empty() || a.name == name) return a;
        all += (all.empty() ? "" : ", ") + ("'" + a.name + "'");
    }
    throw AvatarError(path.string() + (all.empty() ? ": it has no animation" : ": no animation '" + name + "'; it has " + all));
}

/// True where an animation ends as it begins, so that it can be played again.
bool is_cycle(const io::SkinnedSoup& skin, const io::SkinAnimation& animation)
{
    const auto first = io::joint_maps(skin, io::poses_at(skin, animation, 0)),
               last = io::joint_maps(skin, io::poses_at(skin, animation, animation.duration));
    double turn = 0, shift = 0, size = 0;
    for (std::size_t j = 0; j < first.size(); ++j) {
        for (int k = 0; k < 3; ++k) turn = std::max(turn, norm(first[j].linear.row[k] - last[j].linear.row[k]));
        shift = std::max(shift, norm(first[j].shift - last[j].shift));
    }
    for (const Vec3d& p : skin.soup.positions) size = std::max(size, norm(p));
    return turn < 0.02 && shift < 0.02 * size;
}

}  // namespace

Avatar still_avatar(const std::filesystem::path& path)
{
    const paper::MappedModel mapped(path);
    Avatar avatar;
    AvatarPart& part = avatar.parts.emplace_back();
    part.name = path.stem().string();
    part.bytes.assign(mapped.bytes().begin(), mapped.bytes().end());
    take_model(part);
    const model::ModelView& view = part.model;
    part.mesh = bake::baked_mesh(view);
    for (Vec3d& v : part.mesh.vertices) v = model::to_mesh_units(view.header, cast<float>(v));
    if (part.mesh.triangles.empty())
        throw io::ModelFileError(path.string() +
                                 " was baked without the exact layer, whose triangles are what is dressed: bake it with --exact");
    avatar.pose = [](double, std::span<sqmap::Pose> poses) { std::fill(poses.begin(), poses.end(), sqmap::Pose{}); };
    avatar.height = height_of(avatar);
    return avatar;
}

Avatar walking_avatar(double height, const sim::Gait& gait, double spacing, double target_error,
                      const std::function<void(std::size_t done, std::size_t of)>& progress)
{
    constexpr std::size_t k_stages = 3;
    const auto done = [&](std::size_t stages) {
        if (progress) progress(stages, k_stages);
    };
    done(0);
    Person made = person(height, spacing);
    Avatar avatar;
    avatar.skin = std::make_unique<SkinnedBody>();
    SkinnedBody& body = *avatar.skin;
    body.bound = made.mesh;
    body.drawn = made.skin;
    body.influences = std::move(made.influences);
    body.maps.resize(made.bones.size());
    done(1);
    AvatarPart& part = avatar.parts.emplace_back();
    part.name = "figure";
    part.mesh = body.bound;
    const auto baking = [&](const char*, double) { done(1); };
    part.bytes = bake_mesh(part.mesh, {.bake = {.target_error = target_error, .progress = baking}}).bytes();
    take_model(part);
    done(2);
    body.lattice = bake::skin_lattice(body.bound, body.influences);
    body.lattice.bones = static_cast<std::uint32_t>(made.bones.size());
    body.moving = std::make_unique<query::MovingSkin>(body.lattice);
    for (const sim::Bone& bone : made.bones) avatar.joints.push_back(bone.name);
    avatar.pose = [&body, bones = std::move(made.bones), gait](double time, std::span<sqmap::Pose> poses) {
        poses[0] = {};
        sim::walk(bones, gait, time, poses.subspan(1));
        for (std::size_t b = 0; b < bones.size(); ++b) body.maps[b] = {poses[1 + b].rotation, poses[1 + b].translation};
        (void)body.moving->step(body.maps);
    };
    // Both ends of the first step are where it stands.
    std::vector<sqmap::Pose> first(1 + avatar.joints.size());
    avatar.pose(0, first);
    avatar.height = height_of(avatar);
    return avatar;
}

Avatar skinned_avatar(const std::filesystem::path& file, bool walk, const std::string& animation, double target_error)
{
    io::SkinResult read = io::read_skinned_file(file);
    if (read.error) throw AvatarError(file.string() + ": " + read.error->code + ": " + read.error->message);
    Avatar avatar;
    avatar.skin = std::make_unique<SkinnedBody>();
    SkinnedBody& body = *avatar.skin;
    body.file = std::move(read.skin);
    take_mesh(file, body);
    const io::SkinnedSoup& skin = body.file;
    std::vector<io::JointPose> rest = io::rest_poses(skin);
    body.maps = io::joint_maps(skin, rest);

    AvatarPart& part = avatar.parts.emplace_back();
    part.name = file.stem().string();
    part.mesh = body.bound;
    part.bytes = bake_mesh(part.mesh, {.bake = {.target_error = target_error}}).bytes();
    take_model(part);
    try {
        body.lattice = bake::skin_lattice(body.bound, body.influences);
    } catch (const mesh::InvalidInput& e) {
        throw AvatarError(file.string() + ": " + e.what());
    }
    // Joints that move nothing are there all the same.
    body.lattice.bones = static_cast<std::uint32_t>(skin.skeleton.size());
    body.moving = std::make_unique<query::MovingSkin>(body.lattice);
    const std::vector<Vec3d> centres = bound_centres(body);
    for (const io::SkinJoint& joint : skin.skeleton) avatar.joints.push_back(joint.name);
    const io::SkinAnimation* plays = walk ? &animation_of(file, skin, animation) : nullptr;
    const bool again = plays != nullptr && plays->duration > 0 && is_cycle(skin, *plays);
    avatar.pose = [&body, rest = std::move(rest), centres, plays, again](double time, std::span<sqmap::Pose> poses) {
        if (plays != nullptr) {
            const double at = std::max(0.0, time - 2), s = std::clamp(time - 1, 0.0, 1.0);
            const auto target = io::poses_at(body.file, *plays, again ? std::fmod(at, plays->duration) : at);
            body.maps = io::joint_maps(body.file, io::blended(rest, target, s * s * (3 - 2 * s)));
        }
        (void)body.moving->step(body.maps);
        poses[0] = {};
        for (std::size_t j = 0; j < body.maps.size(); ++j) poses[1 + j] = rigid(body.maps[j], centres[j]);
    };
    // Both ends of the first step are where it stands.
    (void)body.moving->step(body.maps);
    avatar.height = size(box_of(body.posed())).y;
    return avatar;
}

}  // namespace sqmap::app
