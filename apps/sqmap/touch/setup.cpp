#include "touch/setup.h"

#include "commands.h"
#include "common/layer_name.h"
#include "common/load_mesh.h"
#include "sqmap/haptic/patch.h"
#include "touch/hand_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <map>
#include <span>
#include <tuple>

namespace sqmap::app {
namespace {

using nlohmann::ordered_json;

constexpr double k_default_radius = 0.005, k_least_radius = 1e-6, k_two_pi = 6.283185307179586;

const std::map<std::string, haptic::Mode> k_modes{
    {"direct", haptic::Mode::Direct}, {"proxy", haptic::Mode::Proxy}, {"coupled", haptic::Mode::Coupled}};
const std::map<std::string, haptic::Shading> k_shadings{{"levelled", haptic::Shading::Levelled},
                                                        {"consistent", haptic::Shading::Consistent}};
const std::map<std::string, Friction> k_frictions{
    {"none", Friction::None}, {"coulomb", Friction::Coulomb}, {"paper", Friction::Paper}};
const std::map<std::string, haptic::Kernel> k_kernels{{"ball", haptic::Kernel::Ball}, {"shell", haptic::Kernel::Shell}};
const std::map<std::string, query::Layer> k_layers =
    layers_by_name({query::Layer::Auto, query::Layer::Two, query::Layer::Three, query::Layer::Exact});

template <class Value>
std::string name_of(const std::map<std::string, Value>& names, Value value)
{
    const auto at = std::find_if(names.begin(), names.end(), [&](const auto& entry) { return entry.second == value; });
    return at == names.end() ? "?" : at->first;
}

/// visit(name, number) for every number of the forces: one list for writing and reading.
template <class Options, class Visit>
void each_number(Options& o, Visit visit)
{
    visit("stiffness", o.zone.stiffness);
    visit("damping", o.zone.damping);
    visit("tangential_stiffness", o.zone.tangential_stiffness);
    visit("torque_share", o.zone.torque_share);
    visit("brake", o.zone.brake);
    visit("brake_ahead", o.zone.brake_ahead);
    visit("blend_time", o.zone.blend_time);
    visit("coupling_stiffness", o.zone.coupling_stiffness);
    visit("coupling_rotational", o.zone.coupling_rotational);
    visit("mass", o.zone.mass);
    visit("inertia", o.zone.inertia);
    visit("coupling_damping", o.zone.coupling_damping);
    visit("coupling_rotational_damping", o.zone.coupling_rotational_damping);
    visit("zone_radius", o.zone_radius);
    visit("mu_static", o.material.mu_static);
    visit("mu_dynamic", o.material.mu_dynamic);
    visit("f_c", o.material.f_c);
    visit("k_f", o.material.k_f);
    visit("tool_size", o.tool_size);
}

/// Those that traces of before do not have: what their defaults say was done then.
template <class Options, class Visit>
void each_later_number(Options& o, Visit visit)
{
    visit("tool_spacing", o.tool_spacing);
    visit("tool_touching", o.tool_touching);
    visit("resolution", o.zone.resolution);
    visit("proxy_depth", o.zone.proxy_depth);
    visit("tolerance", o.tolerance);
    visit("hand_length", o.hand_length);
    visit("texture_depth", o.texture.depth);
    visit("texture_wavelength", o.texture.wavelength);
    visit("object_mass", o.body.mass);
    visit("object_spring", o.body.spring);
    visit("sway_x", o.body.sway.x);
    visit("sway_y", o.body.sway.y);
    visit("sway_z", o.body.sway.z);
    visit("sway_period", o.body.sway_period);
}

std::string hex(std::uint64_t hash)
{
    char text[20];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

std::uint64_t from_hex(const std::string& text)
{
    std::uint64_t hash = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), hash, 16);
    if (error != std::errc() || end != text.data() + text.size()) throw BadTouch("'" + text.substr(0, 20) + "' is no hash");
    return hash;
}

/// Axis times angle, 0 to less than pi.
Vec3d turn_of(const Mat3d& m)
{
    const Vec3d s = 0.5 * Vec3d{m.row[2].y - m.row[1].z, m.row[0].z - m.row[2].x, m.row[1].x - m.row[0].y};
    const double sine = norm(s);
    return sine > 1e-9 ? std::atan2(sine, 0.5 * (m.row[0].x + m.row[1].y + m.row[2].z - 1)) / sine * s : s;
}

/// m turned further by |by| about by, and still a rotation: to first order, which a tick's turn is.
Mat3d turned(const Mat3d& m, const Vec3d& by)
{
    Vec3d x{m.row[0].x, m.row[1].x, m.row[2].x}, y{m.row[0].y, m.row[1].y, m.row[2].y};
    x = normalized(x + cross(by, x));
    y += cross(by, y);
    y = normalized(y - dot(x, y) * x);
    const Vec3d z = cross(x, y);
    return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}};
}

