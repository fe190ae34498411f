// Least cuts of the dual graph in a band about each border, after Katz and Tal, "Hierarchical mesh decomposition using fuzzy
// clustering and cuts", SIGGRAPH 2003. Cuts that look for a crease weigh it so much that they run to and fro between its edges;
// here a crease is worth a share of the length alone, and its depth is read from directions that are means over a neighbourhood.
#include "borders.h"

#include "cut.h"
#include "geodesic.h"
#include "maximum_flow.h"
#include "mirror.h"
#include "named_parts.h"
#include "partition.h"

#include <algorithm>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

namespace sqmap::decompose {

namespace {

using Labels = std::vector<std::uint32_t>;  ///< #triangles
using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// How far a border may move.
struct Freedom {
    double band;  ///< radii of a circle as long as the border, to either side
    double stay;  ///< what the area that the border moves over costs, over that radius: a cone's slope from which on it moves
};
// Borders on the half that follows have their length from the other: teeth of their own triangles alone are cut off.
constexpr Freedom k_free{0.4, 0.3}, k_following{0.15, 2.0};
constexpr double k_facing_reach = 0.15;   ///< of means of directions, radii
constexpr double k_crease_share = 0.4;    ///< of an edge's length that does not count in a deep crease
constexpr double k_deep_concavity = 1.5;  ///< of a deep crease, over one radius

/// A border that hangs together.
struct Chain {
    double length = 0;
    std::vector<std::uint32_t> vertices;
};

class BorderSmoother {
public:
    /// name: #triangles, changed.
    BorderSmoother(const CutSurface& surface, const Labels& part, Labels& name)
        : surface_(surface),
          geodesics_(surface.mesh),
          part_(part),
          name_(name),
          former_(name),
          facing_(name.size()),
          facing_of_(name.size(), 0),
          reached_by_(name.size(), 0)
    {
        const std::vector<Vec3d>& v = surface.mesh.vertices;
        for (std::uint32_t t = 0; t < name.size(); ++t) {
            const auto& [a, b, c] = surface.mesh.triangles[t];
            centre_.push_back(mesh::triangle_centroid(surface.mesh, t));
            normal_.push_back(cross(v[b] - v[a], v[c] - v[a]));
        }
    }

    /// Shortens each border once, the longest pair of names first.
    void shorten_all(const Freedom& freedom)
    {
        former_ = name_;
        std::map<Pair, double> lengths;
        for_border_edges([&](const Pair& pair, std::uint32_t t, int e) { lengths[pair] += surface_.edge_length[t][e]; });
        std::vector<std::pair<double, Pair>> order;
        for (const auto& [pair, length] : lengths) order.emplace_back(length, pair);
        std::sort(order.rbegin(), order.rend());
        for (const auto& [length, pair] : order)
            for (const Chain& chain : chains_of(pair)) shorten(pair, chain, freedom);
    }

    /// Gives the half whose borders are longer the names of the other.
    void reflect(const Mirror& mirror)
    {
        std::vector<std::uint8_t> side;
        for (const Vec3d& c : centre_) side.push_back(dot(mirror.normal, c) > mirror.offset ? 1 : 0);
        double length[2]{};
        for_border_edges([&](const Pair&, std::uint32_t t, int e) { length[side[t]] += surface_.edge_length[t][e]; });
        const std::uint8_t kept = length[1] < length[0] ? 1 : 0;
        std::map<Pair, double> shared;
        for (std::uint32_t t = 0; t < name_.size(); ++t)
            if (const std::uint32_t o = mirror.of_triangle[t]; o != mesh::k_no_triangle)
                shared[{name_[t], name_[o]}] += surface_.area[t];
        std::map<std::uint32_t, std::pair<double, std::uint32_t>> image;
        for (const auto& [pair, area] : shared) image[pair.first] = std::max(image[pair.first], {area, pair.second});
        const Labels before = name_;
        for (std::uint32_t t = 0; t < name_.size(); ++t) {
            const std::uint32_t o = mirror.of_triangle[t];
            if (side[t] == kept || o == mesh::k_no_triangle || side[o] != kept) continue;
            const auto it = image.find(before[o]);
            if (it == image.end()) continue;
            const auto back = image.find(it->second.second);
            if (back != image.end() && back->second.second == before[o]) name_[t] = it->second.second;
        }
    }

private:
    /// visit(names on either side, triangle, its edge), once for each edge between names.
    template <class Visit>
    void for_border_edges(Visit&& visit) const
    {
        for (std::uint32_t t = 0; t < name_.size(); ++t)
            for (int e = 0; e < 3; ++e) {
                const std::uint32_t o = surface_.graph.neighbours[t][e];
                if (o != mesh::k_no_triangle && o > t && name_[o] != name_[t]) visit(Pair(std::minmax(name_[t], name_[o])), t, e);
            }
    }

