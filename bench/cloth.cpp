// Fig. 11b: cloth against an avatar. Garments settle and walk once; then every method answers the very same frames in one run:
// sqmap's layers and the paper's maps on points that are moved and refitted, FCL's OBB tree with its tree of the cloth refitted,
// dense distance fields.
#include "sqmap/sim/cloth.h"
#include "clock.h"
#include "distance_grid.h"
#include "fcl_tree.h"
#include "io/replace_file.h"
#include "math/percentile.h"
#include "measure.h"
#include "sim/walker.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/model_file.h"
#include "sqmap/query/pair.h"

#include <fcl/narrowphase/collision.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace sqmap;

constexpr double k_dt = 1.0 / 240;
constexpr double k_target_error = 0.2;    ///< of the models, percent of R_max
constexpr std::uint32_t k_samples = 128;  ///< of a dense field along each axis; 64 for each of many bones

struct Part {
    mesh::Mesh mesh;
    std::vector<std::byte> bytes;
    model::ModelView model;
    std::vector<std::byte> paper_bytes;
    paper::AnyModel paper;  ///< the paper's maps of the same mesh: 65 x 128 samples, A_S of 1
    bench::DistanceGrid grid;
    std::shared_ptr<fcl::BVHModel<fcl::OBB<double>>> tree;
};

/// The frame that all methods answer.
struct Frame {
    std::vector<Vec3d> nodes;
    std::vector<Pose> poses;
};

struct Case {
    std::string name;
    std::vector<Frame> frames;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<double> cloth_us;  ///< of sim::Cloth itself: points and query
    std::vector<double> move_us;   ///< of it, where points are asked about
    double height = 0;
    sim::Penetration deep;
    double fastest = 0;
    std::uint64_t hash = 0;  ///< of where the nodes are at the end: the same wherever only the speed changed
};

void fill(Part& part, std::uint32_t samples, bool own)
{
    bake::BakeOptions options;
    options.target_error = k_target_error;
    part.bytes = bake_mesh(part.mesh, {.bake = options}).bytes();
    if (model::parse(part.bytes, part.model) != model::ParseStatus::Ok) std::abort();
    if (own) return;
    options.exact = false;
    part.paper_bytes = bake_mesh(part.mesh, {.bake = options, .paper_maps = paper::MapOptions{.grid = {65, 128}}}).bytes();
    if (part.paper.parse(part.paper_bytes) != model::ParseStatus::Ok) std::abort();
    part.tree = bench::fcl_tree<fcl::OBB<double>>(part.mesh.vertices, part.mesh.triangles);
    const mesh::Solid solid(part.mesh);
    bench::DistanceGrid& g = part.grid;
    g.samples = samples;
    Vec3d lo = part.mesh.vertices.front(), hi = lo;
    for (const Vec3d& v : part.mesh.vertices)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], v[k]);
            hi[k] = std::max(hi[k], v[k]);
        }
    g.spacing = (hi - lo) / static_cast<double>(samples - 4);
    g.lo = lo - 1.5 * g.spacing;
    g.values.resize(std::size_t{samples} * samples * samples);
    for (std::uint32_t k = 0; k < samples; ++k)
        for (std::uint32_t j = 0; j < samples; ++j)
            for (std::uint32_t i = 0; i < samples; ++i)
                g.values[g.index(i, j, k)] = static_cast<float>(
                    bench::signed_distance(solid, g.lo + Vec3d{i * g.spacing.x, j * g.spacing.y, k * g.spacing.z}));
}