/// FNV-1a over the bits of points: tells one tool from another.
std::uint64_t hash_of(std::span<const Vec3d> points)
{
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const Vec3d& p : points)
        for (int i = 0; i < 3; ++i) hash = (hash ^ std::bit_cast<std::uint64_t>(p[i])) * 0x100000001b3u;
    return hash | 1u;  // never the 0 that stands for any
}

/// NAME or NAME:RADIUS, m; false for any other tool.
bool is_shape(const std::string& tool, const std::string& name, double most, double& radius)
{
    if (tool == name) return true;
    if (!tool.starts_with(name + ":")) return false;
    const char* const last = tool.data() + tool.size();
    const auto [end, error] = std::from_chars(tool.data() + name.size() + 1, last, radius);
    if (error != std::errc() || end != last || !(radius >= k_least_radius && radius <= most)) {
        char limits[80];
        std::snprintf(limits, sizeof limits, "%g to %.4g m, the first object's R_max", k_least_radius, most);
        throw BadTouch("--tool " + tool + ": the radius must be a number from " + limits + "\n  cure: metres, as in " + name +
                       ":0.005");
    }
    return true;
}

}  // namespace

std::filesystem::path found(const std::string& file, const std::filesystem::path& beside)
{
    std::error_code ignored;
    const std::filesystem::path other = beside / std::filesystem::path(file).filename();
    if (!beside.empty() && !std::filesystem::exists(file, ignored) && std::filesystem::exists(other, ignored)) return other;
    return file;
}

TouchSetup::TouchSetup(const TouchOptions& options, std::size_t zones, const std::filesystem::path& beside)
    : options_(options), zones_(zones)
{
    models_.reserve(options_.objects.size());
    views_.reserve(options_.objects.size());
    for (TouchObject& object : options_.objects) {
        const model::ModelView& view = models_.emplace_back(found(object.file, beside)).view();
        const std::uint64_t hash = model::content_hash(view);
        if (object.hash != 0 && object.hash != hash)
            throw BadTouch(object.file + " is not the model that was recorded: its content hash is " + hex(hash) +
                           ", the trace has " + hex(object.hash) + "\n  cure: bring that model, or compare with --against");
        object.hash = hash;
        if (!(object.metres_per_unit > 0) || !std::isfinite(object.metres_per_unit))
            throw BadTouch(object.file + ": metres a unit must be above zero");
        views_.push_back(haptic::in_metres(view, object.metres_per_unit));
        const model::Header& h = views_.back().header;
        solids_.push_back(
            {.pose = {{}, object.place - Vec3d{h.origin[0], h.origin[1], h.origin[2]}}, .material = options_.material});
    }
    for (std::size_t i = 0; i < solids_.size(); ++i) solids_[i].model = &views_[i];
    texture_ = make_texture(options_.texture, beside);
    if (options_.texture_hash != 0 && options_.texture_hash != texture_.hash)
        throw BadTouch("--texture " + options_.texture.kind + " is not the texture that was recorded: its hash is " +
                       hex(texture_.hash) + ", the trace has " + hex(options_.texture_hash));
    options_.texture_hash = texture_.hash;
    if (texture_.texture.n > 0)
        for (haptic::TouchedBody& solid : solids_) solid.material.texture = &texture_.texture;
    for (std::size_t i = 0; i < solids_.size(); ++i) {
        const model::Header& h = views_[i].header;
        const double radius = 0.5 * h.unit * h.r_max;
        bodies_.push_back(
            {.centre = {h.origin[0], h.origin[1], h.origin[2]}, .inertia = 0.4 * options_.body.mass * radius * radius});
        place(i);
    }
    pushes_.resize(solids_.size());
    load_tool(beside);
    state_ = std::make_unique<haptic::State>(zones_of_tool(),
                                             haptic::StateOptions{.max_contacts = std::max(probe_->size(), denser_.max_points()),
                                                                  .max_touched = std::max<std::size_t>(1, solids_.size())});
}

