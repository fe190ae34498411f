// Contacts of a skinned model against the exact skinned mesh: carried back through the blend, and for comparison made of rigid
// solids, one a joint. Joints named as the WebXR hand's; the hand is closed and opened over the object.
#include "clock.h"
#include "common/layer_name.h"
#include "frames.h"
#include "measure.h"
#include "skin_hand.h"

#include "math/random.h"
#include "sqmap/bake/bake_types.h"
#include "sqmap/bake/skin_lattice.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/read.h"
#include "sqmap/io/read_skin.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/skin.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace sqmap;
using bench::Bound;
using bench::maps_of;
using bench::Solids;
using bench::welded;

/// Verdicts of one method over all poses.
struct Tally {
    const char* name = "";
    std::size_t near = 0, wrong = 0, false_in = 0, false_out = 0;
    double worst = 0;
    std::vector<double> depth_error, normal_error;
    std::map<std::string, std::size_t> where;
};

double percentile(const std::vector<double>& v, double share) { return v.empty() ? 0 : bench::percentile(v, share); }

double percent(std::size_t n, std::size_t of)
{
    return 100.0 * static_cast<double>(n) / static_cast<double>(std::max<std::size_t>(of, 1));
}

struct Options {
    double cell = bake::SkinLatticeOptions{}.cell, least_weight = 0;
    query::Layer layer = query::Layer::Three;
    const char* worst_file = nullptr;
};

Options parsed(int argc, char** argv)
{
    Options o;
    for (int i = 3; i + 1 < argc; i += 2) {
        const std::string name = argv[i], value = argv[i + 1];
        if (name == "--cell") o.cell = std::atof(argv[i + 1]);
        if (name == "--layer") o.layer = app::layer_named(value).value_or(query::Layer::Three);
        if (name == "--solids") o.least_weight = std::atof(argv[i + 1]);
        if (name == "--worst") o.worst_file = argv[i + 1];
    }
    return o;
}

/// The skinned mesh in one pose, and the points of the object that are tried against it.
struct PosedMesh {
    std::string name;
    std::vector<Affine> maps;
    mesh::Mesh mesh;
    mesh::Solid truth;
    std::size_t near = 0;
    std::vector<std::size_t> wrong;  ///< of each method
};

/// Both methods' answers for the points of one place.
struct Answers {
    std::vector<std::vector<double>> depth;  ///< of each method; below 0: free
    std::vector<Vec3d> normal;               ///< the lattice's
};

/// The object, 0.8 times as large as the hand, is put about the middle of the fingers and shaken; each place is answered by the
/// lattice, and by rigid solids where wanted, and judged by the exact skinned mesh.
class SkinRace {
public:
    SkinRace(const io::SkinnedSoup& skin, std::vector<Vec3d> object, const Options& options)
        : skin_(skin), options_(options), baked_(skin, options.cell), object_(std::move(object))
    {
        std::printf("%zu joints, %zu vertices, %zu triangles\n", skin.skeleton.size(), baked_.bound.mesh.vertices.size(),
                    baked_.bound.mesh.triangles.size());
        print_lattice();
        if (options.least_weight > 0) solids_.emplace(baked_.bound, skin.skeleton.size(), options.least_weight);
        tallies_.resize(solids_ ? 2 : 1);
        tallies_.front().name = "blend";
        if (solids_) tallies_.back().name = "solids";
        lo_ = hi_ = object_.front();
        for (const Vec3d& p : object_)
            for (int k = 0; k < 3; ++k) {
                lo_[k] = std::min(lo_[k], p[k]);
                hi_[k] = std::max(hi_[k], p[k]);
            }
        if (options.worst_file != nullptr) worst_.reset(std::fopen(options.worst_file, "w"));
        if (worst_) std::fprintf(worst_.get(), "pose,method,what,x,y,z,percent\n");
    }

