#include "dress/avatar.h"

#include "sqmap/bake/bake.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/shapes.h"

#include <algorithm>
#include <memory>

namespace sqmap::app {
namespace {

void take_model(AvatarPart& part)
{
    if (const auto status = model::parse(part.bytes, part.model); status != model::ParseStatus::Ok)
        throw io::ModelFileError(part.name + ": " + model::to_string(status));
}

double height_of(const Avatar& avatar)
{
    double lo = INFINITY, hi = -INFINITY;
    for (const AvatarPart& part : avatar.parts)
        for (const Vec3d& v : part.mesh.vertices) {
            lo = std::min(lo, v.y);
            hi = std::max(hi, v.y);
        }
    return hi - lo;
}

}  // namespace

Avatar still_avatar(const std::filesystem::path& path)
{
    const io::MappedModel mapped(path);
    Avatar avatar;
    AvatarPart& part = avatar.parts.emplace_back();
    part.name = path.stem().string();
    part.bytes.assign(mapped.bytes().begin(), mapped.bytes().end());
    take_model(part);
    const model::ModelView& view = part.model;
    const Vec3d origin{view.header.origin[0], view.header.origin[1], view.header.origin[2]};
    for (std::size_t v = 0; v + 2 < view.vertices.size(); v += 3)
        part.mesh.vertices.push_back(origin + view.header.unit * cast<double>(model::vec3(&view.vertices[v])));
    for (std::uint32_t t = 0; t < view.triangle_part.size(); ++t)
        part.mesh.triangles.push_back(
            {model::triangle_vertex(view, t, 0), model::triangle_vertex(view, t, 1), model::triangle_vertex(view, t, 2)});
    if (part.mesh.triangles.empty())
        throw io::ModelFileError(path.string() + " was baked without its exact layer: bake it with it");
    avatar.pose = [](double, std::span<query::Pose> poses) { std::fill(poses.begin(), poses.end(), query::Pose{}); };
    avatar.height = height_of(avatar);
    return avatar;
}

Avatar walking_avatar(double height, const sim::Gait& gait, double spacing, double target_error,
                      const std::function<void(std::size_t done, std::size_t of)>& progress)
{
    const auto bones = std::make_shared<std::vector<sim::Bone>>(sim::capsule_human(height));
    Avatar avatar;
    avatar.parts.reserve(bones->size());
    for (const sim::Bone& bone : *bones) {
        if (progress) progress(avatar.parts.size(), bones->size());
        mesh::CapsuleSolid solid;
        solid.blend = 0.15 * spacing;
        for (const sim::BoneCapsule& c : bone.flesh) solid.capsules.push_back({c.a, c.b, c.radius_a, c.radius_b});
        AvatarPart& part = avatar.parts.emplace_back();
        part.name = bone.name;
        part.mesh = mesh::polygonized(solid, spacing);
        bake::BakeOptions options;
        options.target_error = target_error;
        part.bytes = io::serialize(bake::bake(part.mesh, true, options).model);
        take_model(part);
    }
    avatar.pose = [bones, gait](double time, std::span<query::Pose> poses) { sim::walk(*bones, gait, time, poses); };
    avatar.height = height_of(avatar);
    return avatar;
}

}  // namespace sqmap::app