std::vector<haptic::Zone> TouchSetup::zones_of_tool() const
{
    const haptic::Zone zone{.probe = probe_.get(),
                            .in_world = hand_ != nullptr,
                            .weights = weights_,
                            .denser = denser_.points(),
                            .max_touching = static_cast<std::uint32_t>(options_.tool_touching),
                            .radius = options_.zone_radius > 0 ? options_.zone_radius : std::numeric_limits<double>::infinity(),
                            .options = options_.zone};
    std::vector<haptic::Zone> zones(zones_, zone);
    for (std::size_t z = 0; hand_ && z < zones.size(); ++z) {
        zones[z].first = hand_->first(z);
        zones[z].count = hand_->first(z + 1) - hand_->first(z);
        zones[z].options = options_of(z);
    }
    return zones;
}

/// How far a finger is closed follows from how its tip lies: a torque there would bend it, and the loop would swing.
haptic::ZoneOptions TouchSetup::options_of(std::size_t zone) const
{
    haptic::ZoneOptions o = options_.zone;
    if (hand_ && zone + 1 < zones_) o.torque_share = 0;
    return o;
}

/// A glove's six zones and a hand with joints: one probe, moved as the hand is posed.
void TouchSetup::load_hand(device::HandMesh mesh)
{
    hand_ = std::make_unique<device::HandSkin>(mesh, options_.hand_length);
    weights_.assign(hand_->weights().begin(), hand_->weights().end());
    reach_ = hand_->reach(zones_ - 1);  // the palm: fingertips carry force alone
    std::vector<Vec3d> middle(hand_->points().begin(), hand_->points().end());
    for (Vec3d& p : middle) p.y -= 0.45 * options_.hand_length;
    probe_ = std::make_unique<query::Probe>(middle);
    points_ = std::move(middle);
}

query::Probe TouchSetup::tool_at(std::span<const sqmap::Pose> zones) const
{
    if (hand_) return query::Probe(points_);
    std::vector<Vec3d> points;
    for (const sqmap::Pose& zone : zones)
        for (const Vec3d& p : points_) points.push_back(zone.rotation * p + zone.translation);
    return query::Probe(points);
}

