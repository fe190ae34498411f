// A. Gueziec, G. Taubin, F. Lazarus and W. Horn, "Cutting and stitching: converting sets of polygons to manifold surfaces", 2001;
// orientation as in visibility.h.
#include "resolve.h"

#include "../shells.h"
#include "visibility.h"

#include <cmath>
#include <tuple>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr int k_passes = 4;        // each drops faces that the one before could not take apart
constexpr double k_unseen = 0.01;  // share of rays: what fewer leave is within the solid

/// Regions over two-faced edges, faces turned to agree; where a region has one side only it is torn.
std::vector<std::uint32_t> agreed(Surface& surface, std::uint64_t& turned_count)
{
    Orientation orientation = orient(surface, OneSided::Torn);
    turned_count += orientation.turned_count;
    return std::move(orientation.region);
}

bool has_crowded_edge(const Surface& surface)
{
    bool any = false;
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) { any = any || edge.size() > 2; });
    return any;
}

/// Drops regions at crowded edges that no ray leaves on either side, where two faces stay at each of their edges.
std::uint64_t drop_walls(Surface& surface, const std::vector<std::uint32_t>& region, const std::vector<Seen>& seen)
{
    // Of each region, the crowded edges it lies at, and how many of its faces do.
    std::vector<std::size_t> left;
    std::vector<std::vector<std::pair<std::size_t, std::size_t>>> at(region.size());
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) {
        if (edge.size() < 3) return;
        for (const EdgeUse& u : edge) {
            auto& list = at[region[u.half / 3]];
            if (list.empty() || list.back().first != left.size()) list.emplace_back(left.size(), 0);
            ++list.back().second;
        }
        left.push_back(edge.size());
    });
    std::vector<bool> dropped(region.size(), false);
    for (std::size_t r = 0; r < region.size(); ++r) {
        if (at[r].empty() || seen[r].front > k_unseen || seen[r].back > k_unseen) continue;
        if (!std::all_of(at[r].begin(), at[r].end(), [&](const auto& e) { return left[e.first] >= e.second + 2; })) continue;
        for (const auto& [edge, count] : at[r]) left[edge] -= count;
        dropped[r] = true;
    }
    std::vector<Face> kept;
    for (std::size_t f = 0; f < surface.faces.size(); ++f)
        if (!dropped[region[f]]) kept.push_back(surface.faces[f]);
    const std::uint64_t count = surface.faces.size() - kept.size();
    surface.faces = std::move(kept);
    return count;
}

std::uint64_t turn_to_outside(Surface& surface, const std::vector<std::uint32_t>& region, const std::vector<Seen>& seen)
{
    std::uint64_t count = 0;
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        const Seen& s = seen[region[f]];
        if (!(s.back > s.front)) continue;
        std::swap(surface.faces[f].v[1], surface.faces[f].v[2]);
        ++count;
    }
    return count;
}

/// At edges whose faces do not all pair up: first those of which one side is seen and the other is not. A fin is seen from both.
void pair_rest(const Surface& surface, const std::vector<double>& one_sided, std::vector<std::uint32_t>& mate)
{
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) {
        if (edge.size() < 3) return;
        std::vector<EdgeUse> free;
        for (const EdgeUse& u : edge)
            if (mate[u.half] == k_none) free.push_back(u);
        std::sort(free.begin(), free.end(), [&](const EdgeUse& a, const EdgeUse& b) {
            return std::tuple(-one_sided[a.half / 3], a.half) < std::tuple(-one_sided[b.half / 3], b.half);
        });
        for (std::size_t i = 0; i < free.size(); ++i)
            for (std::size_t j = i + 1; j < free.size() && mate[free[i].half] == k_none; ++j)
                if (mate[free[j].half] == k_none && free[i].forward != free[j].forward) {
                    mate[free[i].half] = free[j].half;
                    mate[free[j].half] = free[i].half;
                }
    });
}

