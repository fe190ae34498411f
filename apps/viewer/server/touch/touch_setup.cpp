#include "viewer/server/touch/touch_setup.h"

#include "common/tool_name.h"
#include "sqmap/device/trace.h"
#include "viewer/server/protocol/text.h"

#include <optional>
#include <string>

namespace sqmap::viewer {
namespace {

using nlohmann::json;

[[noreturn]] void cannot_show(const char* why)
{
    throw device::TraceError(std::string(why) + "\n  cure: sqmap replay computes it again");
}

/// A setting of the page, and its name in a setup.
struct SameSetting {
    const char *page, *setup;
    bool in_all = true;  ///< false: old setups lack it, and the page's default stands
};
constexpr SameSetting k_same[] = {{"layer", "layer"},
                                  {"stiffness", "stiffness"},
                                  {"damping", "damping"},
                                  {"law", "friction"},
                                  {"fC", "f_c"},
                                  {"kF", "k_f"},
                                  {"friction", "mu_dynamic"},
                                  {"projector", "projector", false},
                                  {"gaps", "gaps", false},
                                  {"pruning", "pruning", false},
                                  {"gate", "gate", false},
                                  {"offset", "offset", false},
                                  {"nearestSteps", "nearest_steps", false}};

}  // namespace

Settings settings_of(const json& setup)
{
    const auto value = [&](const char* key) { return setup.value(key, json()); };
    for (const char* key : {"object_mass", "sway_x", "sway_y", "sway_z"})
        if (const json moves = value(key); moves.is_number() && moves.get<double>() != 0)
            cannot_show("its objects move, those of the page stand still");
    if (value("mode") == "coupled") cannot_show("its tool is coupled, which the page has not");
    Settings out;
    json in = json::parse(text_of(settings_json(out)));  // numbers as a parser has them
    const std::string tool = value("tool").is_string() ? value("tool").get<std::string>() : "";
    if (const std::optional<double> radius = app::tool_radius(tool, "sphere", app::k_tool_radius))
        in["toolRadius"] = *radius;
    else if (const std::optional<double> smoothing = app::tool_radius(tool, "point", haptic::Smoothing{}.radius))
        in["smoothing"] = *smoothing;
    else
        cannot_show("its tool is neither sphere nor point");
    in["proxy"] = value("mode") == "proxy";
    in["paperForce"] = value("force") == "paper";
    for (const SameSetting& same : k_same)
        if (same.in_all || setup.contains(same.setup)) in[same.page] = value(same.setup);
    if (!read_settings(in, out)) cannot_show("its setup has numbers that the page's settings do not reach");
    return out;
}

}  // namespace sqmap::viewer
