#include "hand.h"

#include "../clock.h"
#include "../frames.h"
#include "../path.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/haptic/safety.h"
#include "sqmap/haptic/step.h"
#include "sqmap/haptic/tool.h"
#include "sqmap/model/parse.h"
#include "sqmap/paper/force.h"
#include "sqmap/paper/model_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace sqmap::bench {

namespace {

constexpr double k_scale = 0.3;  ///< m of the object's diagonal

mesh::Mesh split_in_four(const mesh::Mesh& mesh)
{
    mesh::Mesh out{mesh.vertices, {}};
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
    const auto between = [&](std::uint32_t a, std::uint32_t b) {
        const auto [it, is_new] = middle.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(out.vertices.size()));
        if (is_new) out.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
        return it->second;
    };
    for (const mesh::Triangle& t : mesh.triangles) {
        const std::uint32_t a = between(t[0], t[1]), b = between(t[1], t[2]), c = between(t[2], t[0]);
        for (const mesh::Triangle& s : {mesh::Triangle{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}})
            out.triangles.push_back(s);
    }
    return out;
}

mesh::Mesh divided(mesh::Mesh mesh, int times)
{
    for (int i = 0; i < times; ++i) mesh = split_in_four(mesh);
    return mesh;
}

std::vector<std::byte> baked(const mesh::Mesh& mesh, bool is_paper)
{
    const auto maps = is_paper ? std::optional<paper::MapOptions>(std::in_place) : std::nullopt;
    return bake_mesh(mesh, {.paper_maps = maps}).bytes();
}

/// A bystander: a baked object, 40 cm from the one that the hand moves over and from its neighbours.
struct Bystander {
    Bystander(const Files& files, int number, bool is_paper) : bytes(baked(load_setting(files)->object, is_paper))
    {
        (void)model.parse(bytes);
        view = haptic::in_metres(model.view(), k_scale);
        const double angle = 1.2566 * number;
        pose.translation = {0.4 * std::cos(angle), 0.4 * std::sin(angle), 0};
    }
    std::vector<std::byte> bytes;
    paper::AnyModel model;
    model::ModelView view;
    Pose pose{};
};

/// The object in metres, and the way.
struct Scene {
    explicit Scene(const HandPath& hand) : setting(load_setting(hand.files))
    {
        bytes = baked(setting->object, hand.paper);
        (void)model.parse(bytes);
        view = haptic::in_metres(model.view(), k_scale);
        for (const Pose& p : read_path(hand.path)) poses.push_back({p.rotation, k_scale * p.translation});
        solid.model = &view;
        if (hand.paper) solid.material.friction = Friction::Paper;
        if (!hand.edges) return;
        mesh::Mesh metres = setting->object;
        for (Vec3d& v : metres.vertices) v = k_scale * v;
        surface.emplace(metres.vertices, metres.triangles);
        solid.surface = &*surface;
    }
    std::unique_ptr<Setting> setting;
    std::vector<std::byte> bytes;
    paper::AnyModel model;
    model::ModelView view;
    std::vector<Pose> poses;
    std::optional<query::Probe> surface;  // with edges
    haptic::TouchedBody solid;
};

/// The hand as a tool of one zone.
struct Hand {
    Hand(mesh::Mesh mesh, bool weighted, const HandPath& path, std::size_t max_touched = 1)
    {
        for (Vec3d& v : mesh.vertices) v = k_scale * v;
        haptic::ToolDescription d{.max_touching = static_cast<std::uint32_t>(path.touching)};
        haptic::take_surface(d, mesh.vertices, mesh.triangles, path.spacing, path.touching > 0);
        if (path.edges) d.triangles = mesh.triangles;
        if (path.exact) d.force.layer = query::Layer::Exact;
        if (!weighted) d.weights.clear();
        if (path.paper) {
            d.force = paper::with_paper_force(d.force);
            d.force.blend_time = 0;
        }
        tool = haptic::Tool(std::move(d));
        state.emplace(tool.state(max_touched));
    }
    haptic::Wrench touch(std::span<const haptic::TouchedBody> solids, const Pose& pose, haptic::StepResult& result)
    {
        haptic::Wrench w;
        result = haptic::step(*state, {.touched = solids, .poses = std::span(&pose, 1)}, std::span(&w, 1));
        return w;
    }
    /// The wrench that a device would get: behind the safety filter.
    haptic::Wrench safe_touch(std::span<const haptic::TouchedBody> solids, const Pose& pose, haptic::StepResult& result)
    {
        const haptic::Wrench commanded = touch(solids, pose, result);
        haptic::Wrench safe;
        const double now = 1e-3 * static_cast<double>(++ticks);
        (void)filter.tick({.time = now,
                           .sample_time = now,
                           .sequence = ticks,
                           .poses = std::span(&pose, 1),
                           .commanded = std::span(&commanded, 1)},
                          std::span(&safe, 1));
        return safe;
    }
    haptic::SafetyFilter filter{haptic::DeviceLimits{.max_force = 20, .max_torque = 1}, haptic::SafetyOptions{}};
    std::uint64_t ticks = 0;
    haptic::Tool tool;
    std::optional<haptic::State> state;
};

}  // namespace