void TouchSetup::suit(const haptic::DeviceLimits* device)
{
    haptic::ZoneOptions& zone = options_.zone;
    const CouplingWishes& w = options_.coupling;
    const bool mesh = zone.averaging == haptic::Averaging::Patch, coupled = zone.mode == haptic::Mode::Coupled;
    zone.inertia = w.inertia.value_or(mesh ? 0.4 * zone.mass * reach_ * reach_ : zone.inertia);
    if (w.stiffness) zone.coupling_stiffness = *w.stiffness;
    if (!coupled && (w.stiffness || w.damping || w.rotational || w.rotational_damping || w.inertia))
        notes_.push_back("warning: the coupling's options count in --mode coupled only");
    if (mesh && (options_.tolerance >= 0 || options_.kernel != haptic::Kernel::Ball))
        notes_.push_back(
            "warning: --smoothing-kernel and --smoothing-tolerance are of a sphere or a point; a mesh feels the mean of its "
            "contacts");
    if (device != nullptr) {
        zone.resolution = device->resolution;
        if (const double dampers = zone.damping + zone.brake, own = device->damping; !coupled && own > 0 && dampers > 0.5 * own) {
            // A damper comes late: one near the device's own leaves no stiffness that is safe, and swings by itself.
            char text[200];
            std::snprintf(
                text, sizeof text,
                "warning: --damping %g and --brake %g are scaled by %.2g: half of this device's own %.3g N s/m is left for "
                "them",
                zone.damping, zone.brake, 0.5 * own / dampers, own);
            notes_.push_back(text);
            zone.damping *= 0.5 * own / dampers;
            zone.brake *= 0.5 * own / dampers;
        }
        const double most = haptic::check_stiffness(*device, zone.stiffness, zone.damping + zone.brake).largest;
        if (!coupled && !options_.stiffness_wished && most > 0 && most < zone.stiffness) {
            zone.stiffness = most;
            char text[100];
            std::snprintf(text, sizeof text, "stiffness %.0f N/m: as much as this device shows without ever giving energy", most);
            notes_.push_back(text);
        }
        if (coupled) {
            if (!w.stiffness) zone.coupling_stiffness = 1e6;  // as stiff as the device carries
            haptic::choose_coupling(zone, *device);
            if (w.stiffness && zone.coupling_stiffness < *w.stiffness) {
                char text[200];
                std::snprintf(text, sizeof text,
                              "warning: --coupling-stiffness %g: this device carries %.0f N/m; what was asked for may swing",
                              *w.stiffness, zone.coupling_stiffness);
                notes_.push_back(text);
                zone.coupling_stiffness = *w.stiffness;
            }
        } else if (mesh && device->max_torque > 0) {
            zone.torque_share = std::min(zone.torque_share, haptic::largest_torque_share(*device, zone.stiffness, reach_));
            if (zone.torque_share < 1) {
                char text[200];
                std::snprintf(
                    text, sizeof text,
                    "torque is scaled by %.2g: a tool that reaches %.3g m would turn this device more stiffly than it can show",
                    zone.torque_share, reach_);
                notes_.push_back(text);
            }
        }
    }
    zone.coupling_damping = w.damping.value_or(zone.coupling_damping);
    zone.coupling_rotational = w.rotational.value_or(zone.coupling_rotational);
    zone.coupling_rotational_damping = w.rotational_damping.value_or(zone.coupling_rotational_damping);
    if (coupled) {
        char text[200];
        std::snprintf(text, sizeof text, "coupled by %.0f N/m and %.2g N s/m, %.2g N m/rad and %.2g N m s/rad",
                      zone.coupling_stiffness, zone.coupling_damping, zone.coupling_rotational, zone.coupling_rotational_damping);
        notes_.push_back(text);
    }
    for (std::size_t z = 0; z < zones_; ++z) state_->options(z) = options_of(z);
}

void TouchSetup::load_tool(const std::filesystem::path& beside)
{
    mesh::Mesh tool;
    options_.zone.averaging = haptic::Averaging::Patch;
    haptic::Smoothing ball = haptic::ball_of(k_default_radius), point;
    if (options_.tolerance >= 0) ball.tolerance = point.tolerance = options_.tolerance;
    ball.kernel = point.kernel = options_.kernel;
    const double most = views_.front().header.r_max * views_.front().header.unit;
    if (is_shape(options_.tool, "sphere", most, ball.radius)) {
        options_.zone.averaging = haptic::Averaging::Ball;
        options_.zone.smoothing = ball;
        tool.vertices = haptic::stencil_points(ball);
    } else if (is_shape(options_.tool, "point", most, point.radius)) {
        options_.zone.averaging = haptic::Averaging::Stencil;
        options_.zone.smoothing = point;
        tool.vertices = haptic::stencil_points(point);
        point_ = std::make_unique<query::Probe>(std::vector<Vec3d>{{}});
    } else if (std::optional<device::HandMesh> hand;
               zones_ == device::k_glove_zones && (hand = read_hand(found(options_.tool, beside)))) {
        tool.vertices = hand->points;
        load_hand(std::move(*hand));
    } else {
        if (zones_ > 1)
            notes_.push_back("warning: each of the " + std::to_string(zones_) + " zones carries the whole of " + options_.tool +
                             (zones_ == device::k_glove_zones ? "; a glove poses a glTF hand with WebXR's 25 joints" : ""));
        load_mesh_tool(beside, tool);
    }
    const bool patch = options_.zone.averaging == haptic::Averaging::Patch;
    if (options_.zone.layer == query::Layer::Auto) options_.zone.layer = patch ? query::Layer::Three : query::Layer::Exact;
    const std::uint64_t hash = hash_of(tool.vertices);
    if (options_.tool_hash != 0 && options_.tool_hash != hash)
        throw BadTouch(options_.tool + " is not the tool that was recorded: its hash is " + hex(hash) + ", the trace has " +
                       hex(options_.tool_hash));
    options_.tool_hash = hash;
    if (!hand_) {
        probe_ = std::make_unique<query::Probe>(tool.vertices);
        points_ = tool.vertices;
    }
    if (!(options_.zone_radius > 0)) return;
    if (!patch) {
        notes_.push_back("warning: --zone counts for a mesh only: " + options_.tool + " is felt as a whole");
    } else if (!hand_) {
        double nearest = INFINITY;
        std::size_t count = 0;
        for (const Vec3d& p : tool.vertices) {
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
                      options_.zone_radius, count, tool.vertices.size(), nearest);
        notes_.push_back(text);
    }
}