    /// Curls the fingers by a share of a fist.
    void run(const char* pose_name, double curl, bool pointing)
    {
        std::vector<Affine> maps = maps_of(skin_, curl, pointing);
        mesh::Mesh posed = baked_.bound.mesh;
        posed.vertices = mesh::skinned(baked_.bound.mesh.vertices, baked_.bound.influences, maps);
        const int closed = static_cast<int>(std::lround(100 * curl));
        PosedMesh at{pose_name + (" " + std::to_string(closed)),
                     std::move(maps),
                     posed,
                     mesh::Solid(posed, mesh::find_self_intersections(posed).crossed),
                     0,
                     std::vector<std::size_t>(tallies_.size(), 0)};
        if (!baked_.posed->pose(at.maps)) throw std::runtime_error("a pose is not finite");
        std::printf(
            "%-6s %3d %% closed: deviates by %.3f %% of R_max;", pose_name, closed,
            100 * bake::skin_deviation(baked_.lattice, baked_.bound.mesh, baked_.bound.influences, at.maps) / baked_.r_max);
        for (const Vec3d& p : posed.vertices) write(at, "mesh", "vertex", p, 0);
        for (int shake = 0; shake < 4; ++shake) {
            const Vec3d centre = posed.vertices[random_.bits() % posed.vertices.size()];
            const double scale = 0.8 * baked_.r_max / norm(hi_ - lo_);
            std::vector<Vec3d> points;
            for (const Vec3d& p : object_) points.push_back(centre + scale * (p - 0.5 * (lo_ + hi_)));
            const Answers answers = answered(at, points);
            for (std::size_t i = 0; i < points.size(); ++i) judge(at, points[i], answers, i);
        }
        for (std::size_t m = 0; m < tallies_.size(); ++m) {
            tallies_[m].near += at.near;
            tallies_[m].wrong += at.wrong[m];
            std::printf(" %s: %zu of %zu wrong beyond 0.5 %% of R_max (%.2f %%)", tallies_[m].name, at.wrong[m], at.near,
                        percent(at.wrong[m], at.near));
        }
        std::printf("\n");
    }

    void report() const
    {
        for (const Tally& t : tallies_) {
            std::printf("%s: %zu near, %zu wrong (%.2f %%): %zu called free, %zu called inside; worst %.2f %% of R_max\n", t.name,
                        t.near, t.wrong, percent(t.wrong, t.near), t.false_out, t.false_in, 100 * t.worst / baked_.r_max);
            std::printf("  depth error, %% of R_max: median %.3f p95 %.3f max %.3f of %zu\n", percentile(t.depth_error, 0.5),
                        percentile(t.depth_error, 0.95), percentile(t.depth_error, 1), t.depth_error.size());
            if (!t.normal_error.empty())
                std::printf("  normal error, degrees: median %.2f p95 %.1f\n", percentile(t.normal_error, 0.5),
                            percentile(t.normal_error, 0.95));
            for (const auto& [name, count] : t.where) std::printf("  %-34s %zu\n", name.c_str(), count);
        }
        std::printf("blend: %.1f us a pose, %.1f us a frame of %zu points (%.0f ns a point); %zu crowded\n",
                    1e6 * pose_seconds_ / static_cast<double>(frames_), 1e6 * query_seconds_ / static_cast<double>(frames_),
                    object_.size(), 1e9 * query_seconds_ / (k_repeats * static_cast<double>(queried_)), crowded_);
    }

private:
    static constexpr int k_repeats = 20;  ///< of each timed query

    void print_lattice() const
    {
        const query::SkinLattice& lattice = baked_.lattice;
        std::size_t rigid = 0, max_pulls = 0;
        for (const auto& n : lattice.nodes) rigid += n.bone != query::SkinLattice::k_none ? 1 : 0;
        for (std::size_t c = 0; c + 1 < lattice.first_pull.size(); ++c)
            max_pulls = std::max<std::size_t>(max_pulls, lattice.first_pull[c + 1] - lattice.first_pull[c]);
        std::printf(
            "bound model %.2f s, %zu bytes; lattice of cells %.4f of R_max %.2f s: %zu blended, %zu boxes of rigid ones, %zu "
            "corners, %zu pulls (at most %zu)\n",
            baked_.bake_seconds, baked_.bytes.size(), options_.cell, baked_.lattice_seconds, lattice.corners.size(), rigid,
            lattice.first_pull.size() - 1, lattice.pulls.size(), max_pulls);
    }

    void write(const PosedMesh& at, const char* method, const char* what, Vec3d p, double off)
    {
        if (worst_) std::fprintf(worst_.get(), "%s,%s,%s,%g,%g,%g,%g\n", at.name.c_str(), method, what, p.x, p.y, p.z, off);
    }

