// Contact verdicts of a skinned model made of rigid solids, one a joint, against the exact skinned mesh.
// usage: sqmap_skin HAND.glb OBJECT [LEAST_WEIGHT]     joints named as the WebXR hand's; the hand is closed and opened over the
// object
#include "sqmap/mesh/skin.h"
#include "sqmap/bake/bake.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/read.h"
#include "sqmap/io/read_skin.h"
#include "sqmap/math/random.h"
#include "sqmap/mesh/gate.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/frame.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace {

using namespace sqmap;

struct JointModel {
    std::uint16_t joint;
    std::vector<std::byte> bytes;
    model::ModelView view;
};

mesh::Affine affine(const io::AffineMap& m) { return {m.linear, m.shift}; }

Mat3d about_x(double a) { return {{{1, 0, 0}, {0, std::cos(a), -std::sin(a)}, {0, std::sin(a), std::cos(a)}}}; }

/// How far a joint is bent, radians, when the finger is fully closed.
double curl_of(const std::string& name)
{
    const bool thumb = name.find("thumb") != std::string::npos;
    if (name.find("proximal") != std::string::npos) return thumb ? 0.5 : 1.2;
    if (name.find("intermediate") != std::string::npos) return 1.4;
    if (name.find("distal") != std::string::npos) return thumb ? 0.9 : 0.9;
    return 0;
}

/// World of each joint times its inverse bind.
std::vector<mesh::Affine> maps_of(const io::SkinnedSoup& skin, double curl, bool pointing)
{
    std::vector<mesh::Affine> world(skin.skeleton.size());
    std::vector<bool> done(world.size());
    const auto place = [&](auto&& self, std::size_t j) -> const mesh::Affine& {
        if (done[j]) return world[j];
        const io::SkinJoint& joint = skin.skeleton[j];
        mesh::Affine local = affine(joint.local);
        const bool index = joint.name.find("index") != std::string::npos;
        local.linear = local.linear * about_x(-(pointing && index ? 0 : curl) * curl_of(joint.name));
        world[j] = joint.parent < 0 ? local : self(self, static_cast<std::size_t>(joint.parent)) * local;
        done[j] = true;
        return world[j];
    };
    std::vector<mesh::Affine> maps;
    for (std::size_t j = 0; j < world.size(); ++j) maps.push_back(place(place, j) * affine(skin.skeleton[j].inverse_bind));
    return maps;
}

}  // namespace

