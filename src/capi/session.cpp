// Forces behind the C interface: one zone, one touched model, and the safety filter, which no caller goes around.
#include "objects.h"
#include "query/probe/triangle_tree.h"
#include "sqmap/device/simulated.h"
#include "sqmap/haptic/safety.h"
#include "sqmap/haptic/step.h"
#include "sqmap/haptic/stiffness.h"
#include "sqmap/haptic/tool.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/force.h"
#include "structs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::capi {
namespace {

constexpr double k_period = 1e-3;

/// A number of the caller's, or the default for zero.
double or_default(double value, double standard, double max, const char* element)
{
    return value == 0 ? standard : checked(value, 0, max, element);
}

haptic::Mode mode_of(int mode)
{
    switch (mode) {
        case SQMAP_MODE_DEFAULT:
        case SQMAP_MODE_DIRECT:
            return haptic::Mode::Direct;
        case SQMAP_MODE_PROXY:
            return haptic::Mode::Proxy;
        case SQMAP_MODE_COUPLED:
            return haptic::Mode::Coupled;
        default:
            throw Failure{SQMAP_E_ARGUMENT, "options.mode", "is " + std::to_string(mode), "take one of sqmap_mode"};
    }
}

haptic::DeviceLimits device_of(const sqmap_session_options& o)
{
    constexpr double k_largest = std::numeric_limits<double>::max();  // the filter says which ones it holds
    haptic::DeviceLimits device;
    device.max_force = checked(o.max_force, 0, k_largest, "options.max_force");
    device.max_torque = checked(o.max_torque, 0, k_largest, "options.max_torque");
    device.continuous_force = checked(o.continuous_force, 0, k_largest, "options.continuous_force");
    return device;
}

bool has_paper_force(const sqmap_session_options& o, const Model& model)
{
    if (o.force == SQMAP_FORCE_FULL) return false;
    if (o.force != SQMAP_FORCE_PAPER)
        throw Failure{SQMAP_E_ARGUMENT, "options.force", "is " + std::to_string(o.force), "take one of sqmap_force_law"};
    if (!model.is_paper())
        throw Failure{SQMAP_E_ARGUMENT, "options.force", "is the paper's, of a model with the central projection",
                      "bake a paper model (projection 1), or take the full force"};
    if (o.mode != SQMAP_MODE_DEFAULT && o.mode != SQMAP_MODE_DIRECT)
        throw Failure{SQMAP_E_ARGUMENT, "options.mode", "is " + std::to_string(o.mode) + " with the paper's force",
                      "take the direct mode"};
    return true;
}

/// The layer that answers, k_L and the offset.
query::QueryOptions query_of(const sqmap_session_options& o)
{
    query::QueryOptions out;
    out.layer = layer_of(o.layer);
    if (out.layer == query::Layer::One) out.layer = query::Layer::Two;  // a superquadric pushes from outside the surface
    if (o.gate != 0) out.gate = o.gate;
    out.offset = o.has_offset != 0;
    return out;
}

/// The surface of a probe as the tool.
void take_surface(haptic::ToolDescription& tool, const sqmap_session_options& o)
{
    if (o.radius != 0)
        throw Failure{SQMAP_E_ARGUMENT, "options.radius", "is given beside options.tool",
                      "give one of them: a ball or a surface"};
    const std::shared_ptr<query::Probe> probe = probes().find(o.tool.id, "options.tool");
    check_triangles(*probe, "options.tool");
    const query::TriangleTree& tree = probe->triangles();
    std::vector<Vec3d> points(tree.points());
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = tree.point(i);
    std::vector<query::ProbeTriangle> triangles(tree.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) triangles[t] = tree.triangle(t);
    haptic::take_surface(tool, points, triangles, 0, true);
    if (o.without_edges == 0) tool.triangles = std::move(triangles);
}

/// The impact sphere of a tool of points.
void take_zone(haptic::ToolDescription& tool, double radius)
{
    tool.radius = checked(radius, 0, 1e6, "options.zone");
    if (radius == 0) return;
    if (tool.shape != haptic::ToolShape::Surface)
        throw Failure{SQMAP_E_ARGUMENT, "options.zone", "counts for the surface of a tool, or a ball with the paper's force",
                      "set it to 0, or give options.tool"};
    if (std::none_of(tool.points.begin(), tool.points.end(), [&](Vec3d p) { return norm(p) < radius; }))
        throw Failure{SQMAP_E_ARGUMENT, "options.zone",
                      "is " + std::to_string(radius) + ", and no point of the tool is so near its centre",
                      "give more, or 0 for the whole tool"};
}

/// The touched surface for the edges of a tool, in metres; null for a tool that has none.
std::unique_ptr<query::Probe> edges_of(const Model& model, const sqmap_session_options& o, double metres_per_unit)
{
    if (o.tool.id == 0 || o.without_edges != 0) return nullptr;
    const mesh::Mesh& mesh = model.surface().mesh;
    std::vector<Vec3d> points = mesh.vertices;
    for (Vec3d& p : points) p = metres_per_unit * p;
    if (query::find_fault(points, mesh.triangles).kind != query::TriangleFault::Kind::None)
        throw Failure{SQMAP_E_MESH, "model", "has no closed surface, which a tool's edges need",
                      "bake a closed mesh, or touch it with the tool's points alone"};
    return std::make_unique<query::Probe>(points, mesh.triangles);
}

haptic::Tool tool_of(const sqmap_session_options& o, bool is_paper_force)
{
    haptic::ZoneOptions z;
    z.mode = mode_of(o.mode);
    const query::QueryOptions query = query_of(o);
    z.layer = query.layer;
    z.gate = query.gate;
    z.offset = query.offset;
    z.side_path = checked(o.side_path, 0, 1, "options.side_path");
    const double radius = checked(o.radius, 0, 1, "options.radius");
    z.stiffness = or_default(o.stiffness, z.stiffness, 1e5, "options.stiffness");
    z.damping = checked(o.damping, 0, 1e4, "options.damping");
    if (z.mode == haptic::Mode::Coupled) haptic::choose_coupling(z, device_of(o));
    haptic::ToolDescription tool{.force = is_paper_force ? paper::with_paper_force(z) : z};
    if (o.tool.id != 0)
        take_surface(tool, o);
    else
        paper::take_ball(tool, radius);
    take_zone(tool, o.zone);
    return haptic::Tool(std::move(tool));
}

/// A number that is 0 for its default and below it for none.
double or_none(double value, double standard, double max, const char* element)
{
    return value < 0 && std::isfinite(value) ? 0 : or_default(value, standard, max, element);
}

haptic::Material material_of(const sqmap_session_options& o)
{
    haptic::Material material;
    material.f_c = or_none(o.f_c, material.f_c, 1e3, "options.f_c");
    material.k_f = or_none(o.k_f, material.k_f, 1e6, "options.k_f");
    switch (o.friction_law) {
        case SQMAP_FRICTION_DEFAULT:
            if (o.force == SQMAP_FORCE_PAPER) material = paper::with_paper_friction(material);
            break;
        case SQMAP_FRICTION_COULOMB:
            break;
        case SQMAP_FRICTION_PAPER:
            material = paper::with_paper_friction(material);
            break;
        case SQMAP_FRICTION_NONE:
            material.friction = Friction::None;
            break;
        default:
            throw Failure{SQMAP_E_ARGUMENT, "options.friction_law", "is " + std::to_string(o.friction_law),
                          "take one of sqmap_friction_law"};
    }
    if (o.friction == 0) return material;
    material.mu_static = o.friction < 0 && std::isfinite(o.friction) ? 0 : checked(o.friction, 0, 10, "options.friction");
    material.mu_dynamic = 0.75 * material.mu_static;
    return material;
}

haptic::SafetyFilter filter_of(const sqmap_session_options& o)
{
    haptic::SafetyOptions options;
    constexpr double k_largest = std::numeric_limits<double>::max();
    if (o.force_limit != 0) options.force_limit = checked(o.force_limit, 0, k_largest, "options.force_limit");
    if (o.torque_limit != 0) options.torque_limit = checked(o.torque_limit, 0, k_largest, "options.torque_limit");
    options.dead_man = o.has_dead_man != 0;
    haptic::SafetyFilter filter(device_of(o), options);
    if (filter.setup_status() != haptic::SetupStatus::Ok)
        throw Failure{SQMAP_E_ARGUMENT, "options", haptic::describe(filter.setup_status()), "give limits that the device holds"};
    return filter;
}

void put(double* target, Vec3d v)
{
    for (int i = 0; i < 3; ++i) target[i] = v[i];
}

void put(sqmap_pose& target, const Pose& pose)
{
    for (int i = 0; i < 3; ++i) put(target.rotation + 3 * i, pose.rotation.row[i]);
    put(target.translation, pose.translation);
}

}  // namespace

