// Winding numbers by solid angles: A. Van Oosterom and J. Strackee, "The solid angle of a plane triangle", 1983.
#include "shells.h"

#include "sqmap/math/assert.h"
#include "sqmap/math/box.h"

#include <cmath>
#include <map>
#include <numbers>

namespace sqmap::mesh {

Orientation orient(Surface& surface, OneSided one_sided)
{
    const auto count = static_cast<std::uint32_t>(surface.faces.size());
    Orientation out;
    out.region.assign(count, k_none);
    // For each two-faced edge: the neighbour, and whether both faces run the same way along it, which is wrong.
    std::vector<std::uint32_t> neighbour(3 * std::size_t{count}, k_none);
    std::vector<bool> disagrees(3 * std::size_t{count}, false);
    const std::vector<EdgeUse> uses = edge_uses(surface.faces);
    for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
        if (edge.size() != 2) return;
        for (int i = 0; i < 2; ++i) {
            neighbour[edge[i].half] = edge[1 - i].half / 3;
            disagrees[edge[i].half] = edge[0].forward == edge[1].forward;
        }
    });
    std::vector<bool> turn(count, false);
    std::vector<std::uint32_t> members;
    for (std::uint32_t seed = 0; seed < count; ++seed) {
        if (out.region[seed] != k_none) continue;
        members.assign(1, seed);
        out.region[seed] = seed;
        std::size_t turned = 0;
        for (std::size_t i = 0; i < members.size(); ++i) {
            const std::uint32_t f = members[i];
            turned += turn[f];
            for (std::uint32_t half = 3 * f; half < 3 * f + 3; ++half) {
                const std::uint32_t g = neighbour[half];
                if (g == k_none) continue;
                const bool wanted = turn[f] != disagrees[half];
                if (out.region[g] == k_none) {
                    out.region[g] = seed;
                    turn[g] = wanted;
                    members.push_back(g);
                } else if (turn[g] != wanted && !out.conflict) {
                    out.conflict = std::max(f, g);
                }
            }
        }
        if (2 * turned > members.size())
            for (const std::uint32_t f : members) turn[f] = !turn[f];
    }
    if (out.conflict && one_sided == OneSided::Refused) return out;
    for (std::uint32_t f = 0; f < count; ++f)
        if (turn[f]) {
            std::swap(surface.faces[f].v[1], surface.faces[f].v[2]);
            ++out.turned_count;
        }
    return out;
}

namespace {

/// Matches the sides of one edge, in turning order around it, like brackets: from a face that runs against the edge the
/// solid lies ahead, up to a face that runs along it. False where the numbers differ.
bool match(std::span<const EdgeUse> ring, std::vector<std::uint32_t>& mate)
{
    const auto opening = std::count_if(ring.begin(), ring.end(), [](const EdgeUse& u) { return !u.forward; });
    if (2 * static_cast<std::size_t>(opening) != ring.size()) return false;
    // Twice around, so that a bracket that opens before the start of the list still finds its partner.
    std::vector<std::uint32_t> open;
    for (std::size_t i = 0; i < 2 * ring.size(); ++i) {
        const EdgeUse& u = ring[i % ring.size()];
        if (!u.forward) {
            if (i < ring.size()) open.push_back(u.half);
        } else if (!open.empty() && mate[u.half] == k_none) {
            mate[u.half] = open.back();
            mate[open.back()] = u.half;
            open.pop_back();
        }
    }
    return open.empty();
}

}  // namespace

Pairing paired(const Surface& surface, const Orientation& orientation)
{
    SQMAP_ASSERT(orientation.region.size() == surface.faces.size());
    Pairing out;
    out.mate.assign(3 * surface.faces.size(), k_none);
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) {
        if (edge.size() < 2) return;
        if (edge.size() == 2) {
            out.mate[edge[0].half] = edge[1].half;
            out.mate[edge[1].half] = edge[0].half;
            return;
        }
        const Vec3d from = surface.points[edge[0].lo];
        const Vec3d axis = normalized(surface.points[edge[0].hi] - from);
        const auto across = [&](const EdgeUse& u) {
            const Vec3d w = surface.points[surface.faces[u.half / 3].v[(u.half % 3 + 2) % 3]] - from;
            return w - dot(w, axis) * axis;
        };
        const Vec3d x = normalized(across(edge[0])), y = cross(axis, x);
        std::vector<std::pair<double, EdgeUse>> turning;
        for (const EdgeUse& u : edge) turning.emplace_back(std::atan2(dot(across(u), y), dot(across(u), x)), u);
        std::sort(turning.begin(), turning.end(), [](const auto& a, const auto& b) {
            return a.first != b.first ? a.first < b.first : a.second.half < b.second.half;
        });
        // Faces that hang together elsewhere stay together where that is possible: two boxes that share an edge.
        std::map<std::uint32_t, std::vector<EdgeUse>> regions;
        std::vector<EdgeUse> ring;
        for (const auto& [angle, u] : turning) {
            ring.push_back(u);
            regions[orientation.region[u.half / 3]].push_back(u);
        }
        bool done = true;
        for (const auto& [region, members] : regions) done = match(members, out.mate) && done;
        if (done) return;
        for (const EdgeUse& u : ring) out.mate[u.half] = k_none;
        if (match(ring, out.mate)) return;
        for (const EdgeUse& u : ring) out.mate[u.half] = k_none;
        if (!out.unpaired) out.unpaired = edge[0];
    });
    return out;
}

