#include "touch/setup.h"

#include "common/hash_text.h"
#include "common/program_words.h"
#include "sqmap/paper/model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

namespace sqmap::app {

TouchSetup::TouchSetup(const TouchOptions& options, std::size_t zones, const std::filesystem::path& beside)
    : options_(options), zones_(zones)
{
    models_.reserve(options_.objects.size());
    views_.reserve(options_.objects.size());
    for (TouchObject& object : options_.objects) {
        paper::MappedModel& model = models_.emplace_back(found(object.file, beside));
        model.set_options(options_.paper);
        const model::ModelView& view = model.view();
        const std::uint64_t hash = paper::content_hash(view);
        if (object.hash != 0 && object.hash != hash)
            throw BadTouch(object.file + " is not the model that was recorded: its content hash is " + hash_text(hash) +
                           ", the trace has " + hash_text(object.hash) + "\n  cure: bring that model, or compare with --against");
        if (options_.paper_force && !paper::is_paper(view))
            throw BadTouch(object.file +
                           " has the central projection: the paper's force is that of its own maps\n  cure: bake it with "
                           "--projection normal, or --force full");
        if (options_.paper_force && !paper::has_smoothed_map(view))
            notes_.push_back("warning: " + object.file +
                             " was baked with --smoothing-radius 0: the force is that of the unsmoothed map");
        object.hash = hash;
        object.projection = paper::is_paper(view) ? "normal" : "central";
        if (!(object.metres_per_unit > 0) || !std::isfinite(object.metres_per_unit))
            throw BadTouch(object.file + ": metres a unit must be above zero");
        views_.push_back(haptic::in_metres(view, object.metres_per_unit));
        const model::Header& h = views_.back().header;
        solids_.push_back(
            {.pose = {{}, object.position - Vec3d{h.origin[0], h.origin[1], h.origin[2]}}, .material = options_.material});
    }
    for (std::size_t i = 0; i < solids_.size(); ++i) solids_[i].model = &views_[i];
    texture_ = make_texture(options_.texture, beside);
    if (options_.texture_hash != 0 && options_.texture_hash != texture_.hash)
        throw BadTouch("--texture " + options_.texture.kind + " is not the texture that was recorded: its hash is " +
                       hash_text(texture_.hash) + ", the trace has " + hash_text(options_.texture_hash));
    options_.texture_hash = texture_.hash;
    if (texture_.texture.n > 0)
        for (haptic::TouchedBody& solid : solids_) solid.material.texture = &texture_.texture;
    objects_ = MovingObjects(options_, solids_);
    pushes_.resize(solids_.size());
    load_tool(beside);
    warn_of_idle_reading();
    state_ = std::make_unique<haptic::State>(tool_.state(solids_.size()));
    for (std::size_t z = 0; z < zones_; ++z) state_->options(z) = options_of(z);
}

void TouchSetup::warn_of_idle_reading()
{
    for (std::size_t i = 0; i < views_.size(); ++i) {
        query::QueryOptions chosen{.layer = options_.zone.layer, .gate = options_.zone.gate, .offset = options_.zone.offset};
        chosen.layer = query::chosen_layer(views_[i], chosen);
        if (const auto idle = paper::idle_option(options_.paper, paper::is_paper(views_[i]), chosen))
            notes_.push_back("warning: " + options_.objects[i].file + ": " + option_of(*idle) + " " + reason_of(*idle));
    }
}

/// How far a finger is closed follows from how its tip lies: a torque there would bend it, and the loop would swing.
haptic::ZoneOptions TouchSetup::options_of(std::size_t zone) const
{
    haptic::ZoneOptions o = options_.zone;
    if (hand_ && zone + 1 < zones_) o.torque_share = 0;
    return o;
}

query::Probe TouchSetup::tool_at(std::span<const sqmap::Pose> zones) const
{
    if (hand_) return query::Probe(tool_.points());
    std::vector<Vec3d> points;
    for (const sqmap::Pose& zone : zones)
        for (const Vec3d& p : tool_.points()) points.push_back(zone.rotation * p + zone.translation);
    return query::Probe(points);
}

void TouchSetup::suit(const haptic::DeviceLimits* device)
{
    haptic::ZoneOptions& zone = options_.zone;
    const CouplingWishes& w = options_.coupling;
    const bool mesh = zone.averaging == haptic::Averaging::Patch, coupled = zone.mode == haptic::Mode::Coupled;
    zone.inertia = w.inertia.value_or(mesh && reach_ > 0 ? 0.4 * zone.mass * reach_ * reach_ : zone.inertia);
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
        const double max = haptic::check_stiffness(*device, zone.stiffness, zone.damping + zone.brake).largest;
        if (!coupled && !options_.stiffness_wished && max > 0 && max < zone.stiffness) {
            zone.stiffness = max;
            char text[100];
            std::snprintf(text, sizeof text, "stiffness %.0f N/m: as much as this device shows without ever giving energy", max);
            notes_.push_back(text);
        }
        if (coupled) {
            if (!w.stiffness) zone.coupling_stiffness = 1e6;  // as stiff as the device carries
            haptic::choose_coupling(zone, *device);
            if (w.stiffness && zone.coupling_stiffness < *w.stiffness) {
                char text[200];
                std::snprintf(text, sizeof text, "warning: --coupling-stiffness %g: this device carries %.0f N/m; more may swing",
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

void TouchSetup::step(device::TraceRow& row) noexcept
{
    objects_.move(row.dt, pushes_, solids_);
    // A zone without a pose has no force, and the hand stays as it was.
    const auto finite = [](const sqmap::Pose& p) {
        return std::isfinite(norm_sq(p.translation) + norm_sq(p.rotation.row[0]) + norm_sq(p.rotation.row[1]) +
                             norm_sq(p.rotation.row[2]));
    };
    if (hand_ && std::all_of(row.poses.begin(), row.poses.begin() + device::k_glove_zones, finite)) {
        hand_->pose(std::span<const sqmap::Pose, device::k_glove_zones>(row.poses.data(), device::k_glove_zones));
        tool_.probe().move(hand_->points());
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

}  // namespace sqmap::app