void TouchSetup::load_mesh_tool(const std::filesystem::path& beside, mesh::Mesh& tool)
{
    LoadedMesh loaded = load_mesh(found(options_.tool, beside), {.accept_surface = true});
    if (loaded.refused()) throw BadTouch(options_.tool + ": " + report(loaded));
    tool = std::move(loaded.mesh);
    // Turned about the centre of its surface, and as large as asked.
    const Vec3d centre = mesh::normalization_of(tool).origin;
    const double scale = options_.tool_size / mesh::largest_vertex_distance(tool);
    for (Vec3d& v : tool.vertices) v = scale * (v - centre);
    if (options_.tool_touching > 0 && !(options_.tool_spacing > 0)) denser_ = haptic::DenserSets(tool.vertices, tool.triangles);
    haptic::PatchPoints patch = haptic::patch_points(tool.vertices, tool.triangles, options_.tool_spacing);
    tool.vertices = std::move(patch.points);
    weights_ = std::move(patch.weights);
    for (const Vec3d& v : tool.vertices) reach_ = std::max(reach_, norm(v));
}

void TouchSetup::place(std::size_t object) noexcept
{
    const BodyOptions& o = options_.body;
    const Body& b = bodies_[object];
    haptic::TouchedBody& solid = solids_[object];
    const double phase = k_two_pi * time_ / o.sway_period;
    const Vec3d centre = options_.objects[object].place + std::sin(phase) * o.sway + b.off;
    const Vec3d speed = (k_two_pi / o.sway_period * std::cos(phase)) * o.sway + b.speed;
    const Vec3d arm = b.turn * b.centre;  // from the mesh's origin to the centre
    solid.pose = {b.turn, centre - arm};
    solid.twist = {speed - cross(b.spin, arm), b.spin};
}

/// Backward Euler in spring and damper, what touches held over the tick.
void TouchSetup::move_objects(double dt) noexcept
{
    time_ += dt;
    const BodyOptions& o = options_.body;
    if (!(o.mass > 0) && norm_sq(o.sway) == 0) return;
    for (std::size_t i = 0; i < solids_.size(); ++i) {
        Body& b = bodies_[i];
        if (o.mass > 0) {
            const double per_mass = o.spring / o.mass, drag = 2 * std::sqrt(per_mass);
            const double give = 1 / (1 + dt * drag + dt * dt * per_mass);
            const haptic::Wrench& push = pushes_[i];
            const Vec3d torque = push.torque - cross(b.turn * b.centre, push.force);
            b.speed = give * (b.speed + dt * (push.force / o.mass - per_mass * b.off));
            b.spin = give * (b.spin + dt * (torque / b.inertia - per_mass * turn_of(b.turn)));
            b.off += dt * b.speed;
            b.turn = turned(b.turn, dt * b.spin);
        }
        place(i);
    }
}

void TouchSetup::step(device::TraceRow& row) noexcept
{
    move_objects(row.dt);
    // A zone without a pose has no force, and the hand stays as it was.
    const auto finite = [](const sqmap::Pose& p) {
        return std::isfinite(norm_sq(p.translation) + norm_sq(p.rotation.row[0]) + norm_sq(p.rotation.row[1]) +
                             norm_sq(p.rotation.row[2]));
    };
    if (hand_ && std::all_of(row.poses.begin(), row.poses.begin() + device::k_glove_zones, finite)) {
        hand_->pose(std::span<const sqmap::Pose, device::k_glove_zones>(row.poses.data(), device::k_glove_zones));
        probe_->move(hand_->points());
    }
    haptic::StepInput input{.touched = solids_, .poses = {row.poses.data(), zones_}, .twists = {}, .dt = row.dt};
    if ((row.input & device::k_trace_measured_twist) != 0) input.twists = {row.twists.data(), zones_};
    input.degraded = (row.input & device::k_trace_degraded) != 0;
    const haptic::StepResult result = haptic::step(*state_, input, {row.computed.data(), zones_}, pushes_);
    row.contacts = result.contacts;
    row.depth = result.deepest;
    device_depth_ = result.deepest;
    if (options_.zone.mode == haptic::Mode::Proxy)
        for (std::size_t z = 0; z < zones_; ++z) device_depth_ = std::max(device_depth_, state_->report(z).depth);
    for (std::size_t z = 0; z < zones_; ++z) zone_pushes_[z] = state_->report(z).push;
    row.status = result.status;
}