    [[nodiscard]] std::vector<Chain> chains_of(const Pair& wanted) const
    {
        std::map<std::uint32_t, std::vector<std::pair<std::uint32_t, double>>> next;
        for_border_edges([&](const Pair& pair, std::uint32_t t, int e) {
            if (pair != wanted) return;
            const std::uint32_t a = surface_.mesh.triangles[t][e], b = surface_.mesh.triangles[t][(e + 1) % 3];
            next[a].emplace_back(b, surface_.edge_length[t][e]);
            next[b].emplace_back(a, surface_.edge_length[t][e]);
        });
        std::vector<Chain> chains;
        while (!next.empty()) {
            Chain& chain = chains.emplace_back(Chain{0, {next.begin()->first}});
            for (std::size_t i = 0; i < chain.vertices.size(); ++i)
                if (const auto node = next.extract(chain.vertices[i]); !node.empty())
                    for (const auto& [v, length] : node.mapped()) {
                        chain.length += 0.5 * length;
                        if (next.contains(v)) chain.vertices.push_back(v);
                    }
        }
        return chains;
    }

    /// Triangles of both names that may change.
    Labels movable(const Pair& pair, const Chain& chain, double band)
    {
        std::vector<double> at_vertices;
        const double limit = 3 * chain.length / (2 * std::numbers::pi);
        geodesics_.run(chain.vertices, at_vertices, limit);
        const std::vector<double> distance = at_triangles(surface_.mesh, at_vertices);
        std::map<std::uint32_t, double> farthest;  // of each part
        Labels near;
        for (std::uint32_t t = 0; t < name_.size(); ++t) {
            if (name_[t] != pair.first && name_[t] != pair.second) continue;
            double& far = farthest[part_[t]];
            far = std::max(far, std::min(limit, distance[t]));
            if (distance[t] <= band) near.push_back(t);
        }
        std::erase_if(near, [&](std::uint32_t t) { return distance[t] > 0.5 * farthest[part_[t]]; });
        return near;
    }

    void shorten(const Pair& pair, const Chain& chain, const Freedom& freedom)
    {
        constexpr std::uint32_t k_source = 0, k_sink = 1;
        const double radius = chain.length / (2 * std::numbers::pi);
        if (!(radius > 0)) return;
        ++chain_;
        const Labels free = movable(pair, chain, freedom.band * radius);
        Labels node(name_.size(), mesh::k_no_triangle);
        for (std::uint32_t t = 0; t < name_.size(); ++t)
            if (name_[t] == pair.first || name_[t] == pair.second) node[t] = name_[t] == pair.first ? k_source : k_sink;
        std::uint32_t count = 2;
        for (const std::uint32_t t : free) node[t] = count++;
        MaximumFlow flow(count);
        double longest = 0;
        for (const std::uint32_t t : free) {
            const double stay = freedom.stay * surface_.area[t] / radius;
            if (former_[t] == pair.first) flow.add_edge(k_source, node[t], stay, 0);
            if (former_[t] == pair.second) flow.add_edge(node[t], k_sink, stay, 0);
            for (int e = 0; e < 3; ++e) {
                const std::uint32_t o = surface_.graph.neighbours[t][e];
                if (o == mesh::k_no_triangle || node[o] == mesh::k_no_triangle || (node[o] >= 2 && o < t)) continue;
                const double weight = surface_.edge_length[t][e] * (1 - k_crease_share * crease_between(t, o, radius));
                longest = std::max(longest, weight);
                flow.add_edge(node[t], node[o], weight, weight);
            }
        }
        const std::vector<std::uint8_t> near = flow.source_side(k_source, k_sink, 1e-12 * longest);
        for (const std::uint32_t t : free) name_[t] = near[node[t]] != 0 ? pair.first : pair.second;
    }

