#include "viewer/server/protocol/messages.h"

#include "common/layer_name.h"
#include "viewer/server/protocol/text.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::viewer {
namespace {

using nlohmann::json;

// The names of garments and fabrics. "none" is not among them, since nothing would be fitted.
constexpr std::array<const char*, 3> k_garments{"shirt", "skirt", "poncho"};
constexpr std::array<const char*, 5> k_fabrics{"cotton", "silk", "denim", "wool", "leather"};
constexpr std::string_view k_layer_of_tool = "tool";
constexpr std::array<const char*, 3> k_projector_names{"newton", "pyramid", "printed"};  // in the order of paper::Projector
constexpr std::array<const char*, 3> k_friction_names{"none", "coulomb", "paper"};       // in the order of Friction

/// Reads a finite number of a range; false where there is none.
bool number(const json& in, const char* key, double least, double max, double& out)
{
    const auto at = in.find(key);
    if (at == in.end() || !at->is_number()) return false;
    const double value = at->get<double>();
    if (!std::isfinite(value) || value < least || value > max) return false;
    out = value;
    return true;
}

bool index(const json& in, const char* key, std::uint32_t& out, std::uint32_t max = 0xffff)
{
    const auto at = in.find(key);
    if (at == in.end() || !at->is_number_unsigned()) return false;
    const auto value = at->get<std::uint64_t>();
    if (value > max) return false;
    out = static_cast<std::uint32_t>(value);
    return true;
}

bool flag(const json& in, const char* key, bool& out)
{
    const auto at = in.find(key);
    if (at == in.end() || !at->is_boolean()) return false;
    out = at->get<bool>();
    return true;
}

/// Reads one of a list of words, as its number in the list.
template <std::size_t N>
bool one_of(const json& in, const char* key, const std::array<const char*, N>& words, std::size_t& out)
{
    const auto at = in.find(key);
    if (at == in.end() || !at->is_string()) return false;
    const auto& word = at->get_ref<const std::string&>();
    out = static_cast<std::size_t>(std::find(words.begin(), words.end(), word) - words.begin());
    return out < N;
}

/// Reads a position within 100 m of the origin.
bool position(const json& in, Vec3d& out)
{
    const auto at = in.find("p");
    const std::optional<Vec3d> position = at != in.end() ? vector_in(*at, 100) : std::nullopt;
    out = position.value_or(out);
    return position.has_value();
}

/// Reads [triangle, u, v].
bool cloth_point(const json& p, ClothPoint& out)
{
    if (!p.is_array() || p.size() != 3 || !p[0].is_number_unsigned() || !p[1].is_number() || !p[2].is_number()) return false;
    if (p[0].get<std::uint64_t>() > 10'000'000) return false;
    out = {p[0].get<std::uint32_t>(), p[1].get<double>(), p[2].get<double>()};
    return out.u >= 0 && out.v >= 0 && out.u <= 1 && out.v <= 1;
}

bool line(const json& in, std::vector<ClothPoint>& out)
{
    const auto all = in.find("line");
    if (all == in.end() || !all->is_array() || all->size() < 2 || all->size() > k_max_line) return false;
    for (const json& p : *all)
        if (!cloth_point(p, out.emplace_back())) return false;
    return true;
}

bool read_touch(const json& in, Message& m) { return flag(in, "held", m.held) && position(in, m.target) && in.size() == 3; }

bool read_name(const json& in, Message& m)
{
    const auto name = in.find("name");
    if (name == in.end() || !name->is_string() || !index(in, "object", m.object) || !index(in, "part", m.part) || in.size() != 4)
        return false;
    m.name = name->get<std::string>();
    return m.name.empty() || is_name(m.name);
}

bool read_rename(const json& in, Message& m)
{
    const auto name = in.find("name");
    if (name == in.end() || !name->is_string() || !index(in, "object", m.object) || in.size() != 3) return false;
    m.name = name->get<std::string>();
    return is_name(m.name);
}

bool read_turn(const json& in, Message& m)
{
    const auto up = in.find("up");
    if (up == in.end() || !up->is_string() || !index(in, "object", m.object) || in.size() != 3) return false;
    const std::optional<Up> axis = up_named(up->get_ref<const std::string&>());
    m.up = axis.value_or(m.up);
    return axis.has_value();
}

bool read_fit(const json& in, Message& m)
{
    std::size_t garment = 0, fabric = 0;
    if (!one_of(in, "garment", k_garments, garment) || !one_of(in, "fabric", k_fabrics, fabric) || !flag(in, "walks", m.walks) ||
        in.size() != 4)
        return false;
    m.garment = k_garments[garment];
    m.fabric = k_fabrics[fabric];
    return true;
}

bool read_cloth(const json& in, Message& m)
{
    static constexpr std::array<const char*, 9> k_handlings{"grasp", "drag", "release", "pin",    "unpin",
                                                            "cut",   "sew",  "slit",    "restart"};
    std::size_t which = 0;
    if (!one_of(in, "do", k_handlings, which)) return false;
    m.handling = static_cast<Handling>(which);
    switch (m.handling) {
        case Handling::Grasp:
        case Handling::Drag:
        case Handling::Pin:
            return position(in, m.target) && in.size() == 3;
        case Handling::Cut:
        case Handling::Sew:
            return index(in, "seam", m.part) && in.size() == 3;
        case Handling::Slit:
            return line(in, m.line) && in.size() == 3;
        default:
            return in.size() == 2;
    }
}

/// Reads "ball", "hand", or the number of an object in the scene.
bool read_tool(const json& in, Settings& s)
{
    const auto tool = in.find("tool");
    if (tool == in.end()) return false;
    if (tool->is_string()) {
        const auto& name = tool->get_ref<const std::string&>();
        if (name != "ball" && name != "hand") return false;
        s.tool = name == "ball" ? ToolKind::Ball : ToolKind::Hand;
    } else {
        if (!index(in, "tool", s.tool_object)) return false;
        s.tool = ToolKind::Mesh;
    }
    if (in.contains("edges") && !flag(in, "edges", s.edges)) return false;  // older recordings have none
    return number(in, "toolSize", 0.01, 0.3, s.tool_size) && number(in, "toolTurn", -180, 180, s.tool_turn) &&
           number(in, "toolTilt", -180, 180, s.tool_tilt);
}

/// Reads how the paper's maps are read. Recordings from before there were these settings have none of them: the defaults.
bool read_paper(const json& in, Settings& s)
{
    if (!in.contains("projector")) return true;
    std::size_t projector = 0;
    std::uint32_t steps = 0;
    if (!one_of(in, "projector", k_projector_names, projector) || !index(in, "nearestSteps", steps) ||
        !option_named(paper::k_query_numbers, "nearest_steps").range.holds(steps) || !flag(in, "gaps", s.paper.gaps) ||
        !flag(in, "pruning", s.paper.pruning) || !index(in, "gate", s.gate) || s.gate > 1000 || !flag(in, "offset", s.offset))
        return false;
    s.paper.projector = static_cast<paper::Projector>(projector);
    s.paper.nearest_steps = static_cast<int>(steps);
    return true;
}

/// Reads "tool", which leaves the layer to the tool, or a layer's name.
bool read_layer(const json& in, Settings& s)
{
    const auto layer = in.find("layer");
    if (layer == in.end() || !layer->is_string()) return false;
    if (*layer == k_layer_of_tool) return true;
    s.layer = app::layer_named(layer->get_ref<const std::string&>());
    return s.layer && *s.layer != query::Layer::One;
}

}  // namespace