void check(const TouchOptions& o, const std::string& what)
{
    const auto number = [&](const std::string& name, double value) {
        const bool signed_too = name == "tolerance" || name.starts_with("sway_");
        const bool at_least = signed_too ? std::isfinite(value) : value >= 0;
        const bool above = value > 0 || (name != "mass" && name != "inertia" && name != "tool_size" && name != "hand_length" &&
                                         name != "sway_period" && name != "texture_wavelength");
        if (at_least && above && std::fabs(value) <= 1e6) return;
        char text[40];
        std::snprintf(text, sizeof text, "%g", value);
        throw BadTouch(what + name + " is " + text + ": it must be " + (above ? "0" : "above 0") + " to 1e6\n  cure: " +
                       (what.empty() ? "another number" : "record again, or mend the number in the trace's line '# setup'"));
    };
    each_number(o, number);
    each_later_number(o, number);
    if (o.material.mu_static < o.material.mu_dynamic) {
        char text[200];
        std::snprintf(text, sizeof text,
                      "%s %g is below %s %g: nothing would ever stick\n  cure: give both, static at least dynamic",
                      what.empty() ? "--mu-static" : (what + "mu_static").c_str(), o.material.mu_static,
                      what.empty() ? "--mu-dynamic" : "mu_dynamic", o.material.mu_dynamic);
        throw BadTouch(text);
    }
    if (o.body.mass > 0 && o.body.mass < 0.01)
        throw BadTouch(what + "--object-mass must be 0 (fixed) or at least 0.01 kg: a lighter one would swing on the contact");
}

double softest_spring(const TouchOptions& o)
{
    double k = o.zone.stiffness;
    // A mesh feels its mean depth, which grows more slowly than it is pressed in while the patch still widens.
    if (o.zone.averaging == haptic::Averaging::Patch) k *= 0.25;
    if (o.zone.mode == haptic::Mode::Coupled && k > 0)  // one after the other
        k = k * o.zone.coupling_stiffness / (k + o.zone.coupling_stiffness);
    if (o.material.friction == Friction::Coulomb) k = std::min(k, o.zone.tangential_stiffness);
    return std::clamp(k, 20., 1e6);  // what the filter takes
}

std::string setup_text(const TouchOptions& o)
{
    ordered_json out;
    out["objects"] = ordered_json::array();
    for (const TouchObject& object : o.objects)
        out["objects"].push_back({{"file", object.file},
                                  {"hash", hex(object.hash)},
                                  {"metres_per_unit", object.metres_per_unit},
                                  {"place", {object.place.x, object.place.y, object.place.z}}});
    out["tool"] = o.tool;
    out["tool_hash"] = hex(o.tool_hash);
    out["mode"] = name_of(k_modes, o.zone.mode);
    out["shading"] = name_of(k_shadings, o.zone.shading);
    out["layer"] = name_of(k_layers, o.zone.layer);
    out["friction"] = name_of(k_frictions, o.material.friction);
    out["kernel"] = name_of(k_kernels, o.kernel);
    out["texture"] = o.texture.kind;
    out["texture_seed"] = o.texture.seed;
    out["texture_hash"] = hex(o.texture_hash);
    const auto number = [&](const char* name, double value) { out[name] = value; };
    each_number(o, number);
    each_later_number(o, number);
    return out.dump();
}

