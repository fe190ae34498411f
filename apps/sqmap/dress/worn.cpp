#include "dress/worn.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace sqmap::app {
namespace {

using nlohmann::json;

constexpr double k_began_inside = 0.005;                        ///< m
constexpr double k_deep_node = 0.002, k_deep_interior = 0.005;  ///< of the height: what a user would see

const char* status_text(std::uint32_t bit)
{
    switch (bit) {
        case sim::k_cloth_not_finite:
            return "not finite: put back to the step before";
        case sim::k_cloth_slowed:
            return "slowed to the greatest speed";
        case sim::k_cloth_full:
            return "more contacts than there is room for";
        case sim::k_cloth_coarse_sweep:
            return "thin parts may have been missed";
        case sim::k_cloth_crowded:
            return "the skin is folded more often at one point than is looked at";
        case sim::k_cloth_stretched:
            return "a quarter of the threads are stretched by more than 10 %: give a higher --rate or more --iterations";
        case sim::k_cloth_tangled:
            return "the cloth went through itself";
        default:
            return "bad step";
    }
}

/// Worries about the result, each with its cure.
std::vector<std::string> worries(const Worn& w, const sim::Penetration& end, double height, double time)
{
    std::vector<std::string> out = w.handling->never_came(time);
    char text[200];
    const auto add = [&](const char* format, auto... values) {
        if constexpr (sizeof...(values) > 0) {
            std::snprintf(text, sizeof text, format, values...);
            out.emplace_back(text);
        } else {
            out.emplace_back(format);
        }
    };
    if (w.began_inside > k_began_inside)
        add("began %.0f mm inside the body: start it clear of it (garment files are in metres, y up)", 1e3 * w.began_inside);
    if (w.max_contacts == 0) add("touched nothing: is it above the body, and of its size?");
    if (end.nodes > k_deep_node * height)
        add("a vertex is %.1f mm inside at the end, at %.3f %.3f %.3f", 1e3 * end.nodes, end.node_at.x, end.node_at.y,
            end.node_at.z);
    if (end.interiors > k_deep_interior * height)
        add("triangles are up to %.1f mm inside at the end, at %.3f %.3f %.3f: more vertices, or a thicker fabric",
            1e3 * end.interiors, end.interior_at.x, end.interior_at.y, end.interior_at.z);
    return out;
}

}  // namespace

void Worn::add(const sim::StepReport& r, double time)
{
    status |= r.status;
    caught += r.caught;
    max_contacts = std::max(max_contacts, r.contacts);
    drape.add(r, time);
    const double energy = r.kinetic + r.potential;
    if (std::isnan(start_energy)) start_energy = energy;
    max_energy = std::max(max_energy, energy);
    least_energy = std::min(least_energy, energy);
    const auto& s = r.seconds;
    for (const auto& [stage, seconds] : {std::pair{&predict, s.predict},
                                         {&move, s.move},
                                         {&query, s.query},
                                         {&response, s.response},
                                         {&threads, s.threads},
                                         {&self, s.self},
                                         {&collision, s.move + s.query}})
        stage->us.push_back(1e6 * seconds);
}

json Stage::summary()
{
    if (us.empty()) return nullptr;
    std::sort(us.begin(), us.end());
    return {{"mean", std::accumulate(us.begin(), us.end(), 0.0) / static_cast<double>(us.size())},
            {"median", us[us.size() / 2]},
            {"p99", us[us.size() * 99 / 100]}};
}

std::string text_of(const sim::DrapeReport& drape)
{
    char text[96];
    if (drape.at_rest)
        std::snprintf(text, sizeof text, "at rest after %.2f s", drape.since);
    else if (drape.fastest <= sim::Drape::k_slow)
        std::snprintf(text, sizeof text, "not yet at rest: slow for less than %.2f s at the end", sim::Drape::k_quiet);
    else
        std::snprintf(text, sizeof text, "did not come to rest: fastest vertex %u at %.2f m/s", drape.fastest_node,
                      drape.fastest);
    return text;
}

json report_of(Worn& w, double height, std::span<const sim::Collider> solids, double time)
{
    const sim::Penetration deep = sim::penetration(w.cloth.positions(), w.cloth.triangles(), solids, {.steps = 4});
    std::vector<double> strain = w.cloth.strain();
    json map = json::array();
    for (const double s : strain) map.push_back(std::round(1e4 * s) / 1e4);
    std::sort(strain.begin(), strain.end());
    json status = json::array();
    for (std::uint32_t bit = 1; bit <= sim::k_cloth_tangled; bit *= 2)
        if ((w.status & bit) != 0) status.push_back(status_text(bit));
    for (const std::string& line : worries(w, deep, height, time)) status.push_back(line);
    json seams = json::object();
    for (std::size_t s = 0; s < w.cloth.seams(); ++s) seams[w.file.garment.seams[s].name] = w.cloth.gap(s);
    const sim::DrapeReport& drape = w.drape.report();
    return {{"name", w.file.name},
            {"fabric", w.file.fabric_name},
            {"vertices", w.cloth.size()},
            {"triangles", w.cloth.triangles().size()},
            {"status", status},
            {"rest",
             {{"reached", drape.at_rest},
              {"status", text_of(drape)},
              {"since_s", drape.at_rest ? json(drape.since) : json(nullptr)},
              {"fastest_vertex", drape.fastest_node},
              {"speed_m_s", drape.fastest},
              {"threshold_m_s", w.drape.threshold()}}},
            {"penetration_at_end",
             {{"nodes_m", deep.nodes},
              {"interiors_m", deep.interiors},
              {"nodes_percent_of_height", 100 * deep.nodes / height},
              {"interiors_percent_of_height", 100 * deep.interiors / height},
              {"deepest_node_at", {deep.node_at.x, deep.node_at.y, deep.node_at.z}},
              {"deepest_interior_at", {deep.interior_at.x, deep.interior_at.y, deep.interior_at.z}}}},
            {"deepest_node_of_any_frame_m", w.deepest_walking},
            {"crossings_at_end", w.cloth.crossings()},
            {"caught_by_sweep", w.caught},
            {"most_contacts", w.max_contacts},
            {"energy_J", {{"start", w.start_energy}, {"most", w.max_energy}, {"least", w.least_energy}}},
            {"strain",
             {{"median", strain[strain.size() / 2]},
              {"p99", strain[strain.size() * 99 / 100]},
              {"largest", strain.back()},
              {"vertices", map}}},
            {"seam_gaps_m", seams},
            {"pulls", w.handling->pulls()},
            {"until_s", time},
            {"us_per_step",
             {{"collision", w.collision.summary()},
              {"points_moved", w.move.summary()},
              {"query", w.query.summary()},
              {"response", w.response.summary()},
              {"threads", w.threads.summary()},
              {"self_collision", w.self.summary()},
              {"prediction", w.predict.summary()}}}};
}

}  // namespace sqmap::app