const char* name_of(Up up) noexcept
{
    constexpr const char* k_names[] = {"x", "y", "z"};
    return k_names[static_cast<std::size_t>(up)];
}

std::optional<Up> up_named(std::string_view name) noexcept
{
    for (const Up up : {Up::X, Up::Y, Up::Z})
        if (name == name_of(up)) return up;
    return std::nullopt;
}

nlohmann::ordered_json settings_json(const Settings& s)
{
    using nlohmann::ordered_json;
    return {{"layer", s.layer ? app::layer_name(*s.layer) : k_layer_of_tool},
            {"tolerance", s.tolerance},
            {"paperForce", s.paper_force},
            {"proxy", s.proxy},
            {"stiffness", s.stiffness},
            {"damping", s.damping},
            {"law", k_friction_names[static_cast<std::size_t>(s.law)]},
            {"friction", s.friction},
            {"fC", s.f_c},
            {"kF", s.k_f},
            {"texture", s.texture},
            {"smoothing", s.smoothing},
            {"toolRadius", s.tool_radius},
            {"zone", s.zone},
            {"forceLimit", s.force_limit},
            {"projector", k_projector_names[static_cast<std::size_t>(s.paper.projector)]},
            {"nearestSteps", s.paper.nearest_steps},
            {"gaps", s.paper.gaps},
            {"pruning", s.paper.pruning},
            {"gate", s.gate},
            {"offset", s.offset},
            {"edges", s.edges},
            {"tool", s.tool == ToolKind::Ball   ? ordered_json("ball")
                     : s.tool == ToolKind::Hand ? ordered_json("hand")
                                                : ordered_json(s.tool_object)},
            {"toolSize", s.tool_size},
            {"toolTurn", s.tool_turn},
            {"toolTilt", s.tool_tilt}};
}

bool read_settings(const json& in, Settings& s)
{
    std::size_t law = 0;
    if (!read_layer(in, s) || !one_of(in, "law", k_friction_names, law) || !flag(in, "paperForce", s.paper_force) ||
        !flag(in, "proxy", s.proxy))
        return false;
    s.law = static_cast<Friction>(law);
    return number(in, "tolerance", 0, 0.01, s.tolerance) && number(in, "stiffness", 0, 2000, s.stiffness) &&
           number(in, "damping", 0, 5, s.damping) && number(in, "friction", 0, 1.5, s.friction) &&
           number(in, "fC", 0, 2, s.f_c) && number(in, "kF", 0, 1000, s.k_f) && number(in, "texture", 0, 0.001, s.texture) &&
           number(in, "smoothing", 0, 0.01, s.smoothing) && number(in, "toolRadius", 0.001, 0.05, s.tool_radius) &&
           number(in, "zone", 0, 0.1, s.zone) && number(in, "forceLimit", 0.1, 3.3, s.force_limit) && read_tool(in, s) &&
           read_paper(in, s);
}