TouchOptions setup_from(const std::string& text)
{
    try {
        const ordered_json in = ordered_json::parse(text);
        TouchOptions o;
        for (const ordered_json& object : in.at("objects")) {
            const auto place = object.at("place").get<std::array<double, 3>>();
            o.objects.push_back({.file = object.at("file"),
                                 .place = {place[0], place[1], place[2]},
                                 .metres_per_unit = object.at("metres_per_unit"),
                                 .hash = from_hex(object.at("hash"))});
        }
        if (o.objects.empty()) throw BadTouch("the trace's setup has no object");
        o.tool = in.at("tool");
        o.tool_hash = from_hex(in.at("tool_hash"));
        o.zone.mode = k_modes.at(in.at("mode"));
        o.zone.shading = k_shadings.at(in.at("shading"));
        o.zone.layer = k_layers.at(in.at("layer"));
        o.material.friction = k_frictions.at(in.at("friction"));
        each_number(o, [&](const char* name, double& value) { value = in.at(name); });
        // A trace from before something was there has what was done then.
        each_later_number(o, [&](const char* name, double& value) { value = in.value(name, value); });
        if (in.contains("kernel")) o.kernel = k_kernels.at(in.at("kernel"));
        o.texture.kind = in.value("texture", o.texture.kind);
        o.texture.seed = in.value("texture_seed", o.texture.seed);
        if (in.contains("texture_hash")) o.texture_hash = from_hex(in.at("texture_hash"));
        check(o, "the trace's setup: ");
        return o;
    } catch (const ordered_json::exception& e) {
        const std::string why = e.what();  // "[json.exception...] why"
        throw BadTouch("the trace's setup does not read: " + why.substr(std::min(why.find("] ") + 2, why.size())) +
                       "\n  cure: record again, or mend its line '# setup'");
    } catch (const std::out_of_range&) {
        throw BadTouch("the trace's setup names a mode, shading, kernel, layer or friction that this program does not have");
    }
}

void warn_of_idle(const CLI::App& command, const TouchOptions& o)
{
    const bool coulomb = o.material.friction == Friction::Coulomb, paper = o.material.friction == Friction::Paper;
    const bool texture = o.texture.kind != "none", sways = norm_sq(o.body.sway) > 0;
    const std::tuple<const char*, bool, const char*> k_needs[] = {
        {"--mu-static", coulomb, "--friction coulomb"},
        {"--mu-dynamic", coulomb, "--friction coulomb"},
        {"--f-c", paper, "--friction paper"},
        {"--k-f", paper, "--friction paper"},
        {"--proxy-depth", o.zone.mode == haptic::Mode::Proxy && !o.tool.starts_with("point"),
         "--mode proxy and a mesh or a sphere"},
        {"--brake", o.zone.mode != haptic::Mode::Proxy, "--mode direct or coupled"},
        {"--tool-touching", !o.tool.starts_with("point") && !o.tool.starts_with("sphere"), "a mesh as tool"},
        {"--mass", o.zone.mode == haptic::Mode::Coupled, "--mode coupled"},
        {"--texture-depth", texture, "--texture"},
        {"--texture-wavelength", texture, "--texture"},
        {"--texture-seed", o.texture.kind == "gaussian", "--texture gaussian"},
        {"--object-spring", o.body.mass > 0, "--object-mass"},
        {"--sway-period", sways, "--sway"}};
    for (const auto& [option, counts, needs] : k_needs)
        if (!counts && command.count(option) > 0) std::fprintf(stderr, "warning: %s counts with %s only\n", option, needs);
}

