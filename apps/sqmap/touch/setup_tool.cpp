// The tool of a touch: a sphere, a point, a mesh, or a hand on a glove.
#include "common/hash_text.h"
#include "common/program_words.h"
#include "common/tool_name.h"
#include "sqmap/bake/rebake.h"
#include "sqmap/model/model.h"
#include "sqmap/paper/force.h"
#include "sqmap/paper/model.h"
#include "touch/hand_file.h"
#include "touch/setup.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>

namespace sqmap::app {
namespace {

// A contact on the paper's maps takes about 2 microseconds: what a tick of 1 ms has time for.
constexpr double k_touching_on_paper_maps = 300;
constexpr double k_least_radius = 1e-6;

/// FNV-1a over the bits of points: tells one tool from another.
std::uint64_t hash_of(std::span<const Vec3d> points)
{
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const Vec3d& p : points)
        for (int i = 0; i < 3; ++i) hash = (hash ^ std::bit_cast<std::uint64_t>(p[i])) * 0x100000001b3u;
    return hash | 1u;  // never the 0 that stands for any
}

/// True for NAME or NAME:RADIUS, m. @throw BadTouch for a radius that is no number, or below the least or beyond max
bool is_shape(const std::string& tool, const std::string& name, double max, double& radius)
{
    const std::optional<double> named = tool_radius(tool, name, radius);
    if (!named) return false;
    if (tool == name) return true;
    radius = *named;
    if (!(radius >= k_least_radius && radius <= max)) {
        char limits[80];
        std::snprintf(limits, sizeof limits, "%g to %.4g m, the first object's R_max", k_least_radius, max);
        throw BadTouch("--tool " + tool + ": the radius must be a number from " + limits + "\n  cure: metres, as in " + name +
                       ":0.005");
    }
    return true;
}

}  // namespace

/// A glove's six zones and a hand with joints: one probe, moved as the hand is posed.
void TouchSetup::load_hand(device::HandMesh mesh, haptic::ToolDescription& tool)
{
    hand_ = std::make_unique<device::HandSkin>(mesh, options_.hand_length);
    tool.weights.assign(hand_->weights().begin(), hand_->weights().end());
    for (std::size_t z = 0; z <= zones_; ++z) tool.first.push_back(hand_->first(z));
    reach_ = hand_->reach(zones_ - 1);  // the palm: fingertips carry force alone
    tool.points.assign(hand_->points().begin(), hand_->points().end());
    for (Vec3d& p : tool.points) p.y -= 0.45 * options_.hand_length;
}