std::size_t settings_fields(const json& in) { return (in.contains("projector") ? 25 : 19) + (in.contains("edges") ? 1 : 0); }

std::optional<json> shallow_object(std::string_view text, int max_depth)
{
    if (text.find('\0') != std::string_view::npos) return std::nullopt;  // the parser would end there
    // A parser that descends into a thousand brackets would still build them all.
    bool deep = false;
    json in = json::parse(
        text,
        [&](int depth, json::parse_event_t event, json&) {
            const bool opens = event == json::parse_event_t::object_start || event == json::parse_event_t::array_start;
            if (opens && depth >= max_depth) deep = true;
            return !deep;
        },
        false);
    if (deep || in.is_discarded() || !in.is_object()) return std::nullopt;
    return in;
}

std::optional<Vec3d> vector_in(const json& in, double max)
{
    if (!in.is_array() || in.size() != 3) return std::nullopt;
    Vec3d out;
    for (int k = 0; k < 3; ++k) {
        const json& number = in[static_cast<std::size_t>(k)];
        if (!number.is_number() || !(std::abs(number.get<double>()) <= max)) return std::nullopt;
        out[k] = number.get<double>();
    }
    return out;
}

std::optional<Message> read_message(std::string_view text)
{
    const std::optional<json> object = shallow_object(text, 4);
    if (!object) return std::nullopt;
    const json& in = *object;
    const auto say = in.find("say");
    if (say == in.end() || !say->is_string()) return std::nullopt;
    const auto& name = say->get_ref<const std::string&>();
    Message m;
    const auto done = [&](Say kind, bool good) -> std::optional<Message> {
        m.say = kind;
        if (!good) return std::nullopt;
        return m;
    };
    if (name == "touch") return done(Say::Touch, read_touch(in, m));
    if (name == "settings") return done(Say::Settings, read_settings(in, m.settings) && in.size() == settings_fields(in) + 1);
    if (name == "take") return done(Say::Take, in.size() == 1);
    if (name == "rest") return done(Say::Rest, in.size() == 1);
    if (name == "cancel") return done(Say::Cancel, index(in, "upload", m.upload, 0xffffffff) && in.size() == 2);
    if (name == "stop") return done(Say::Stop, in.size() == 1);
    if (name == "resume") return done(Say::Resume, in.size() == 1);
    if (name == "record") return done(Say::Record, flag(in, "on", m.held) && in.size() == 2);
    if (name == "device") return done(Say::Device, index(in, "device", m.device) && in.size() == 2);
    if (name == "split") return done(Say::Split, index(in, "object", m.object) && index(in, "part", m.part) && in.size() == 3);
    if (name == "merge")
        return done(Say::Merge, index(in, "object", m.object) && index(in, "part", m.part) && index(in, "other", m.other) &&
                                    m.part != m.other && in.size() == 4);
    if (name == "movecut")
        return done(Say::MoveCut, index(in, "object", m.object) && index(in, "part", m.part) && index(in, "other", m.other) &&
                                      m.part != m.other && number(in, "distance", 0, 0.1, m.distance) && in.size() == 5);
    if (name == "refit") return done(Say::Refit, index(in, "object", m.object) && index(in, "part", m.part) && in.size() == 3);
    if (name == "name") return done(Say::Name, read_name(in, m));
    if (name == "restore") return done(Say::Restore, in.size() == 1);
    if (name == "hide") return done(Say::Hide, index(in, "object", m.object) && flag(in, "on", m.held) && in.size() == 3);
    if (name == "move") return done(Say::Move, index(in, "object", m.object) && position(in, m.target) && in.size() == 3);
    if (name == "turn") return done(Say::Turn, read_turn(in, m));
    if (name == "rename") return done(Say::Rename, read_rename(in, m));
    if (name == "fit") return done(Say::Fit, read_fit(in, m));
    if (name == "cloth") return done(Say::Cloth, read_cloth(in, m));
    if (name == "undress") return done(Say::Undress, in.size() == 1);
    const std::array<std::pair<const char*, Say>, 5> of_object{
        {{"undo", Say::Undo}, {"redo", Say::Redo}, {"bake", Say::Bake}, {"rebake", Say::Rebake}, {"remove", Say::Remove}}};
    const auto at = std::find_if(of_object.begin(), of_object.end(), [&](const auto& known) { return name == known.first; });
    if (at == of_object.end()) return std::nullopt;
    return done(at->second, index(in, "object", m.object) && in.size() == 2);
}

}  // namespace sqmap::viewer
