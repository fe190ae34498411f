#include "touch/over_model.h"

#include "sqmap/device/path.h"
#include "three_numbers.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>
#include <string_view>

namespace sqmap::app {
namespace {

const std::map<std::string, device::Script> k_scripts{{"press", device::Script::Press},
                                                      {"tap", device::Script::Tap},
                                                      {"slide", device::Script::Slide},
                                                      {"circle", device::Script::Circle}};

constexpr double k_wait = 0.6, k_long = 2;  // s that scripts of so long wait for the safety filter's ramp

Vec3d vector_option(const device::DeviceSpec& spec, const char* name, Vec3d otherwise)
{
    if (std::none_of(spec.options.begin(), spec.options.end(), [&](const auto& o) { return o.first == name; })) return otherwise;
    const std::string text = spec.text(name, "");
    // Commas part options, so a direction is written with blanks or slashes between its numbers.
    const std::optional<Vec3d> v = three_numbers(text, "/ ");
    if (!v)
        throw device::DeviceError(spec.kind + ": " + name + " is three numbers with slashes between them, as in 0/0/1, found '" +
                                  text + "'");
    if (!std::isnormal(norm_sq(*v)))
        throw device::DeviceError(spec.kind + ": " + name + "=" + text +
                                  " points nowhere\n  cure: numbers that are not all 0, as in 0/0/1, or leave it out");
    return *v;
}

/// Refuses options that a script has no use for, instead of passing over them.
void allow(const device::DeviceSpec& spec, device::Script script, bool simulated)
{
    std::vector<std::string_view> names{"speed", "depth", "gap", "direction", "rate", "wait"};
    if (script == device::Script::Slide || script == device::Script::Circle) names.push_back("travel");
    if (script == device::Script::Circle) names.push_back("radius");
    if (simulated) names.insert(names.end(), {"hand", "delay"});
    spec.allow(names);
}

/// Poses in the world, of press, tap, slide or circle.
std::vector<sqmap::Pose> scripted_poses(const device::DeviceSpec& spec, device::Script script, const TouchSetup& setup,
                                        double seconds, double& rate)
{
    device::ScriptOptions o;
    o.seconds = seconds;
    o.rate = rate = spec.number("rate", o.rate, 60, 1e4);  // below, every tick comes as late as silence
    o.speed = spec.number("speed", o.speed, 1e-5, 10);
    o.depth = spec.number("depth", o.depth, -1, 1);
    o.gap = spec.number("gap", o.gap, -1, 1);
    o.wait = spec.number("wait", seconds >= k_long ? k_wait : 0, 0, 1e3);
    if (!(o.gap + o.depth > 0)) {
        char text[200];
        std::snprintf(text, sizeof text,
                      "%s: depth=%g lies above gap=%g from where it starts: nothing would move\n  cure: a depth + gap above 0",
                      spec.kind.c_str(), o.depth, o.gap);
        throw device::DeviceError(text);
    }
    o.radius = spec.number("radius", o.radius, 1e-5, 1);
    o.direction = vector_option(spec, "direction", o.direction);
    o.travel = vector_option(spec, "travel", o.travel);
    if (const double needed = device::script_needs(script, o); needed > seconds)
        std::printf("  warning: %.4g s are too short for all of this script: at least %.4g s, of which it waits %.4g s (wait=)\n",
                    seconds, needed, o.wait);
    std::vector<sqmap::Pose> poses = device::scripted_path(setup.first_model(), setup.tool(), script, o);
    for (sqmap::Pose& pose : poses) pose = sqmap::compose(setup.first_pose(), pose);
    return poses;
}

}  // namespace

bool is_over_model(const std::string& kind) { return k_scripts.contains(kind) || kind == "simulated" || kind == "glove"; }

std::unique_ptr<device::Device> device_over(const device::DeviceSpec& spec, const TouchSetup& setup, double seconds,
                                            HandPath& hand)
{
    if (const auto script = k_scripts.find(spec.kind); script != k_scripts.end()) {
        spec.only_named();
        allow(spec, script->second, false);
        double rate = 0;
        std::vector<sqmap::Pose> poses = scripted_poses(spec, script->second, setup, seconds, rate);
        return std::make_unique<device::PathDevice>("scripted " + spec.kind, std::move(poses), rate);
    }
    if (spec.kind == "glove") {
        // The palm sways about the top of the object, along z, while the fingers open and close.
        spec.only_named();
        spec.allow({"sway", "curl", "length"});
        hand.glove.sway = {0, 0, spec.number("sway", hand.glove.sway.z, 0, 1)};
        hand.glove.curl = spec.number("curl", hand.glove.curl, 0, 1.5);
        hand.glove.length = setup.options().hand_length;
        // From a millimetre above where the first zone would touch: the filter gives no force to one that begins inside.
        const Vec3d wrist{0, -0.45 * hand.glove.length, 0};
        hand.glove.wrist.translation = wrist;
        const auto zones = device::glove_zones(device::hand_joints(device::posture_at(hand.glove, 0), hand.glove.length));
        const std::vector<sqmap::Pose> top =
            device::scripted_path(setup.first_model(), setup.tool_at(zones), device::Script::Press,
                                  {.seconds = 1, .depth = 1e-6, .gap = 0.001, .direction = {0, 0, 1}});
        hand.glove.wrist.translation = top.front().translation + setup.first_pose().translation + wrist;
        return device::simulated_glove(hand.glove);
    }
    const auto script = k_scripts.find(spec.first.empty() ? "press" : spec.first);
    if (script == k_scripts.end())
        throw device::DeviceError("simulated: a hand can press, tap, slide or circle, not '" + spec.first + "'");
    allow(spec, script->second, true);
    hand.poses = scripted_poses(spec, script->second, setup, seconds, hand.rate);
    device::SimulatedOptions options{.script = HandPath::at, .script_context = &hand};
    options.mechanism.delay_ticks = spec.whole("delay", options.mechanism.delay_ticks, 0, 8);
    options.hand = device::hand_profile(spec.text("hand", options.hand.name));
    return std::make_unique<device::SimulatedDevice>(options);
}

}  // namespace sqmap::app
