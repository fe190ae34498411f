// A. Gueziec, G. Taubin, F. Lazarus and W. Horn, "Cutting and stitching: converting sets of polygons to manifold surfaces", 2001;
// orientation as in visibility.cpp.
#include "steps.h"

#include "../shells.h"

#include <cmath>
#include <tuple>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr int k_resolve_passes = 4;  // each drops faces that the one before could not take apart
constexpr double k_unseen = 0.01;    // share of rays: a region that fewer rays leave is within the solid
// Share of the area that fins may have: if the rest is closed without them, and otherwise.
constexpr double k_max_fins_of_solid = 0.25, k_max_fins = 0.05;

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

/// The edges with more than two faces, and which regions lie at them. Regions go one by one while two faces stay at each.
class CrowdedEdges {
public:
    CrowdedEdges(const Surface& surface, const std::vector<std::uint32_t>& region)
        : at_(region.size()), gone_(region.size(), false)
    {
        for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) {
            if (edge.size() < 3) return;
            for (const EdgeUse& u : edge) {
                auto& list = at_[region[u.half / 3]];
                if (list.empty() || list.back().first != left_.size()) list.emplace_back(left_.size(), 0);
                ++list.back().second;
            }
            left_.push_back(edge.size());
        });
    }
    /// False if the region lies at no crowded edge, or less than two faces would stay at one.
    bool drop(std::size_t region)
    {
        if (at_[region].empty()) return false;
        if (!std::all_of(at_[region].begin(), at_[region].end(), [&](const auto& e) { return left_[e.first] >= e.second + 2; }))
            return false;
        for (const auto& [edge, count] : at_[region]) left_[edge] -= count;
        gone_[region] = true;
        return true;
    }
    /// Takes the regions away; returns how many faces.
    std::uint64_t remove(Surface& surface, const std::vector<std::uint32_t>& region) const
    {
        std::vector<Face> kept;
        for (std::size_t f = 0; f < surface.faces.size(); ++f)
            if (!gone_[region[f]]) kept.push_back(surface.faces[f]);
        const std::uint64_t count = surface.faces.size() - kept.size();
        surface.faces = std::move(kept);
        return count;
    }

private:
    std::vector<std::size_t> left_;                                     // of each edge, its faces
    std::vector<std::vector<std::pair<std::size_t, std::size_t>>> at_;  // of each region: edges, and its faces there
    std::vector<bool> gone_;
};

/// Drops regions at crowded edges that end at free edges elsewhere: they hang on a surface that is whole without them. The
/// smallest first, up to a share of the area.
std::uint64_t drop_fins(Surface& surface, const std::vector<std::uint32_t>& region, double max_share)
{
    std::vector<bool> is_open(region.size(), false);
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) {
        if (edge.size() == 1) is_open[region[edge[0].half / 3]] = true;
    });
    std::vector<double> area(region.size(), 0);
    double all = 0;
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        const auto& v = surface.faces[f].v;
        const double one = norm(cross(surface.points[v[1]] - surface.points[v[0]], surface.points[v[2]] - surface.points[v[0]]));
        area[region[f]] += one;
        all += one;
    }
    std::vector<std::size_t> order;
    for (std::size_t r = 0; r < region.size(); ++r)
        if (is_open[r]) order.push_back(r);
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return std::tuple(area[a], a) < std::tuple(area[b], b); });
    CrowdedEdges edges(surface, region);
    double gone = 0;
    for (const std::size_t r : order)
        if (gone + area[r] <= max_share * all && edges.drop(r)) gone += area[r];
    return edges.remove(surface, region);
}

std::uint64_t drop_fins(Surface& surface, const std::vector<std::uint32_t>& region)
{
    Surface without = surface;
    const std::uint64_t count = drop_fins(without, region, k_max_fins_of_solid);
    bool closed = true;
    for_each_edge(edge_uses(without.faces), [&](std::span<const EdgeUse> edge) { closed = closed && edge.size() == 2; });
    if (!closed) return drop_fins(surface, region, k_max_fins);
    surface = std::move(without);
    return count;
}

/// Drops regions at crowded edges that no ray leaves on either side, where two faces stay at each of their edges.
std::uint64_t drop_walls(Surface& surface, const std::vector<std::uint32_t>& region, const std::vector<Seen>& seen)
{
    CrowdedEdges edges(surface, region);
    for (std::size_t r = 0; r < region.size(); ++r)
        if (!(seen[r].front > k_unseen || seen[r].back > k_unseen)) edges.drop(r);
    return edges.remove(surface, region);
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

/// Pairs the rest of the edges: first those of which one side is seen and the other is not. A fin is seen from both.
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

/// Turns regions to the outside, drops walls and fins; returns, for each face's region, how different its two sides are in
/// visibility.
std::vector<double> look(Surface& surface, std::vector<std::uint32_t>& region, Resolved& out)
{
    std::vector<Seen> seen = seen_from_outside(surface, region);
    const auto look_again = [&] {
        region = agreed(surface, out.turned_faces);
        seen = seen_from_outside(surface, region);
    };
    if (const std::uint64_t walls = drop_walls(surface, region, seen); walls > 0) {
        out.wall_faces += walls;
        look_again();
    }
    if (const std::uint64_t fins = drop_fins(surface, region); fins > 0) {
        out.fin_faces += fins;
        look_again();
    }
    out.turned_faces += turn_to_outside(surface, region, seen);
    std::vector<double> one_sided(surface.faces.size(), 0);
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        const Seen& s = seen[region[f]];
        one_sided[f] = s.front + s.back > 0 ? std::abs(s.front - s.back) / (s.front + s.back) : 0;
    }
    return one_sided;
}

/// Takes sides without a partner off their edge. A vertex of several fans elsewhere stays one: two holes that touch in it are
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

/// Drops faces without a partner at edges that stayed crowded because their vertices hang together elsewhere.
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
    for (int pass = 0; pass < k_resolve_passes; ++pass) {
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
    constexpr double k_clearly = 1.5, k_min = 0.02;  // times the rays that see the front; share of the rays
    std::uint64_t count = 0;
    const std::vector<std::uint32_t> region = agreed(surface, count);
    const std::vector<Seen> seen = seen_from_outside(surface, region);
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        const Seen& s = seen[region[f]];
        if (!(s.back > k_clearly * s.front + k_min)) continue;
        std::swap(surface.faces[f].v[1], surface.faces[f].v[2]);
        ++count;
    }
    return count;
}

}  // namespace sqmap::mesh