/// Depth and normal by trilinear interpolation, for every node. Returns the contacts.
std::size_t query_field(const bench::DistanceGrid& g, const Pose& pose, std::span<const Vec3d> nodes,
                        std::vector<query::Contact>& out)
{
    Mat3f to_cells;
    Vec3f origin;
    for (int i = 0; i < 3; ++i) {
        to_cells.row[i] = cast<float>(pose.rotation.row[i] / g.spacing[i]);
        origin[i] = static_cast<float>((pose.translation[i] - g.lo[i]) / g.spacing[i]);
    }
    const std::size_t dy = g.samples, dz = dy * dy;
    const auto last = static_cast<float>(g.samples - 1);
    std::size_t count = 0;
    for (std::uint32_t n = 0; n < nodes.size(); ++n) {
        const Vec3f p = to_cells * cast<float>(nodes[n]) + origin;
        if (!(p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < last && p.y < last && p.z < last)) continue;
        const auto cx = static_cast<std::uint32_t>(p.x), cy = static_cast<std::uint32_t>(p.y),
                   cz = static_cast<std::uint32_t>(p.z);
        const float fx = p.x - static_cast<float>(cx), fy = p.y - static_cast<float>(cy), fz = p.z - static_cast<float>(cz);
        const float* v = &g.values[g.index(cx, cy, cz)];
        const auto row = [fx](const float* r) { return r[0] + fx * (r[1] - r[0]); };
        const float a = row(v), b = row(v + dy), c = row(v + dz), d = row(v + dz + dy);
        const float near = a + fy * (b - a), far = c + fy * (d - c), distance = near + fz * (far - near);
        if (!(distance < 0)) continue;
        const auto slope = [&](const float* r) { return r[1] - r[0]; };
        const float sx =
            (1 - fz) * ((1 - fy) * slope(v) + fy * slope(v + dy)) + fz * ((1 - fy) * slope(v + dz) + fy * slope(v + dz + dy));
        const Vec3f gradient{sx / static_cast<float>(g.spacing.x),
                             ((1 - fz) * (b - a) + fz * (d - c)) / static_cast<float>(g.spacing.y),
                             (far - near) / static_cast<float>(g.spacing.z)};
        query::Contact& contact = out[count++];
        contact.index = n;
        contact.depth = -distance;
        contact.normal = normalized(gradient);
    }
    return count;
}

double median(std::vector<double> v) { return v.empty() ? NAN : percentile(v, 50); }

template <class Run>
nlohmann::json timed(const bench::FrameClock& clock, const Case& c, Run&& run)
{
    std::vector<double> us;
    double found = 0;
    for (const Frame& f : c.frames) found += static_cast<double>(run(f));  // warm
    for (const Frame& f : c.frames) {
        const auto mark = bench::FrameClock::start();
        (void)run(f);
        us.push_back(clock.stop_us(mark));
    }
    std::vector<double> sorted = us;
    std::sort(sorted.begin(), sorted.end());
    return {{"us_median", median(us)},
            {"us_p99", sorted[sorted.size() * 99 / 100]},
            {"found", found / static_cast<double>(c.frames.size())}};
}

/// A reader answers from the central model on a layer, or from the paper's maps.
struct Reader {
    const char* name;
    query::Layer layer;
    bool paper = false;

    [[nodiscard]] const model::ModelView& view(const Part& part) const { return paper ? part.paper.view() : part.model; }
};
constexpr Reader k_exact{"sqmap, exact layer", query::Layer::Exact};
constexpr Reader k_readers[] = {{"sqmap, layer 1", query::Layer::One},
                                {"sqmap, layer 2", query::Layer::Two},
                                {"sqmap, layer 3", query::Layer::Three},
                                k_exact,
                                {"paper's maps, layer 1", query::Layer::One, true},
                                {"paper's maps, layer 2", query::Layer::Two, true},
                                {"paper's maps, layer 3", query::Layer::Three, true}};

/// A layer's answers beside those of the exact layer: verdicts in percent of its contacts, depths in millimetres.
struct LayerErrors {
    double missed_percent = 0, false_percent = 0, depth_mm = 0;
};

LayerErrors errors_of(const Case& c, const std::vector<Part>& parts, const Reader& reader)
{
    query::Probe probe(c.frames.front().nodes);
    const std::size_t nodes = c.frames.front().nodes.size();
    std::vector<query::Contact> found(nodes);
    std::vector<float> exact(nodes), own(nodes);
    const auto depths = [&](const Frame& f, std::size_t part, const Reader& of, std::vector<float>& out) {
        std::fill(out.begin(), out.end(), -1.f);
        const query::ProbeResult r =
            query::query_probe({.model = &of.view(parts[part])}, {.probe = &probe, .pose = sqmap::inverse(f.poses[part])},
                               {.layer = of.layer}, found);
        for (const query::Contact& contact : r.written(found)) out[contact.index] = contact.depth;
    };
    std::size_t contacts = 0, missed = 0, wrong = 0, both = 0;
    double sum = 0;
    for (const Frame& f : c.frames) {
        probe.move(f.nodes);
        for (std::size_t p = 0; p < parts.size(); ++p) {
            depths(f, p, k_exact, exact);
            depths(f, p, reader, own);
            for (std::size_t i = 0; i < nodes; ++i) {
                contacts += exact[i] >= 0 ? 1u : 0u;
                missed += exact[i] >= 0 && own[i] < 0 ? 1u : 0u;
                wrong += exact[i] < 0 && own[i] >= 0 ? 1u : 0u;
                if (exact[i] < 0 || own[i] < 0) continue;
                ++both;
                sum += 1000 * static_cast<double>(std::abs(own[i] - exact[i]));
            }
        }
    }
    const auto all = static_cast<double>(std::max<std::size_t>(contacts, 1));
    return {100 * static_cast<double>(missed) / all, 100 * static_cast<double>(wrong) / all,
            sum / static_cast<double>(std::max<std::size_t>(both, 1))};
}