    Answers answered(const PosedMesh& at, const std::vector<Vec3d>& points)
    {
        Answers out{std::vector<std::vector<double>>(tallies_.size(), std::vector<double>(points.size(), -1)),
                    std::vector<Vec3d>(points.size())};
        query::SkinWorkspace workspace(baked_.lattice, points);
        std::vector<query::SkinContact> contacts(points.size());
        query::ProbeResult r;
        for (int again = 0; again < k_repeats; ++again) {
            const double start = bench::thread_seconds();
            (void)baked_.posed->pose(at.maps);
            const double is_posed = bench::thread_seconds();
            r = query::query_skin({&baked_.model, &*baked_.posed, points, {}}, {.layer = options_.layer}, workspace, contacts);
            pose_seconds_ += is_posed - start;
            query_seconds_ += bench::thread_seconds() - is_posed;
            ++frames_;
        }
        crowded_ += (r.status & query::k_crowded) != 0 ? 1 : 0;
        queried_ += points.size();
        for (std::size_t c = 0; c < r.contacts; ++c) {
            out.depth[0][contacts[c].index] = contacts[c].depth;
            out.normal[contacts[c].index] = contacts[c].normal;
        }
        if (solids_) solids_->query_depths(at.maps, points, options_.layer, out.depth[1]);
        return out;
    }

    /// Compares all methods at a point near the surface with the exact skinned mesh.
    void judge(PosedMesh& at, Vec3d point, const Answers& answers, std::size_t i)
    {
        const mesh::ClosestPoint closest = at.truth.bvh().closest_point(point, 0.03 * baked_.r_max);
        if (!(closest.distance < 0.03 * baked_.r_max)) return;
        ++at.near;
        const bool inside = at.truth.inside(point);
        const mesh::ClosestPoint boundary = at.truth.closest_boundary(point);
        for (std::size_t m = 0; m < tallies_.size(); ++m) {
            Tally& tally = tallies_[m];
            const double depth = answers.depth[m][i];
            if (inside && depth >= 0) {
                tally.depth_error.push_back(100 * std::abs(depth - boundary.distance) / baked_.r_max);
                if (tally.depth_error.back() > 0.5) write(at, tally.name, "depth", point, tally.depth_error.back());
                if (m == 0 && boundary.distance > 1e-4 * baked_.r_max) {
                    const Vec3d n = normalized(boundary.point - point);
                    tally.normal_error.push_back(180 / M_PI * std::acos(std::clamp(dot(n, answers.normal[i]), -1.0, 1.0)));
                }
            }
            if (inside == (depth >= 0) || closest.distance <= 0.005 * baked_.r_max) continue;
            ++at.wrong[m];
            (inside ? tally.false_out : tally.false_in) += 1;
            tally.worst = std::max(tally.worst, closest.distance);
            // The joint that moves the nearest triangle most.
            const std::uint32_t v = at.mesh.triangles[closest.triangle][0];
            const auto& weights = baked_.bound.influences.weights[v];
            const auto k = static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
            ++tally.where[skin_.skeleton[baked_.bound.influences.joints[v][k]].name];
            write(at, tally.name, "verdict", point, 100 * closest.distance / baked_.r_max);
        }
    }

    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };

    const io::SkinnedSoup& skin_;
    Options options_;
    bench::BakedSkin baked_;
    std::vector<Vec3d> object_;
    Vec3d lo_, hi_;
    std::optional<Solids> solids_;
    std::vector<Tally> tallies_;
    std::unique_ptr<std::FILE, Close> worst_;
    SplitMix64 random_{7};
    double pose_seconds_ = 0, query_seconds_ = 0;
    std::size_t frames_ = 0, queried_ = 0, crowded_ = 0;
};

}  // namespace

int sqmap::bench::measure_skin(int argc, char** argv)
{
    if (argc < 3 || argc % 2 == 0) return k_wrong_usage;
    const std::optional<io::SkinnedSoup> skin = bench::read_skin(argv[1]);
    if (!skin) return 2;
    io::ReadResult object = io::read_mesh_file(argv[2]);
    if (object.error) return 2;
    SkinRace race(*skin, std::move(object.soup.positions), parsed(argc, argv));
    for (const auto& [pose_name, pointing] : {std::pair{"fist", false}, {"point", true}})
        for (int step = 0; step <= 4; ++step) race.run(pose_name, 0.25 * step, pointing);  // from open to closed
    race.report();
    return 0;
}