int main(int argc, char** argv)
{
    if (argc < 3) {
        std::fprintf(stderr, "usage: sqmap_skin HAND.glb OBJECT [LEAST_WEIGHT]\n");
        return 64;
    }
    const double least_weight = argc > 3 ? std::atof(argv[3]) : 0.05;
    const io::SkinResult read = io::read_skinned_file(argv[1]);
    if (read.error) {
        std::fprintf(stderr, "%s: %s\n", argv[1], read.error->message.c_str());
        return 2;
    }
    // Vertices along texture seams are doubled: the mesh is closed once equal places are one vertex.
    const io::SkinnedSoup& skin = read.skin;
    mesh::Mesh bound;
    mesh::Influences influences;
    std::map<std::array<double, 3>, std::uint32_t> places;
    std::vector<std::uint32_t> welded;
    for (std::size_t v = 0; v < skin.soup.positions.size(); ++v) {
        const Vec3d p = skin.soup.positions[v];
        const auto [at, fresh] = places.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(bound.vertices.size()));
        if (fresh) {
            bound.vertices.push_back(p);
            influences.joints.push_back(skin.joints[v]);
            influences.weights.push_back(skin.weights[v]);
        }
        welded.push_back(at->second);
    }
    for (std::size_t i = 0; i + 2 < skin.soup.indices.size(); i += 3) {
        mesh::Triangle t;
        for (std::size_t k = 0; k < 3; ++k) t[k] = welded[static_cast<std::size_t>(skin.soup.indices[i + k])];
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) bound.triangles.push_back(t);
    }
    std::printf("%zu joints, %zu vertices, %zu triangles\n", skin.skeleton.size(), bound.vertices.size(), bound.triangles.size());

    std::vector<JointModel> models;
    models.reserve(skin.skeleton.size());
    for (std::uint16_t j = 0; j < skin.skeleton.size(); ++j) {
        const auto solid = mesh::joint_solid(bound, influences, j, least_weight);
        if (!solid) {
            std::printf("  %s: moves nothing that closes\n", skin.skeleton[j].name.c_str());
            continue;
        }
        JointModel& m = models.emplace_back();
        m.joint = j;
        m.bytes = io::serialize(bake::bake(*solid, true, {}).model);
        if (model::parse(m.bytes, m.view) != model::ParseStatus::Ok) return 70;
    }
    const double r_max = mesh::largest_vertex_distance(bound);

    const io::ReadResult object = io::read_mesh_file(argv[2]);
    if (object.error) return 2;
    std::vector<Vec3d> points = object.soup.positions;
    Vec3d lo = points.front(), hi = lo;
    for (const Vec3d& p : points)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }

    // The object, 0.8 times as large as the hand, is put about the middle of the fingers and shaken.
    SplitMix64 random(7);
    std::size_t near = 0, wrong = 0, false_in = 0, false_out = 0;
    double worst = 0;
    std::map<std::string, std::size_t> where;
    for (const auto& [pose_name, pointing] : {std::pair{"fist", false}, {"point", true}})
        for (int step = 0; step <= 4; ++step) {  // from open to closed
            const std::vector<mesh::Affine> maps = maps_of(skin, 0.25 * step, pointing);
            mesh::Mesh posed = bound;
            posed.vertices = mesh::skinned(bound.vertices, influences, maps);
            const mesh::Bvh bvh(posed);
            std::size_t pose_near = 0, pose_wrong = 0;
            for (int shake = 0; shake < 4; ++shake) {
                const Vec3d centre = posed.vertices[random.bits() % posed.vertices.size()];
                const double scale = 0.8 * r_max / norm(hi - lo);
                std::vector<Vec3d> placed;
                for (const Vec3d& p : points) placed.push_back(centre + scale * (p - 0.5 * (lo + hi)));
                query::Probe probe(placed);
                std::vector<std::uint8_t> inside(placed.size());
                std::vector<query::FrameContact> contacts(placed.size());
                for (const JointModel& m : models) {
                    // A bone's map is rigid, so its inverse is the transpose; scale is checked by the caller's eye.
                    const mesh::Affine& a = maps[m.joint];
                    const query::Pose pose = query::inverse({a.linear, a.shift});
                    const auto r = query::query_frame(m.view, probe, pose, {}, contacts);
                    for (std::size_t c = 0; c < std::min(r.contacts, contacts.size()); ++c) inside[contacts[c].index] = 1;
                }
                for (std::size_t i = 0; i < placed.size(); ++i) {
                    const mesh::ClosestPoint closest = bvh.closest_point(placed[i], 0.03 * r_max);
                    if (!(closest.distance < 0.03 * r_max)) continue;
                    ++pose_near;
                    const bool truth = bvh.winding_number(placed[i]) > 0;
                    if (truth == (inside[i] != 0)) continue;
                    if (closest.distance <= 0.005 * r_max) continue;
                    ++pose_wrong;
                    (truth ? false_out : false_in) += 1;
                    worst = std::max(worst, closest.distance);
                    // Whose: the joint that moves the nearest triangle most.
                    const std::uint32_t v = posed.triangles[closest.triangle][0];
                    const std::size_t k =
                        static_cast<std::size_t>(std::max_element(influences.weights[v].begin(), influences.weights[v].end()) -
                                                 influences.weights[v].begin());
                    ++where[skin.skeleton[influences.joints[v][k]].name];
                }
            }
            std::printf("%-6s %3d %% closed: %6zu near, %5zu wrong beyond 0.5 %% of R_max (%.2f %%)\n", pose_name, 25 * step,
                        pose_near, pose_wrong,
                        100.0 * static_cast<double>(pose_wrong) / static_cast<double>(std::max<std::size_t>(pose_near, 1)));
            near += pose_near;
            wrong += pose_wrong;
        }
    std::printf(
        "all: %zu near, %zu wrong (%.2f %%): %zu called free, %zu called inside; worst %.2f %% of R_max; solids of %zu joints\n",
        near, wrong, 100.0 * static_cast<double>(wrong) / static_cast<double>(std::max<std::size_t>(near, 1)), false_out,
        false_in, 100 * worst / r_max, models.size());
    for (const auto& [name, count] : where) std::printf("  %-34s %zu\n", name.c_str(), count);
}