nlohmann::json compare(const bench::FrameClock& clock, const Case& c, std::vector<Part>& parts)
{
    nlohmann::json rows = nlohmann::json::object();
    query::Probe probe(c.frames.front().nodes);
    std::vector<query::Contact> found(c.frames.front().nodes.size());
    rows["sqmap, points moved and refitted"] = timed(clock, c, [&](const Frame& f) {
        probe.move(f.nodes);
        return std::size_t{0};
    });
    for (const Reader& reader : k_readers) {
        const char* name = reader.name;
        query::QueryOptions options;
        options.layer = reader.layer;
        rows[name] = timed(clock, c, [&](const Frame& f) {
            probe.move(f.nodes);
            std::size_t contacts = 0;
            for (std::size_t p = 0; p < parts.size(); ++p) {
                sqmap::Sphere sphere = query::sphere_of({&reader.view(parts[p]), nullptr, f.poses[p]});
                if (!probe.reaches(sphere)) continue;
                contacts += query::query_probe({.model = &reader.view(parts[p])},
                                               {.probe = &probe, .pose = sqmap::inverse(f.poses[p])}, options, found)
                                .contacts;
            }
            return contacts;
        });
        const LayerErrors errors = errors_of(c, parts, reader);
        rows[name]["missed_percent"] = errors.missed_percent;
        rows[name]["false_percent"] = errors.false_percent;
        rows[name]["depth_error_mm"] = errors.depth_mm;
    }
    rows["dense field"] = timed(clock, c, [&](const Frame& f) {
        std::size_t contacts = 0;
        for (std::size_t p = 0; p < parts.size(); ++p)
            contacts += query_field(parts[p].grid, sqmap::inverse(f.poses[p]), f.nodes, found);
        return contacts;
    });
    const auto cloth = bench::fcl_tree<fcl::OBB<double>>(c.frames.front().nodes, c.triangles);
    std::vector<fcl::Vector3d> points(c.frames.front().nodes.size());
    const auto refit = [&](const Frame& f) {
        for (std::size_t i = 0; i < points.size(); ++i) points[i] = {f.nodes[i].x, f.nodes[i].y, f.nodes[i].z};
        cloth->beginReplaceModel();
        cloth->replaceSubModel(points);
        cloth->endReplaceModel(/*refit=*/true, /*bottomup=*/true);
    };
    rows["OBB tree, refit alone"] = timed(clock, c, [&](const Frame& f) {
        refit(f);
        return std::size_t{0};
    });
    for (const bool all : {true, false}) {
        const fcl::CollisionRequestd request(all ? std::numeric_limits<int>::max() : 1, false);
        rows[all ? "OBB tree with refit, all pairs" : "OBB tree with refit, first pair"] = timed(clock, c, [&](const Frame& f) {
            refit(f);
            std::size_t pairs = 0;
            for (std::size_t p = 0; p < parts.size(); ++p) {
                fcl::CollisionResultd result;
                fcl::collide(parts[p].tree.get(), bench::fcl_transform(f.poses[p]), cloth.get(), fcl::Transform3d::Identity(),
                             request, result);
                pairs += result.numContacts();
            }
            return pairs;
        });
    }
    return rows;
}