/// Not movable: the touched body points to the view.
class Session {
public:
    Session(std::shared_ptr<Model> model, const sqmap_session_options& o)
        : model_(std::move(model)),
          read_(read_paper(model_->opened(), paper_options(o), query_of(o))),
          metres_per_unit_(or_default(o.metres_per_unit, 1, 1e6, "options.metres_per_unit")),
          view_(haptic::in_metres(read_.view, metres_per_unit_)),
          tool_(tool_of(o, has_paper_force(o, *model_))),
          surface_(edges_of(*model_, o, metres_per_unit_)),
          touched_{&view_, pose_of(o.pose, "options.pose"), {}, material_of(o), surface_.get()},
          state_(tool_.state()),
          filter_(filter_of(o))
    {
        held_.reset({});
    }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Total: input that is not finite gives zero and a status bit.
    sqmap_force tick(const sqmap_tick& in) noexcept
    {
        sqmap_force out{};
        const double dt = in.time - time_;
        time_ = in.time;
        const Pose pose = pose_or_nan(in.pose);  // the step and the filter say what NaN leads to
        haptic::Wrench commanded, sent;
        const haptic::StepResult step = haptic::step(
            state_, {.touched = {&touched_, 1}, .poses = {&pose, 1}, .dt = dt > 0 && dt < 1 ? dt : k_period}, {&commanded, 1});
        const haptic::ZoneReport& zone = state_.report(0);
        haptic::SafetyInput safety;
        safety.time = in.time;
        safety.sample_time = in.sample_time;
        safety.sequence = in.sequence;
        safety.poses = {&pose, 1};
        safety.commanded = {&commanded, 1};
        safety.pushes = {&zone.push, 1};
        safety.connected = (in.acts & SQMAP_TICK_DISCONNECTED) == 0;
        safety.held = (in.acts & SQMAP_TICK_HELD) != 0;
        safety.stop = (in.acts & SQMAP_TICK_STOP) != 0;
        safety.resume = (in.acts & SQMAP_TICK_RESUME) != 0;
        safety.restart = (in.acts & SQMAP_TICK_RESTART) != 0;
        const haptic::SafetyReport report = filter_.tick(safety, {&sent, 1});
        put(out.force, sent.force);
        put(out.torque, sent.torque);
        put(out.commanded, commanded.force);
        out.depth = zone.depth;
        put(out.normal, zone.normal);
        out.status = step.status;
        out.acted = report.acted;
        out.faults = report.faults;
        out.is_engaged = report.engaged ? 1 : 0;
        put(out.tool, zone.body);
        return out;
    }