TickCost tick_cost(const HandPath& path, int passes)
{
    Scene scene(path);
    Hand hand(divided(scene.setting->probe, path.divide), true, path),
        in_scene(divided(scene.setting->probe, path.divide), true, path, 1 + path.by.size());
    const FrameClock clock;
    std::vector<std::unique_ptr<Bystander>> by;
    std::vector<haptic::TouchedBody> solids{scene.solid};
    for (const std::filesystem::path& file : path.by) {
        by.push_back(std::make_unique<Bystander>(Files{file, path.files.probe}, static_cast<int>(by.size()), path.paper));
        solids.push_back({.model = &by.back()->view, .pose = by.back()->pose});
    }
    haptic::StepResult result;
    std::vector<double> us, query_us, scene_us;
    std::vector<std::uint32_t> contacts;
    const std::span<const haptic::TouchedBody> alone(solids.data(), 1);
    const haptic::ZoneOptions& force = hand.tool.zones().front().options;
    std::vector<query::Contact> found(hand.tool.probe().size());
    TickCost out;
    for (int pass = -1; pass < passes; ++pass) {  // the first one warms up
        hand.state->reset();
        in_scene.state->reset();
        // In turns, so that all see the same load: the query that a step makes, a step in the scene, a step.
        for (const Pose& pose : scene.poses) {
            const FrameClock::Mark mark = FrameClock::start();
            (void)query::query_probe({.model = &scene.view}, {.probe = &hand.tool.probe(), .pose = pose},
                                     {.layer = force.layer, .smoothed_map = force.smoothed_map}, found);
            const double t = clock.stop_us(mark);
            if (pass >= 0) query_us.push_back(t);
        }
        for (const Pose& pose : scene.poses) {
            const FrameClock::Mark mark = FrameClock::start();
            (void)in_scene.safe_touch(solids, pose, result);
            const double t = clock.stop_us(mark);
            if (pass >= 0) scene_us.push_back(t);
        }
        for (const Pose& pose : scene.poses) {
            const FrameClock::Mark mark = FrameClock::start();
            (void)hand.safe_touch(alone, pose, result);
            const double t = clock.stop_us(mark);
            if (pass < 0) continue;
            us.push_back(t);
            contacts.push_back(result.contacts);
            out.contacts += result.contacts;
        }
    }
    const std::size_t poses = scene.poses.size();
    for (std::size_t i = 0; i < poses; ++i) {
        std::vector<double> whole, query;
        for (std::size_t k = i; k < us.size(); k += poses) {
            whole.push_back(us[k]);
            query.push_back(query_us[k]);
        }
        out.series.push_back({percentile(query, 0.5), percentile(whole, 0.5), contacts[i]});
    }
    out.ticks = static_cast<std::uint32_t>(us.size());
    out.contacts /= static_cast<double>(us.size());
    out.scene_p50 = percentile(scene_us, 0.5);
    out.scene_p999 = percentile(scene_us, 0.999);
    out.query_p50 = percentile(query_us, 0.5);
    out.query_p999 = percentile(query_us, 0.999);
    out.p50 = percentile(us, 0.5);
    out.p99 = percentile(us, 0.99);
    out.p999 = percentile(us, 0.999);
    return out;
}

DensityChange density_change(const HandPath& path, bool weighted)
{
    Scene scene(path);
    scene.solid.material.friction = Friction::None;
    Hand coarse(divided(scene.setting->probe, path.divide), weighted, path),
        dense(divided(scene.setting->probe, path.divide + 1), weighted, path);
    for (Hand* hand : {&coarse, &dense}) hand->state->options(0).blend_time = 0;
    const std::span<const haptic::TouchedBody> solid(&scene.solid, 1);
    std::vector<double> force, share, torque;
    DensityChange out;
    for (const Pose& pose : scene.poses) {
        haptic::StepResult a, b;
        const haptic::Wrench c = coarse.touch(solid, pose, a), d = dense.touch(solid, pose, b);
        if (a.contacts == 0) continue;
        out.contacts += a.contacts;
        out.dense_contacts += b.contacts;
        force.push_back(100 * norm(d.force - c.force) / norm(c.force));
        const double pressed = coarse.state->options(0).stiffness * coarse.state->report(0).depth;
        share.push_back(100 * norm(d.force - c.force) / pressed);
        torque.push_back(100 * norm(d.torque - c.torque) / norm(c.torque));
    }
    if (force.empty()) return out;
    out.touching = static_cast<std::uint32_t>(force.size());
    out.contacts /= static_cast<double>(force.size());
    out.dense_contacts /= static_cast<double>(force.size());
    out.force_median = percentile(force, 0.5);
    out.force_p95 = percentile(force, 0.95);
    out.force_max = *std::max_element(force.begin(), force.end());
    for (const double f : force) out.within_5 += f < 5 ? 100. / static_cast<double>(force.size()) : 0;
    out.share_median = percentile(share, 0.5);
    out.share_p95 = percentile(share, 0.95);
    out.share_max = *std::max_element(share.begin(), share.end());
    out.torque_median = percentile(torque, 0.5);
    out.torque_p95 = percentile(torque, 0.95);
    return out;
}

}  // namespace sqmap::bench