    /// From 0 on flat and convex ground to 1 in a deep crease.
    double crease_between(std::uint32_t t, std::uint32_t o, double radius)
    {
        const Vec3d across = centre_[o] - centre_[t];
        const double sq = dot(across, across);
        if (!(sq > 0)) return 0;
        const double inwards = dot(facing(t, k_facing_reach * radius) - facing(o, k_facing_reach * radius), across);
        return std::clamp(radius * inwards / (sq * k_deep_concavity), 0.0, 1.0);
    }

    /// Mean direction of the surface about a triangle.
    Vec3d facing(std::uint32_t triangle, double reach)
    {
        if (facing_of_[triangle] == chain_) return facing_[triangle];
        facing_of_[triangle] = chain_;
        ++flood_;
        Labels flood{triangle};
        reached_by_[triangle] = flood_;
        Vec3d sum{};
        for (std::size_t i = 0; i < flood.size(); ++i) {
            sum += normal_[flood[i]];
            for (const std::uint32_t o : surface_.graph.neighbours[flood[i]]) {
                if (o == mesh::k_no_triangle || reached_by_[o] == flood_) continue;
                const bool is_near = i == 0 || norm_sq(centre_[o] - centre_[triangle]) < reach * reach;
                if (!is_near || dot(normal_[o], normal_[triangle]) <= 0) continue;
                reached_by_[o] = flood_;
                flood.push_back(o);
            }
        }
        return facing_[triangle] = sqmap::normalized(sum);
    }

    const CutSurface& surface_;
    GeodesicSolver geodesics_;
    const Labels& part_;
    Labels& name_;
    Labels former_;  ///< names before a pass
    std::vector<Vec3d> centre_, normal_;
    std::vector<Vec3d> facing_;  ///< of the triangles that bear the chain's number
    Labels facing_of_, reached_by_;
    std::uint32_t chain_ = 0, flood_ = 0;
};

/// Parts of triangles whose name has changed: the nearest of their new name.
Labels parts_of_names(const CutSurface& s, const Partition& partition, const Labels& former, const Labels& name)
{
    Labels part = partition.part_of_triangle;
    std::vector<double> distance(name.size(), k_unreached);
    std::vector<std::pair<double, std::uint32_t>> heap;
    const auto grow = [&](std::uint32_t from) {
        for (const std::uint32_t o : s.graph.neighbours[from]) {
            if (o == mesh::k_no_triangle || name[o] != name[from]) continue;
            const double d = distance[from] + norm(mesh::triangle_centroid(s.mesh, o) - mesh::triangle_centroid(s.mesh, from));
            if (d >= distance[o]) continue;
            distance[o] = d;
            part[o] = part[from];
            heap.emplace_back(d, o);
            std::push_heap(heap.begin(), heap.end(), std::greater<>());
        }
    };
    for (std::uint32_t t = 0; t < name.size(); ++t) {
        if (name[t] == former[t])
            distance[t] = 0;
        else
            part[t] = mesh::k_no_triangle;
    }
    for (std::uint32_t t = 0; t < name.size(); ++t)
        if (name[t] == former[t]) grow(t);
    while (!heap.empty()) {
        std::pop_heap(heap.begin(), heap.end(), std::greater<>());
        const auto [d, t] = heap.back();
        heap.pop_back();
        if (d <= distance[t]) grow(t);
    }
    return part;
}

}  // namespace

NamedPartition smoothed(const mesh::Mesh& mesh, const NamedPartition& named, const Mirror* mirror)
{
    const CutSurface surface(mesh);
    const Partition& partition = named.partition;
    Labels former;
    for (const std::uint32_t part : partition.part_of_triangle) former.push_back(named.names[part]);
    Labels name = former;
    BorderSmoother smoother(surface, partition.part_of_triangle, name);
    smoother.shorten_all(k_free);
    if (mirror != nullptr) {
        smoother.reflect(*mirror);
        smoother.shorten_all(k_following);
    }
    NamedPartition out{carried_over(mesh, partition, parts_of_names(surface, partition, former, name)), {}};
    out.names = labels_of_parts(out.partition, name);
    for (Boundary& b : out.partition.boundaries)
        if (b.kind == CutKind::Error && out.names[b.part_a] != out.names[b.part_b]) b.kind = CutKind::Crease;
    return out;
}

}  // namespace sqmap::decompose