    /// The next millisecond of a hand that wants to be at target.
    sqmap_force simulate(Vec3d target, Vec3d& position) noexcept
    {
        if (!is_simulated_) held_.reset({{}, target});
        held_.step(is_simulated_ ? &written_ : nullptr, {{{}, target}, {}}, k_period);
        is_simulated_ = true;
        const Pose measured = held_.measured();
        position = measured.translation;
        sqmap_tick in{};
        in.time = in.sample_time = k_period * static_cast<double>(++ticks_);
        in.sequence = ticks_;
        in.acts = SQMAP_TICK_HELD;
        put(in.pose, measured);
        const sqmap_force out = tick(in);
        written_ = {{out.force[0], out.force[1], out.force[2]}, {out.torque[0], out.torque[1], out.torque[2]}};
        return out;
    }

private:
    std::shared_ptr<Model> model_;
    Opened read_;
    double metres_per_unit_;
    model::ModelView view_;
    haptic::Tool tool_;
    std::unique_ptr<query::Probe> surface_;  // of the model; null: points alone touch it
    haptic::TouchedBody touched_;
    haptic::State state_;
    haptic::SafetyFilter filter_;
    double time_ = 0;
    device::HeldTool held_{device::Mechanism{}, device::hand_profile("pen")};
    haptic::Wrench written_;
    bool is_simulated_ = false;
    std::uint64_t ticks_ = 0;
};

static Handles<Session, 4>& sessions() { return table<Session, 4>(); }

}  // namespace sqmap::capi

using namespace sqmap;
using capi::guarded;
using capi::needed;

sqmap_code sqmap_make_session(sqmap_model model, const sqmap_session_options* options, sqmap_session* session)
{
    return capi::opened(session, "session", capi::sessions(), [&] {
        const auto& touched = capi::model_of(model);
        return std::make_shared<capi::Session>(touched, capi::taken(options, "options"));
    });
}

sqmap_code sqmap_tick_session(sqmap_session session, const sqmap_tick* tick, sqmap_force* force)
{
    return guarded([&] {
        // Zero first: whatever fails below leaves no force behind.
        sqmap_force out = capi::taken(&needed(force, "force"), "force");
        const std::size_t size = out.size;
        out = {};
        out.size = size;
        capi::give(force, out);
        const sqmap_tick in = capi::taken(&needed(tick, "tick"), "tick");
        capi::give(force, capi::sessions().find(session.id, "session")->tick(in));
    });
}

sqmap_code sqmap_simulate(sqmap_session session, const sqmap_simulation* simulation)
{
    return guarded([&] {
        capi::Session& s = *capi::sessions().find(session.id, "session");
        const sqmap_simulation in = capi::taken(&needed(simulation, "simulation"), "simulation");
        const std::span<const Vec3d> targets =
            capi::rows({sizeof(sqmap_points), in.targets, in.count, nullptr}, "simulation.targets");
        capi::check_finite(targets, "simulation.targets");
        for (std::size_t i = 0; i < targets.size(); ++i) {
            Vec3d position{};
            const sqmap_force out = s.simulate(targets[i], position);
            if (in.positions != nullptr) capi::put(in.positions + 3 * i, position);
            if (in.forces != nullptr) std::copy(out.force, out.force + 3, in.forces + 3 * i);
            if (in.depths != nullptr) in.depths[i] = out.depth;
            if (in.tools != nullptr) std::copy(out.tool.translation, out.tool.translation + 3, in.tools + 3 * i);
        }
    });
}

sqmap_code sqmap_close_session(sqmap_session session)
{
    return guarded([&] { capi::sessions().close(session.id, "session"); });
}