std::uint32_t split_fans(Surface& surface, const std::vector<std::uint32_t>& mate)
{
    SQMAP_ASSERT(mate.size() == 3 * surface.faces.size());
    UnionFind corners(3 * surface.faces.size());
    const auto vertex = [&](std::uint32_t corner) { return surface.faces[corner / 3].v[corner % 3]; };
    for (std::uint32_t half = 0; half < mate.size(); ++half) {
        if (mate[half] == k_none || mate[half] < half) continue;
        const std::uint32_t next = half / 3 * 3 + (half + 1) % 3, mate_next = mate[half] / 3 * 3 + (mate[half] + 1) % 3;
        for (const std::uint32_t c : {half, next})
            for (const std::uint32_t d : {mate[half], mate_next})
                if (vertex(c) == vertex(d)) corners.unite(c, d);
    }
    // The first fan keeps the vertex.
    std::vector<std::uint32_t> keeper(surface.points.size(), k_none), copy(3 * surface.faces.size(), k_none);
    std::uint32_t made = 0;
    for (std::uint32_t c = 0; c < copy.size(); ++c) {
        const std::uint32_t v = vertex(c), fan = corners.find(c);
        if (copy[fan] == k_none) {
            if (keeper[v] == k_none) {
                keeper[v] = fan;
                copy[fan] = v;
            } else {
                copy[fan] = static_cast<std::uint32_t>(surface.points.size());
                surface.points.push_back(Vec3d(surface.points[v]));
                surface.source.push_back(std::uint32_t(surface.source[v]));
                ++made;
            }
        }
        copy[c] = copy[fan];
    }
    for (std::uint32_t c = 0; c < copy.size(); ++c) surface.faces[c / 3].v[c % 3] = copy[c];
    return made;
}

std::vector<std::uint32_t> components(std::size_t face_count, const std::vector<std::uint32_t>& mate)
{
    UnionFind faces(face_count);
    for (std::uint32_t half = 0; half < mate.size(); ++half)
        if (mate[half] != k_none) faces.unite(half / 3, mate[half] / 3);
    std::vector<std::uint32_t> out(face_count);
    for (std::uint32_t f = 0; f < face_count; ++f) out[f] = faces.find(f);
    return out;
}

double six_volumes(std::span<const Vec3d> points, const Triangle& t)
{
    return dot(points[t[0]], cross(points[t[1]], points[t[2]]));
}

namespace {

struct Shell {
    std::vector<std::uint32_t> faces;
    double six_volumes = 0;
    Box box;
};

double solid_angle(Vec3d a, Vec3d b, Vec3d c)
{
    const double la = norm(a), lb = norm(b), lc = norm(c);
    return 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

}  // namespace

Shells turn_outward(Surface& surface, std::span<const Vec3d> points, const std::vector<std::uint32_t>& component)
{
    SQMAP_ASSERT(component.size() == surface.faces.size() && points.size() == surface.points.size());
    std::map<std::uint32_t, Shell> shells;
    double total = 0;
    for (std::uint32_t f = 0; f < surface.faces.size(); ++f) {
        Shell& shell = shells[component[f]];
        shell.faces.push_back(f);
        const double v = six_volumes(points, surface.faces[f].v);
        shell.six_volumes += v;
        total += v;
        for (const std::uint32_t i : surface.faces[f].v) extend(shell.box, points[i]);
    }
    Shells out;
    const auto turn = [&](Shell& shell) {
        for (const std::uint32_t f : shell.faces) std::swap(surface.faces[f].v[1], surface.faces[f].v[2]);
        shell.six_volumes = -shell.six_volumes;
        out.turned_count += static_cast<std::uint32_t>(shell.faces.size());
    };
    if (total < 0)
        for (auto& [id, shell] : shells) turn(shell);
    std::vector<Shell*> inverted;
    for (auto& [id, shell] : shells) {
        if (shell.six_volumes >= 0) continue;
        const Vec3d p = points[surface.faces[shell.faces.front()].v[0]];
        double angle = 0;
        for (const auto& [other_id, other] : shells) {
            if (other_id == id || !(other.six_volumes > 0) || !contains(other.box, p)) continue;
            for (const std::uint32_t f : other.faces) {
                const Triangle& t = surface.faces[f].v;
                angle += solid_angle(points[t[0]] - p, points[t[1]] - p, points[t[2]] - p);
            }
        }
        if (angle > 2 * std::numbers::pi)
            ++out.cavity_count;
        else
            inverted.push_back(&shell);
    }
    for (Shell* shell : inverted) turn(*shell);
    return out;
}

}  // namespace sqmap::mesh