void TouchSetup::load_tool(const std::filesystem::path& beside)
{
    haptic::ToolDescription tool{.radius = options_.zone_radius, .zones = zones_};
    std::vector<Vec3d> flat;  // of a hand: the file's points
    if (!options_.touching_wished && std::any_of(views_.begin(), views_.end(), paper::is_paper))
        options_.tool_touching = std::min(options_.tool_touching, k_touching_on_paper_maps);
    tool.ball_radius = k_tool_radius;
    if (options_.tolerance >= 0) tool.tolerance = options_.tolerance;
    haptic::Smoothing& smoothing = options_.zone.smoothing;
    smoothing.kernel = options_.kernel;
    const double max = views_.front().header.r_max * views_.front().header.unit;
    if (options_.paper_force) {
        const double blend_time = options_.zone.blend_time;  // --blend
        options_.zone = paper::with_paper_force(options_.zone);
        options_.zone.blend_time = blend_time;
    }
    if (is_shape(options_.tool, "sphere", max, tool.ball_radius)) {
        tool.force = options_.zone;
        paper::take_ball(tool, tool.ball_radius);
        if (options_.paper_force) reach_ = tool.ball_radius;
    } else if (is_shape(options_.tool, "point", max, smoothing.radius)) {
        tool.shape = haptic::ToolShape::Point;
        if (!options_.paper_force) point_ = std::make_unique<query::Probe>(std::vector<Vec3d>{{}});
    } else if (std::optional<device::HandMesh> hand;
               zones_ == device::k_glove_zones && (hand = read_hand(found(options_.tool, beside)))) {
        flat = hand->points;
        load_hand(std::move(*hand), tool);
    } else {
        if (zones_ > 1)
            notes_.push_back("warning: each of the " + std::to_string(zones_) + " zones carries the whole of " + options_.tool +
                             (zones_ == device::k_glove_zones ? "; a glove poses a glTF hand with WebXR's 25 joints" : ""));
        load_mesh_tool(beside, tool);
    }
    const bool patch = options_.paper_force || tool.shape == haptic::ToolShape::Surface;
    const bool doubtful =
        std::any_of(views_.begin(), views_.end(), [](const model::ModelView& v) { return model::is_doubtful(v.measured); });
    const auto bare = std::find_if_not(views_.begin(), views_.end(), model::has_exact);
    if (options_.zone.layer == query::Layer::Exact && bare != views_.end())
        throw BadTouch(options_.objects[static_cast<std::size_t>(bare - views_.begin())].file +
                       " was baked without the exact layer: bake it with --exact, or touch it with --layer 3");
    if (options_.zone.layer == query::Layer::Auto) {
        const bool by_maps = options_.paper_force || (patch && !doubtful) || bare != views_.end();
        options_.zone.layer = by_maps ? query::Layer::Three : query::Layer::Exact;
    }
    if (options_.paper_force && doubtful && options_.zone.layer != query::Layer::Exact)
        notes_.push_back(
            "warning: the maps give wrong depths in places (W_LAYER3), and the paper's force is theirs; --layer exact takes the "
            "triangles'");
    tool.max_touching = static_cast<std::uint32_t>(options_.tool_touching);
    tool.force = options_.zone;
    tool_ = haptic::Tool(std::move(tool));
    options_.zone = tool_.zones().front().options;
    const std::uint64_t hash = hash_of(hand_ ? flat : tool_.points());
    if (options_.tool_hash != 0 && options_.tool_hash != hash)
        throw BadTouch(options_.tool + " is not the tool that was recorded: its hash is " + hash_text(hash) + ", the trace has " +
                       hash_text(options_.tool_hash));
    options_.tool_hash = hash;
    if (!(options_.zone_radius > 0)) return;
    if (!patch) {
        notes_.push_back("warning: --zone counts for a mesh only: " + options_.tool + " is felt as a whole");
    } else if (!hand_) {
        double nearest = INFINITY;
        std::size_t count = 0;
        for (const Vec3d& p : tool_.points()) {
            nearest = std::min(nearest, norm(p));
            count += norm(p) < options_.zone_radius;
        }
        char text[300];
        if (count == 0) {
            std::snprintf(
                text, sizeof text,
                "--zone %g: no point of %s is so near to its centre (the nearest: %.3g m), nothing would be felt\n  cure: a "
                "larger zone, or 0 for the whole tool",
                options_.zone_radius, options_.tool.c_str(), nearest);
            throw BadTouch(text);
        }
        std::snprintf(text, sizeof text, "--zone %g: %zu of the tool's %zu points count, the nearest %.3g m from its centre",
                      options_.zone_radius, count, tool_.points().size(), nearest);
        notes_.push_back(text);
    }
}

void TouchSetup::load_mesh_tool(const std::filesystem::path& beside, haptic::ToolDescription& tool)
{
    AdmittedMesh loaded = admit_mesh(found(options_.tool, beside), {.admit = {.accept_surface = true}});
    if (loaded.refused()) throw BadTouch(options_.tool + ": " + report(loaded));
    // Turned about the centre of its surface, and as large as asked.
    mesh::Mesh& mesh = loaded.mesh;
    const Vec3d centre = mesh::normalization_of(mesh).origin;
    const double scale = options_.tool_size / mesh::largest_vertex_distance(mesh);
    for (Vec3d& v : mesh.vertices) v = scale * (v - centre);
    haptic::take_surface(tool, mesh.vertices, mesh.triangles, options_.tool_spacing,
                         options_.tool_touching > 0 && !(options_.tool_spacing > 0));
    if (options_.edges) add_edges(mesh, tool);
    for (const Vec3d& v : tool.points) reach_ = std::max(reach_, norm(v));
}

/// The triangles of the tool and of all objects.
void TouchSetup::add_edges(const mesh::Mesh& mesh, haptic::ToolDescription& tool)
{
    const auto refuse_open = [](const std::string& file) {
        throw BadTouch("--edges: " + file +
                       " has no closed surface of triangles\n  cure: sqmap bake closes a mesh; or without --edges");
    };
    if (query::find_fault(mesh.vertices, mesh.triangles).kind != query::TriangleFault::Kind::None) refuse_open(options_.tool);
    tool.triangles = mesh.triangles;
    surfaces_.reserve(views_.size());
    for (std::size_t i = 0; i < views_.size(); ++i) {
        mesh::Mesh object = bake::baked_mesh(views_[i]);
        const model::Header& h = views_[i].header;
        for (Vec3d& v : object.vertices) v = h.unit * v + Vec3d{h.origin[0], h.origin[1], h.origin[2]};
        if (object.triangles.empty() ||
            query::find_fault(object.vertices, object.triangles).kind != query::TriangleFault::Kind::None)
            refuse_open(options_.objects[i].file);
        solids_[i].surface = &surfaces_.emplace_back(object.vertices, object.triangles);
    }
}

}  // namespace sqmap::app
