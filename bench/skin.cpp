// Contacts of a skinned model against the exact skinned mesh: carried back through the blend, and for comparison made of rigid
// solids, one a joint. Joints named as the WebXR hand's; the hand is closed and opened over the object.
#include "common/layer_name.h"
#include "measure.h"
#include "skin_hand.h"

#include "sqmap/bake/bake.h"
#include "sqmap/bake/skin_lattice.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/read.h"
#include "sqmap/io/read_skin.h"
#include "sqmap/math/random.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/skin.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace sqmap;
using bench::Bound;
using bench::maps_of;
using bench::Solids;
using bench::welded;

double cpu_seconds()
{
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Verdicts of one method over all poses.
struct Tally {
    const char* name = "";
    std::size_t near = 0, wrong = 0, false_in = 0, false_out = 0;
    double worst = 0;
    std::vector<double> depth_error, normal_error;
    std::map<std::string, std::size_t> where;
};

double percentile(std::vector<double> v, double share)
{
    if (v.empty()) return 0;
    std::sort(v.begin(), v.end());
    return v[static_cast<std::size_t>(share * static_cast<double>(v.size() - 1))];
}

}  // namespace

int sqmap::bench::measure_skin(int argc, char** argv)
{
    double cell = bake::SkinLatticeOptions{}.cell, least_weight = 0;
    query::Layer layer = query::Layer::Three;
    const char* worst_file = nullptr;
    for (int i = 3; i + 1 < argc; i += 2) {
        const std::string name = argv[i], value = argv[i + 1];
        if (name == "--cell") cell = std::atof(argv[i + 1]);
        if (name == "--layer") layer = app::layer_named(value).value_or(query::Layer::Three);
        if (name == "--solids") least_weight = std::atof(argv[i + 1]);
        if (name == "--worst") worst_file = argv[i + 1];
    }
    if (argc < 3 || argc % 2 == 0) return k_wrong_usage;
    const std::optional<io::SkinnedSoup> read = bench::read_skin(argv[1]);
    if (!read) return 2;
    const io::SkinnedSoup& skin = *read;
    const Bound bound = welded(skin);
    const double r_max = mesh::largest_vertex_distance(bound.mesh);
    std::printf("%zu joints, %zu vertices, %zu triangles\n", skin.skeleton.size(), bound.mesh.vertices.size(),
                bound.mesh.triangles.size());
    double start = cpu_seconds();
    const std::vector<std::byte> bytes = io::serialize(bake::bake(bound.mesh, true, {}).model);
    model::ModelView model;
    if (model::parse(bytes, model) != model::ParseStatus::Ok) return 70;
    const double baked = cpu_seconds();
    query::SkinLattice lattice = bake::skin_lattice(bound.mesh, bound.influences, {.cell = cell});
    lattice.bones = static_cast<std::uint32_t>(skin.skeleton.size());
    query::PosedSkin posed_skin(lattice);
    std::size_t rigid = 0, max_pulls = 0;
    for (const auto& n : lattice.nodes) rigid += n.bone != query::SkinLattice::k_none ? 1 : 0;
    for (std::size_t c = 0; c + 1 < lattice.first_pull.size(); ++c)
        max_pulls = std::max<std::size_t>(max_pulls, lattice.first_pull[c + 1] - lattice.first_pull[c]);
    std::printf(
        "bound model %.2f s, %zu bytes; lattice of cells %.4f of R_max %.2f s: %zu blended, %zu boxes of rigid ones, %zu "
        "corners, "
        "%zu pulls (at most %zu)\n",
        baked - start, bytes.size(), cell, cpu_seconds() - baked, lattice.corners.size(), rigid, lattice.first_pull.size() - 1,
        lattice.pulls.size(), max_pulls);
    std::optional<Solids> solids;
    if (least_weight > 0) solids.emplace(bound, skin.skeleton.size(), least_weight);

    const io::ReadResult object = io::read_mesh_file(argv[2]);
    if (object.error) return 2;
    std::vector<Vec3d> points = object.soup.positions;
    Vec3d lo = points.front(), hi = lo;
    for (const Vec3d& p : points)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }
    std::FILE* out = worst_file != nullptr ? std::fopen(worst_file, "w") : nullptr;
    if (out != nullptr) std::fprintf(out, "pose,method,what,x,y,z,percent\n");

    // The object, 0.8 times as large as the hand, is put about the middle of the fingers and shaken.
    SplitMix64 random(7);
    std::vector<Tally> tallies(solids ? 2 : 1);
    tallies.front().name = "blend";
    if (solids) tallies.back().name = "solids";
    double pose_seconds = 0, query_seconds = 0;
    std::size_t frames = 0, queried = 0, crowded = 0;
    for (const auto& [pose_name, pointing] : {std::pair{"fist", false}, {"point", true}})
        for (int step = 0; step <= 4; ++step) {  // from open to closed
            const std::vector<Affine> maps = maps_of(skin, 0.25 * step, pointing);
            mesh::Mesh posed = bound.mesh;
            posed.vertices = mesh::skinned(bound.mesh.vertices, bound.influences, maps);
            const mesh::Solid truth(posed, mesh::find_self_intersections(posed).crossed);
            if (!posed_skin.pose(maps)) return 70;
            std::printf("%-6s %3d %% closed: deviates by %.3f %% of R_max;", pose_name, 25 * step,
                        100 * bake::skin_deviation(lattice, bound.mesh, bound.influences, maps) / r_max);
            const auto write = [&, name = pose_name, at = step](const char* method, const char* what, Vec3d p, double percent) {
                if (out != nullptr)
                    std::fprintf(out, "%s %d,%s,%s,%g,%g,%g,%g\n", name, 25 * at, method, what, p.x, p.y, p.z, percent);
            };
            for (const Vec3d& p : posed.vertices) write("mesh", "vertex", p, 0);
            std::size_t pose_near = 0;
            std::vector<std::size_t> pose_wrong(tallies.size(), 0);
            for (int shake = 0; shake < 4; ++shake) {
                const Vec3d centre = posed.vertices[random.bits() % posed.vertices.size()];
                const double scale = 0.8 * r_max / norm(hi - lo);
                std::vector<Vec3d> probe_points;
                for (const Vec3d& p : points) probe_points.push_back(centre + scale * (p - 0.5 * (lo + hi)));
                std::vector<std::vector<double>> depth(tallies.size(), std::vector<double>(probe_points.size(), -1));
                std::vector<Vec3d> normal(probe_points.size());
                query::SkinWorkspace workspace(lattice, probe_points);
                std::vector<query::SkinContact> contacts(probe_points.size());
                query::ProbeResult r;
                for (int again = 0; again < 20; ++again) {
                    start = cpu_seconds();
                    (void)posed_skin.pose(maps);
                    const double is_posed = cpu_seconds();
                    r = query::query_skin({&model, &posed_skin, probe_points, {}}, {.layer = layer}, workspace, contacts);
                    pose_seconds += is_posed - start;
                    query_seconds += cpu_seconds() - is_posed;
                    ++frames;
                }
                crowded += (r.status & query::k_crowded) != 0 ? 1 : 0;
                queried += probe_points.size();
                for (std::size_t c = 0; c < r.contacts; ++c) {
                    depth[0][contacts[c].index] = contacts[c].depth;
                    normal[contacts[c].index] = contacts[c].normal;
                }
                if (solids) solids->query_depths(maps, probe_points, layer, depth[1]);
                for (std::size_t i = 0; i < probe_points.size(); ++i) {
                    const mesh::ClosestPoint closest = truth.bvh().closest_point(probe_points[i], 0.03 * r_max);
                    if (!(closest.distance < 0.03 * r_max)) continue;
                    ++pose_near;
                    const bool inside = truth.inside(probe_points[i]);
                    const mesh::ClosestPoint boundary = truth.closest_boundary(probe_points[i]);
                    for (std::size_t m = 0; m < tallies.size(); ++m) {
                        Tally& tally = tallies[m];
                        if (inside && depth[m][i] >= 0) {
                            tally.depth_error.push_back(100 * std::abs(depth[m][i] - boundary.distance) / r_max);
                            if (tally.depth_error.back() > 0.5)
                                write(tally.name, "depth", probe_points[i], tally.depth_error.back());
                            if (m == 0 && boundary.distance > 1e-4 * r_max) {
                                const Vec3d n = normalized(boundary.point - probe_points[i]);
                                tally.normal_error.push_back(180 / M_PI * std::acos(std::clamp(dot(n, normal[i]), -1.0, 1.0)));
                            }
                        }
                        if (inside == (depth[m][i] >= 0) || closest.distance <= 0.005 * r_max) continue;
                        ++pose_wrong[m];
                        (inside ? tally.false_out : tally.false_in) += 1;
                        tally.worst = std::max(tally.worst, closest.distance);
                        // Whose: the joint that moves the nearest triangle most.
                        const std::uint32_t v = posed.triangles[closest.triangle][0];
                        const auto& weights = bound.influences.weights[v];
                        const auto k =
                            static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
                        ++tally.where[skin.skeleton[bound.influences.joints[v][k]].name];
                        write(tally.name, "verdict", probe_points[i], 100 * closest.distance / r_max);
                    }
                }
            }
            for (std::size_t m = 0; m < tallies.size(); ++m) {
                tallies[m].near += pose_near;
                tallies[m].wrong += pose_wrong[m];
                std::printf(
                    " %s: %zu of %zu wrong beyond 0.5 %% of R_max (%.2f %%)", tallies[m].name, pose_wrong[m], pose_near,
                    100.0 * static_cast<double>(pose_wrong[m]) / static_cast<double>(std::max<std::size_t>(pose_near, 1)));
            }
            std::printf("\n");
        }
    if (out != nullptr) std::fclose(out);
    for (const Tally& t : tallies) {
        std::printf("%s: %zu near, %zu wrong (%.2f %%): %zu called free, %zu called inside; worst %.2f %% of R_max\n", t.name,
                    t.near, t.wrong, 100.0 * static_cast<double>(t.wrong) / static_cast<double>(std::max<std::size_t>(t.near, 1)),
                    t.false_out, t.false_in, 100 * t.worst / r_max);
        std::printf("  depth error, %% of R_max: median %.3f p95 %.3f max %.3f of %zu\n", percentile(t.depth_error, 0.5),
                    percentile(t.depth_error, 0.95), percentile(t.depth_error, 1), t.depth_error.size());
        if (!t.normal_error.empty())
            std::printf("  normal error, degrees: median %.2f p95 %.1f\n", percentile(t.normal_error, 0.5),
                        percentile(t.normal_error, 0.95));
        for (const auto& [name, count] : t.where) std::printf("  %-34s %zu\n", name.c_str(), count);
    }
    std::printf("blend: %.1f us a pose, %.1f us a frame of %zu points (%.0f ns a point); %zu crowded\n",
                1e6 * pose_seconds / static_cast<double>(frames), 1e6 * query_seconds / static_cast<double>(frames),
                points.size(), 1e9 * query_seconds / (20.0 * static_cast<double>(queried)), crowded);
    return 0;
}
