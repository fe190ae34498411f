#include "touch/options.h"

#include "common/hash_text.h"
#include "touch/names.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::app {
namespace {

using nlohmann::ordered_json;

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

/// Visits the numbers that older traces do not have: their defaults are how such a trace was made.
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

/// @throw BadTouch
std::uint64_t hash_in(const ordered_json& text)
{
    const std::optional<std::uint64_t> hash = hash_from(text.get<std::string>());
    if (!hash) throw BadTouch("'" + text.get<std::string>().substr(0, 20) + "' is no hash");
    return *hash;
}

}  // namespace

std::filesystem::path found(const std::string& file, const std::filesystem::path& beside)
{
    std::error_code ignored;
    const std::filesystem::path other = beside / std::filesystem::path(file).filename();
    if (!beside.empty() && !std::filesystem::exists(file, ignored) && std::filesystem::exists(other, ignored)) return other;
    return file;
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
                                  {"hash", hash_text(object.hash)},
                                  {"projection", object.projection},
                                  {"metres_per_unit", object.metres_per_unit},
                                  {"place", {object.position.x, object.position.y, object.position.z}}});
    out["tool"] = o.tool;
    out["tool_hash"] = hash_text(o.tool_hash);
    out["mode"] = name_of(k_modes, o.zone.mode);
    out["shading"] = name_of(k_shadings, o.zone.shading);
    out["layer"] = name_of(k_touch_layers, o.zone.layer);
    out["force"] = name_of(k_forces, o.paper_force);
    out["projector"] = name_of(k_projectors, o.paper.projector);
    out["offset"] = o.zone.offset;
    out["gate"] = o.zone.gate;
    out["nearest_steps"] = o.paper.nearest_steps;
    out["gaps"] = o.paper.gaps;
    out["pruning"] = o.paper.pruning;
    out["friction"] = name_of(k_frictions, o.material.friction);
    out["kernel"] = name_of(k_kernels, o.kernel);
    out["texture"] = o.texture.kind;
    out["texture_seed"] = o.texture.seed;
    out["texture_hash"] = hash_text(o.texture_hash);
    out["edges"] = o.edges;
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
            const auto position = object.at("place").get<std::array<double, 3>>();
            o.objects.push_back({.file = object.at("file"),
                                 .position = {position[0], position[1], position[2]},
                                 .metres_per_unit = object.at("metres_per_unit"),
                                 .hash = hash_in(object.at("hash"))});
        }
        if (o.objects.empty()) throw BadTouch("the trace's setup has no object");
        o.tool = in.at("tool");
        o.tool_hash = hash_in(in.at("tool_hash"));
        o.zone.mode = k_modes.at(in.at("mode"));
        o.zone.shading = k_shadings.at(in.at("shading"));
        o.zone.layer = k_touch_layers.at(in.at("layer"));
        o.material.friction = k_frictions.at(in.at("friction"));
        each_number(o, [&](const char* name, double& value) { value = in.at(name); });
        // A trace from before something was there has what was done then.
        each_later_number(o, [&](const char* name, double& value) { value = in.value(name, value); });
        if (in.contains("force")) o.paper_force = k_forces.at(in.at("force"));
        if (in.contains("projector")) o.paper.projector = k_projectors.at(in.at("projector"));
        o.zone.offset = in.value("offset", o.zone.offset);
        o.zone.gate = in.value("gate", o.zone.gate);
        o.paper.nearest_steps = in.value("nearest_steps", o.paper.nearest_steps);
        if (const std::string wrong = out_of_range(paper::k_query_numbers, o.paper); !wrong.empty())
            throw BadTouch("the trace's setup: " + wrong + "\n  cure: mend the number in the line '# setup'");
        o.paper.gaps = in.value("gaps", o.paper.gaps);
        o.paper.pruning = in.value("pruning", o.paper.pruning);
        if (in.contains("kernel")) o.kernel = k_kernels.at(in.at("kernel"));
        o.texture.kind = in.value("texture", o.texture.kind);
        o.texture.seed = in.value("texture_seed", o.texture.seed);
        o.edges = in.value("edges", o.edges);
        if (in.contains("texture_hash")) o.texture_hash = hash_in(in.at("texture_hash"));
        check(o, "the trace's setup: ");
        return o;
    } catch (const ordered_json::exception& e) {
        const std::string why = e.what();  // "[json.exception...] why"
        throw BadTouch("the trace's setup does not read: " + why.substr(std::min(why.find("] ") + 2, why.size())) +
                       "\n  cure: record again, or mend its line '# setup'");
    } catch (const std::out_of_range&) {
        throw BadTouch(
            "the trace's setup names a mode, shading, force, projector, kernel, layer or friction that this program does not "
            "have");
    }
}

}  // namespace sqmap::app