/// Steps a cloth; keeps frames from the time `from`, every `every` steps.
Case played(std::string name, sim::Cloth& cloth, std::vector<Part>& parts,
            const std::function<void(double, std::span<Pose>)>& pose, double& time, double until, double from, int every)
{
    Case c{std::move(name), {}, {cloth.triangles().begin(), cloth.triangles().end()}, {}, {}, 0, {}, 0, 0};
    std::vector<Pose> poses(parts.size());
    pose(time, poses);
    std::vector<sim::Collider> solids;
    for (std::size_t p = 0; p < parts.size(); ++p) solids.push_back({&parts[p].model, poses[p], poses[p]});
    for (int step = 0; time < until; ++step) {
        time += k_dt;
        pose(time, poses);
        for (std::size_t p = 0; p < parts.size(); ++p) {
            solids[p].previous = solids[p].pose;
            solids[p].pose = poses[p];
        }
        const sim::StepReport r = cloth.step(k_dt, solids);
        if (time < from) continue;
        c.fastest = r.fastest;
        c.cloth_us.push_back(1e6 * (r.seconds.move + r.seconds.query));
        c.move_us.push_back(1e6 * r.seconds.move);
        // The positions that the cloth queries: where it lies on a body they are in it.
        if (step % every == 0) c.frames.push_back({{cloth.query_points().begin(), cloth.query_points().end()}, poses});
    }
    for (const Vec3d& p : cloth.positions())
        for (int k = 0; k < 3; ++k) c.hash = std::rotl((c.hash ^ std::bit_cast<std::uint64_t>(p[k])) * 0x9e3779b97f4a7c15ull, 29);
    c.deep = sim::penetration(cloth.positions(), cloth.triangles(), solids, {.steps = 4});
    return c;
}

struct Options {
    std::uint32_t vertices = 0;
    bool own = false;                 ///< the cloth alone, without peers
    std::string_view scene;           ///< empty: all
    Vec3d shift{};                    ///< of blankets, m
    std::vector<const char*> models;  ///< that blankets fall on

    [[nodiscard]] bool wants(std::string_view name) const { return scene.empty() || scene == name; }
};

Options parsed(int argc, char** argv)
{
    Options o;
    o.vertices = static_cast<std::uint32_t>(std::atoi(argv[2]));
    for (int a = 3; a < argc; ++a) {
        const std::string_view word = argv[a];
        if (word == "--own")
            o.own = true;
        else if (word == "--scene" && a + 1 < argc)
            o.scene = argv[++a];
        else if (word == "--shift" && a + 2 < argc)
            o.shift = {std::atof(argv[a + 1]), 0, std::atof(argv[a + 2])}, a += 2;
        else
            o.models.push_back(argv[a]);
    }
    return o;
}

/// Prints each case as it ends and keeps all of them.
class Report {
public:
    explicit Report(const Options& options)
        : own_(options.own),
          out_{{"vertices", options.vertices}, {"target_error_percent", k_target_error}, {"cases", nlohmann::json::array()}}
    {
    }

    void add(const Case& c, std::vector<Part>& parts)
    {
        nlohmann::json row{{"name", c.name},
                           {"vertices", c.frames.front().nodes.size()},
                           {"frames", c.frames.size()},
                           {"height_m", c.height},
                           {"methods", own_ ? nlohmann::json::object() : compare(clock_, c, parts)}};
        const double step_us = median(c.cloth_us), move_us = median(c.move_us);
        row["cloth_step_us_median"] = step_us;
        row["cloth_move_us_median"] = move_us;
        row["nodes_percent"] = 100 * c.deep.nodes / c.height;
        row["interiors_percent"] = 100 * c.deep.interiors / c.height;
        row["fastest_m_s"] = c.fastest;
        std::printf(
            "%s: %zu vertices; cloth's own collision %.0f us a step (positions queried %.0f); nodes %.3f %%, interiors %.3f %% "
            "of the height; %.3f m/s at the end; %016llx\n",
            c.name.c_str(), c.frames.front().nodes.size(), step_us, move_us, 100 * c.deep.nodes / c.height,
            100 * c.deep.interiors / c.height, c.fastest, static_cast<unsigned long long>(c.hash));
        for (const auto& [method, m] : row["methods"].items()) {
            std::printf("  %-34s %9.1f us  (p99 %.1f)  finds %.0f", method.c_str(), m["us_median"].get<double>(),
                        m["us_p99"].get<double>(), m["found"].get<double>());
            if (m.contains("depth_error_mm"))
                std::printf("  misses %.3f %%, false %.3f %%, depths %.4f mm off", m["missed_percent"].get<double>(),
                            m["false_percent"].get<double>(), m["depth_error_mm"].get<double>());
            std::printf("\n");
        }
        std::fflush(stdout);
        out_["cases"].push_back(std::move(row));
    }

