#include "touch_setup.h"

#include "commands.h"
#include "load_mesh.h"
#include "sqmap/haptic/patch.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <map>
#include <span>

namespace sqmap::app {
namespace {

using nlohmann::ordered_json;

constexpr double k_default_radius = 0.005;

const std::map<std::string, haptic::Mode> k_modes{
    {"direct", haptic::Mode::Direct}, {"proxy", haptic::Mode::Proxy}, {"coupled", haptic::Mode::Coupled}};
const std::map<std::string, haptic::Shading> k_shadings{{"levelled", haptic::Shading::Levelled},
                                                        {"consistent", haptic::Shading::Consistent}};
const std::map<std::string, haptic::Friction> k_frictions{
    {"none", haptic::Friction::None}, {"coulomb", haptic::Friction::Coulomb}, {"paper", haptic::Friction::Paper}};
const std::map<std::string, query::Layer> k_layers{
    {"auto", query::Layer::Auto}, {"2", query::Layer::Two}, {"3", query::Layer::Three}, {"exact", query::Layer::Exact}};

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
    visit("tool_spacing", o.tool_spacing);
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

/// FNV-1a over the bits of points: tells one tool from another.
std::uint64_t hash_of(std::span<const Vec3d> points)
{
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const Vec3d& p : points)
        for (int i = 0; i < 3; ++i) hash = (hash ^ std::bit_cast<std::uint64_t>(p[i])) * 0x100000001b3u;
    return hash | 1u;  // never the 0 that stands for any
}

/// NAME or NAME:RADIUS, m; false for any other tool.
bool is_shape(const std::string& tool, const std::string& name, double& radius)
{
    if (tool == name) return true;
    if (!tool.starts_with(name + ":")) return false;
    const char* const last = tool.data() + tool.size();
    const auto [end, error] = std::from_chars(tool.data() + name.size() + 1, last, radius);
    if (error != std::errc() || end != last || !(radius > 0 && radius < 10))
        throw BadTouch("--tool " + tool + ": the radius in metres must be above zero, as in sphere:0.005");
    return true;
}

std::filesystem::path found(const std::string& file, const std::filesystem::path& beside)
{
    std::error_code ignored;
    const std::filesystem::path other = beside / std::filesystem::path(file).filename();
    if (!beside.empty() && !std::filesystem::exists(file, ignored) && std::filesystem::exists(other, ignored)) return other;
    return file;
}

}  // namespace

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
    load_tool(beside);
    const haptic::Zone zone{.probe = probe_.get(),
                            .weights = weights_,
                            .radius = options_.zone_radius > 0 ? options_.zone_radius : std::numeric_limits<double>::infinity(),
                            .options = options_.zone};
    state_ = std::make_unique<haptic::State>(
        std::vector<haptic::Zone>(zones, zone),
        haptic::StateOptions{.most_contacts = probe_->size(), .most_solids = std::max<std::size_t>(1, solids_.size())});
}

void TouchSetup::load_tool(const std::filesystem::path& beside)
{
    mesh::Mesh tool;
    options_.zone.averaging = haptic::Averaging::Patch;
    haptic::Smoothing ball = haptic::ball_of(k_default_radius), point;
    if (is_shape(options_.tool, "sphere", ball.radius)) {
        options_.zone.averaging = haptic::Averaging::Ball;
        options_.zone.smoothing = ball;
        tool.vertices = haptic::stencil_points(ball);
    } else if (is_shape(options_.tool, "point", point.radius)) {
        options_.zone.averaging = haptic::Averaging::Stencil;
        options_.zone.smoothing = point;
        tool.vertices = haptic::stencil_points(point);
        point_ = std::make_unique<query::Probe>(std::vector<Vec3d>{{}});
    } else {
        LoadedMesh loaded = load_mesh(found(options_.tool, beside), {.accept_surface = true});
        if (loaded.refused()) throw BadTouch(options_.tool + ": " + report(loaded));
        tool = std::move(loaded.mesh);
        // Turned about the centre of its surface, and as large as asked.
        const Vec3d centre = mesh::normalization_of(tool).origin;
        const double scale = options_.tool_size / mesh::largest_vertex_distance(tool);
        for (Vec3d& v : tool.vertices) v = scale * (v - centre);
        haptic::PatchPoints patch = haptic::patch_points(tool.vertices, tool.triangles, options_.tool_spacing);
        tool.vertices = std::move(patch.points);
        weights_ = std::move(patch.weights);
    }
    const bool patch = options_.zone.averaging == haptic::Averaging::Patch;
    if (options_.zone.layer == query::Layer::Auto) options_.zone.layer = patch ? query::Layer::Three : query::Layer::Exact;
    const std::uint64_t hash = hash_of(tool.vertices);
    if (options_.tool_hash != 0 && options_.tool_hash != hash)
        throw BadTouch(options_.tool + " is not the tool that was recorded: its hash is " + hex(hash) + ", the trace has " +
                       hex(options_.tool_hash));
    options_.tool_hash = hash;
    probe_ = std::make_unique<query::Probe>(tool.vertices);
}

void TouchSetup::step(device::TraceRow& row) noexcept
{
    haptic::StepInput input{.solids = solids_, .poses = {row.poses.data(), zones_}, .twists = {}, .dt = row.dt};
    if ((row.input & device::k_trace_measured_twist) != 0) input.twists = {row.twists.data(), zones_};
    input.degraded = (row.input & device::k_trace_degraded) != 0;
    const haptic::StepResult result = haptic::step(*state_, input, {row.computed.data(), zones_});
    row.contacts = result.contacts;
    row.depth = result.deepest;
    row.status = result.status;
}

double softest_spring(const TouchOptions& o)
{
    double k = o.zone.stiffness;
    // A mesh feels its mean depth, which grows more slowly than it is pressed in while the patch still widens.
    if (o.zone.averaging == haptic::Averaging::Patch) k *= 0.25;
    if (o.zone.mode == haptic::Mode::Coupled && k > 0)  // one after the other
        k = k * o.zone.coupling_stiffness / (k + o.zone.coupling_stiffness);
    if (o.material.friction == haptic::Friction::Coulomb) k = std::min(k, o.zone.tangential_stiffness);
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
    each_number(o, [&](const char* name, double value) { out[name] = value; });
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
        // A trace from before a number was there has what was done then.
        each_number(o, [&](const char* name, double& value) {
            if (name != std::string_view("tool_spacing") || in.contains(name)) value = in.at(name);
        });
        return o;
    } catch (const ordered_json::exception& e) {
        throw BadTouch(std::string("the trace's setup does not read: ") + e.what());
    } catch (const std::out_of_range&) {
        throw BadTouch("the trace's setup names a mode, shading, layer or friction that this program does not have");
    }
}

void add_force_options(CLI::App& command, TouchOptions& o)
{
    const std::string group = "Forces";
    const auto number = [&](const char* name, double& value, const char* words) {
        command.add_option(name, value, words)->check(not_below_zero(1e6))->group(group)->capture_default_str();
    };
    const auto choice = [&](const char* name, auto& value, const auto& names, const char* words, const char* type) {
        command.add_option(name, value, words)
            ->transform(CLI::CheckedTransformer(names, CLI::ignore_case))
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
    number("--blend", o.zone.blend_time, "s in which a jump of the foot point fades to 1/e; 0: jumps pass");
    number("--zone", o.zone_radius, "Impact zone of a mesh: m about its centre that count; 0: the whole tool");
}

}  // namespace sqmap::app