void add_force_options(CLI::App& command, TouchOptions& o)
{
    const std::string group = "Forces";
    const auto number = [&](const char* name, double& value, const char* words) {
        command.add_option(name, value, words)->check(not_below_zero(1e6))->group(group)->capture_default_str();
    };
    const auto choice = [&](const char* name, auto& value, const auto& names, const char* words, const char* type) {
        command.add_option(name, value, words)
            ->transform(CLI::Validator(
                [&names, type](std::string& text) {  // by name alone: CLI11's own takes the enumerator's number as well
                    const auto found = names.find(CLI::detail::to_lower(text));
                    if (found == names.end()) return "'" + text + "' is none of " + type;
                    text = std::to_string(static_cast<int>(found->second));
                    return std::string();
                },
                type))
            ->type_name(type)
            ->default_str(name_of(names, value))
            ->group(group);
    };
    number("--stiffness", o.zone.stiffness, "k, N/m (eqs. 21 and 32)");
    number("--damping", o.zone.damping, "N s/m along the normal while pressing in");
    choice("--mode", o.zone.mode, k_modes, "How the tool follows the device", "direct|proxy|coupled");
    choice("--shading", o.zone.shading, k_shadings, "Full force across edges, or the gradient of one potential",
           "levelled|consistent");
    choice("--layer", o.zone.layer, k_layers, "Map to ask; auto: exact for a sphere or a point, 3 for a mesh", "auto|2|3|exact");
    choice("--friction", o.material.friction, k_frictions, "How the surface rubs; paper is eq. 33 as printed",
           "none|coulomb|paper");
    number("--mu-static", o.material.mu_static, "Coulomb friction before slipping");
    number("--mu-dynamic", o.material.mu_dynamic, "Coulomb friction while slipping");
    number("--f-c", o.material.f_c, "f_c of eq. 33, N");
    number("--k-f", o.material.k_f, "k_f of eq. 33, 1/m");
    number("--brake", o.zone.brake, "N s/m against the approach before contact; 0: none");
    command.add_option("--proxy-depth", o.zone.proxy_depth, "m that the proxy of a mesh or a sphere lies in the surface")
        ->check(in_range(0., 0.05))
        ->group(group)
        ->capture_default_str();
    number("--blend", o.zone.blend_time, "s in which a jump of the foot point fades to 1/e; 0: jumps pass");
    const auto wish = [&](const char* name, std::optional<double>& value, const char* words, const char* of) {
        command.add_option(name, value, words)->check(not_below_zero(1e6))->group(of);
    };
    const char* const coupling = "Coupling (--mode coupled); default: taken from the device";
    wish("--coupling-stiffness", o.coupling.stiffness, "N/m between device and body", coupling);
    wish("--coupling-damping", o.coupling.damping, "N s/m", coupling);
    wish("--coupling-turn-stiffness", o.coupling.rotational, "N m/rad", coupling);
    wish("--coupling-turn-damping", o.coupling.rotational_damping, "N m s/rad", coupling);
    command.add_option("--mass", o.zone.mass, "kg of the body")->check(above_zero(1e6))->group(coupling)->capture_default_str();
    command.add_option("--inertia", o.coupling.inertia, "kg m^2; default: from mass and tool")
        ->check(above_zero(1e6))
        ->group(coupling);
    const char* const surface = "Surface";
    command
        .add_option("--texture", o.texture.kind, "none, gaussian, image:FILE.png (square, black is deep), ridges, weave or bumps")
        ->group(surface)
        ->capture_default_str();
    command.add_option("--texture-depth", o.texture.depth, "m, of the deepest; of noise two standard deviations")
        ->check(above_zero(0.1))
        ->group(surface)
        ->capture_default_str();
    command.add_option("--texture-wavelength", o.texture.wavelength, "m: shortest of the noise, a period, of an image a pixel")
        ->check(above_zero(1))
        ->group(surface)
        ->capture_default_str();
    command.add_option("--texture-seed", o.texture.seed, "Of the noise")->group(surface)->capture_default_str();
    choice("--smoothing-kernel", o.kernel, k_kernels, "Direction from depths alone, or from the map's normals (sphere, point)",
           "ball|shell");
    command.add_option("--smoothing-tolerance", o.tolerance, "m, by which smoothed depth may differ from true (sphere, point)")
        ->check(not_below_zero(0.1))
        ->default_str("0.0003 of a sphere, 0.0002 of a point")
        ->group(group);
    const char* const moving = "Objects that move";
    command.add_option("--object-mass", o.body.mass, "kg; the tool pushes them; 0: they are fixed")
        ->check(not_below_zero(1e6))
        ->group(moving)
        ->capture_default_str();
    command.add_option("--object-spring", o.body.spring, "N/m that holds each at its place, critically damped; 0: free")
        ->check(not_below_zero(1e6))
        ->group(moving)
        ->capture_default_str();
    command
        .add_option_function<std::vector<double>>(
            "--sway",
            [&o](const std::vector<double>& v) {
                o.body.sway = {v[0], v[1], v[2]};
            },
            "m along x, y, z, to and fro")
        ->delimiter('/')
        ->expected(3)
        ->type_name("X/Y/Z")
        ->group(moving);
    command.add_option("--sway-period", o.body.sway_period, "s")->check(above_zero(1e6))->group(moving)->capture_default_str();
    number("--zone", o.zone_radius, "Impact zone of a mesh: m about its centre that count; 0: the whole tool");
}

}  // namespace sqmap::app