/// Turns regions to the outside, drops walls; how different the two sides of each face's region are in what sees them.
std::vector<double> look(Surface& surface, std::vector<std::uint32_t>& region, Resolved& out)
{
    std::vector<Seen> seen = seen_from_outside(surface, region);
    const std::uint64_t walls = drop_walls(surface, region, seen);
    if (walls > 0) {
        out.wall_faces += walls;
        region = agreed(surface, out.turned_faces);
        seen = seen_from_outside(surface, region);
    }
    out.turned_faces += turn_to_outside(surface, region, seen);
    std::vector<double> one_sided(surface.faces.size(), 0);
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        const Seen& s = seen[region[f]];
        one_sided[f] = s.front + s.back > 0 ? std::abs(s.front - s.back) / (s.front + s.back) : 0;
    }
    return one_sided;
}

/// Takes sides without a partner off their edge; a vertex of several fans elsewhere stays one: two holes that touch in it are
/// filled one by one.
std::uint64_t cut(Surface& surface, std::vector<std::uint32_t>& mate)
{
    std::uint64_t count = 0;
    std::vector<bool> come_apart(surface.points.size(), false);
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) {
        if (edge.size() < 2) return;
        const bool torn = edge.size() == 2 && edge[0].forward == edge[1].forward;
        if (torn)
            for (const EdgeUse& u : edge) mate[u.half] = k_none;
        if (torn || edge.size() > 2) come_apart[edge[0].lo] = come_apart[edge[0].hi] = true;
        for (const EdgeUse& u : edge) count += mate[u.half] == k_none;
    });
    const std::vector<Face> before = surface.faces;
    split_fans(surface, mate);
    for (std::size_t f = 0; f < before.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k)
            if (!come_apart[before[f].v[k]]) surface.faces[f].v[k] = before[f].v[k];
    return count;
}

/// Faces without a partner at edges that stayed crowded, as their vertices hang together elsewhere: those go.
std::uint64_t drop_stuck(Surface& surface, const std::vector<std::uint32_t>& mate)
{
    std::vector<bool> stuck(surface.faces.size(), false);
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) {
        if (edge.size() < 2) return;
        for (const EdgeUse& u : edge)
            if (mate[u.half] == k_none) stuck[u.half / 3] = true;
    });
    std::vector<Face> kept;
    for (std::size_t f = 0; f < surface.faces.size(); ++f)
        if (!stuck[f]) kept.push_back(surface.faces[f]);
    const std::uint64_t count = surface.faces.size() - kept.size();
    surface.faces = std::move(kept);
    return count;
}

}  // namespace

Resolved resolve_edges(Surface& surface)
{
    Resolved out;
    for (int pass = 0; pass < k_passes; ++pass) {
        Orientation orientation;
        orientation.region = agreed(surface, out.turned_faces);
        std::vector<double> one_sided(surface.faces.size(), 0);
        if (has_crowded_edge(surface)) one_sided = look(surface, orientation.region, out);
        std::vector<std::uint32_t> mate = paired(surface, orientation).mate;
        pair_rest(surface, one_sided, mate);
        out.cut_edges += cut(surface, mate);
        const std::uint64_t stuck = drop_stuck(surface, mate);
        out.stuck_faces += stuck;
        if (stuck == 0) break;
    }
    return out;
}

std::uint64_t orient_outward(Surface& surface)
{
    constexpr double k_clearly = 1.5, k_least = 0.02;  // times what sees the front; shares of the rays
    std::uint64_t count = 0;
    const std::vector<std::uint32_t> region = agreed(surface, count);
    const std::vector<Seen> seen = seen_from_outside(surface, region);
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        const Seen& s = seen[region[f]];
        if (!(s.back > k_clearly * s.front + k_least)) continue;
        std::swap(surface.faces[f].v[1], surface.faces[f].v[2]);
        ++count;
    }
    return count;
}

}  // namespace sqmap::mesh
