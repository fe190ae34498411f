#include "messages.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::viewer {
namespace {

using nlohmann::json;

/// A number in its range.
bool number(const json& in, const char* key, double least, double most, double& out)
{
    const auto at = in.find(key);
    if (at == in.end() || !at->is_number()) return false;
    const double value = at->get<double>();
    if (!std::isfinite(value) || value < least || value > most) return false;
    out = value;
    return true;
}

bool index(const json& in, const char* key, std::uint32_t& out)
{
    const auto at = in.find(key);
    if (at == in.end() || !at->is_number_unsigned()) return false;
    const auto value = at->get<std::uint64_t>();
    if (value > 0xffff) return false;
    out = static_cast<std::uint32_t>(value);
    return true;
}

bool read_touch(const json& in, Message& m)
{
    const auto held = in.find("held"), p = in.find("p");
    if (held == in.end() || !held->is_boolean() || p == in.end() || !p->is_array() || p->size() != 3) return false;
    m.held = held->get<bool>();
    for (int i = 0; i < 3; ++i) {
        const json& c = (*p)[static_cast<std::size_t>(i)];
        if (!c.is_number()) return false;
        m.target[i] = c.get<double>();
        if (!(std::abs(m.target[i]) <= 100)) return false;
    }
    return in.size() == 3;
}

bool read_settings(const json& in, Settings& s)
{
    const auto layer = in.find("layer");
    if (layer == in.end() || !layer->is_string()) return false;
    const auto& name = layer->get_ref<const std::string&>();
    if (name == "2")
        s.layer = query::Layer::Two;
    else if (name == "3")
        s.layer = query::Layer::Three;
    else if (name == "exact")
        s.layer = query::Layer::Exact;
    else
        return false;
    return number(in, "stiffness", 0, 2000, s.stiffness) && number(in, "damping", 0, 5, s.damping) &&
           number(in, "friction", 0, 1.5, s.friction) && number(in, "texture", 0, 0.001, s.texture) &&
           number(in, "smoothing", 0, 0.01, s.smoothing) && number(in, "toolRadius", 0.001, 0.05, s.tool_radius) &&
           number(in, "zone", 0, 0.1, s.zone) && number(in, "forceLimit", 0.1, 3.3, s.force_limit) && in.size() == 10;
}

}  // namespace

std::optional<Message> read_message(std::string_view text)
{
    if (text.find('\0') != std::string_view::npos) return std::nullopt;  // the parser would end there
    // A parser that descends into a thousand brackets would still build them all.
    bool deep = false;
    const json in = json::parse(
        text,
        [&](int depth, json::parse_event_t event, json&) {
            const bool opens = event == json::parse_event_t::object_start || event == json::parse_event_t::array_start;
            if (opens && depth >= 4) deep = true;
            return !deep;
        },
        false);
    if (deep || in.is_discarded() || !in.is_object()) return std::nullopt;
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
    if (name == "settings") return done(Say::Settings, read_settings(in, m.settings));
    if (name == "stop") return done(Say::Stop, in.size() == 1);
    if (name == "resume") return done(Say::Resume, in.size() == 1);
    if (name == "device") return done(Say::Device, index(in, "device", m.device) && in.size() == 2);
    if (name == "split") return done(Say::Split, index(in, "object", m.object) && index(in, "part", m.part) && in.size() == 3);
    if (name == "merge")
        return done(Say::Merge, index(in, "object", m.object) && index(in, "part", m.part) && index(in, "other", m.other) &&
                                    m.part != m.other && in.size() == 4);
    const std::array<std::pair<const char*, Say>, 5> of_object{
        {{"refit", Say::Refit}, {"undo", Say::Undo}, {"redo", Say::Redo}, {"bake", Say::Bake}, {"remove", Say::Remove}}};
    const auto at = std::find_if(of_object.begin(), of_object.end(), [&](const auto& known) { return name == known.first; });
    if (at == of_object.end()) return std::nullopt;
    return done(at->second, index(in, "object", m.object) && in.size() == 2);
}

}  // namespace sqmap::viewer