    void write(const char* path) const
    {
        const std::string text = out_.dump(1) + "\n";
        io::replace_file(path, std::as_bytes(std::span(text)));
    }

private:
    bool own_;
    bench::FrameClock clock_;
    nlohmann::json out_;
};

/// Skirt and shirt on a figure that stands, then walks.
void play_garments(const Options& o, Report& report)
{
    const std::vector<sim::Bone> bones = sim::capsule_human(1.75);
    std::vector<Part> parts(bones.size());
    for (std::size_t b = 0; b < bones.size(); ++b) {
        mesh::CapsuleSolid solid;
        solid.blend = 0.003;
        for (const sim::BoneCapsule& f : bones[b].flesh) solid.capsules.push_back({f.a, f.b, f.radius_a, f.radius_b});
        parts[b].mesh = mesh::polygonized(solid, 0.022);
        fill(parts[b], k_samples / 2, o.own);
    }
    const sim::Gait gait{.lower_at = 4.0, .walk_at = 4.5, .ease = 0.5};
    const auto pose = [&](double time, std::span<Pose> poses) { sim::walk(bones, gait, time, poses); };
    std::vector<Pose> rest(bones.size());
    pose(0, rest);
    sim::ClothOptions options;
    options.sweep_step = 0.02;
    for (const bool is_shirt : {false, true}) {
        const std::string name = is_shirt ? "shirt" : "skirt";
        if (!o.wants(name)) continue;
        const sim::Garment garment = is_shirt ? sim::shirt({.collar = {0, 1.53, 0},
                                                            .chest = 0.52,
                                                            .length = 0.62,
                                                            .span = 1.0,
                                                            .sleeve = 0.24,
                                                            .neck = 0.24,
                                                            .gap = 0.14,
                                                            .vertices = o.vertices})
                                              : sim::skirt({{0, 1.08, 0}, 0.155, 0.5, o.vertices});
        sim::Cloth cloth(garment, sim::fabric("cotton"), options);
        if (!is_shirt) cloth.pin(garment.waist, 0, rest[0]);
        double time = 0;
        for (const bool walks : {false, true}) {
            Case c = played(name + (walks ? " on the figure, walking" : " on the figure, standing"), cloth, parts, pose, time,
                            walks ? 6.0 : 4.0, walks ? 5.0 : 3.75, walks ? 4 : 1);
            c.height = 1.75;
            report.add(c, parts);
        }
    }
}

/// A blanket that falls on a closed mesh. False where the mesh is none.
bool play_blanket(const char* file, const Options& o, Report& report)
{
    const AdmittedMesh admitted = admit_mesh(file);
    if (admitted.refused() || !admitted.solid) {
        std::fprintf(stderr, "%s: no closed mesh\n", file);
        return false;
    }
    std::vector<Part> parts(1);
    parts[0].mesh = admitted.mesh;
    fill(parts[0], k_samples, o.own);
    const Vec3d lo = admitted.facts.box.lo, hi = admitted.facts.box.hi;
    const double height = hi.y - lo.y, side = 0.6 * std::max(hi.x - lo.x, hi.z - lo.z);
    sim::Cloth cloth(sim::sheet({Vec3d{0.5 * (lo.x + hi.x), hi.y + 0.02 * height, 0.5 * (lo.z + hi.z)} + o.shift, side, side, 0,
                                 0, o.vertices}),
                     sim::fabric("wool"), {});
    double time = 0;
    const auto pose = [](double, std::span<Pose> poses) { std::fill(poses.begin(), poses.end(), Pose{}); };
    Case falling = played(std::string("blanket on ") + file + ", falling", cloth, parts, pose, time, 1.0, 0.3, 3);
    falling.height = height;
    report.add(falling, parts);
    Case still = played(std::string("blanket on ") + file + ", at rest", cloth, parts, pose, time, 4.0, 3.75, 1);
    still.height = height;
    report.add(still, parts);
    return true;
}

}  // namespace

int sqmap::bench::measure_cloth(int argc, char** argv)
{
    if (argc < 3) return k_wrong_usage;
    const Options options = parsed(argc, argv);
    Report report(options);
    if (options.wants("skirt") || options.wants("shirt")) play_garments(options, report);
    for (const char* file : options.models)
        if (options.wants("blanket") && !play_blanket(file, options, report)) return 2;
    report.write(argv[1]);
    return 0;
}
