#include "bake/parts/caps.h"

#include "math/union_find.h"

#include <algorithm>
#include <map>
#include <utility>

namespace sqmap::bake {

namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Directed edges on cuts, as they run in the first part's triangles: (A, B) with A < B.
using Cuts = std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Edge>>;

Cuts find_cuts(const mesh::Mesh& mesh, const decompose::Partition& partition)
{
    struct HalfEdge {
        std::uint32_t lo, hi, triangle;
        bool forward;
    };
    // An edge between two parts has both ends in more than one.
    constexpr std::uint32_t k_none = 0xffffffffu, k_several = 0xfffffffeu;
    std::vector<std::uint32_t> part_of_vertex(mesh.vertices.size(), k_none);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) {
            const std::uint32_t part = partition.part_of_triangle[t];
            part_of_vertex[v] = part_of_vertex[v] == k_none || part_of_vertex[v] == part ? part : k_several;
        }
    std::vector<HalfEdge> halves;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
            if (part_of_vertex[a] != k_several || part_of_vertex[b] != k_several) continue;
            halves.push_back({std::min(a, b), std::max(a, b), t, a < b});
        }
    std::sort(halves.begin(), halves.end(), [](const HalfEdge& l, const HalfEdge& r) {
        return std::tie(l.lo, l.hi, l.triangle) < std::tie(r.lo, r.hi, r.triangle);
    });
    Cuts cuts;
    for (std::size_t i = 0; i < halves.size();) {
        std::size_t end = i;
        while (end < halves.size() && halves[end].lo == halves[i].lo && halves[end].hi == halves[i].hi) ++end;
        // Opposite half-edges in pairs; a manifold edge has one pair.
        std::vector<const HalfEdge*> forward, backward;
        for (std::size_t k = i; k < end; ++k) (halves[k].forward ? forward : backward).push_back(&halves[k]);
        for (std::size_t k = 0; k < std::min(forward.size(), backward.size()); ++k) {
            const std::uint32_t f = partition.part_of_triangle[forward[k]->triangle],
                                b = partition.part_of_triangle[backward[k]->triangle];
            if (f < b) cuts[{f, b}].emplace_back(halves[i].lo, halves[i].hi);
            if (b < f) cuts[{b, f}].emplace_back(halves[i].hi, halves[i].lo);
        }
        i = end;
    }
    return cuts;
}

/// The tree of straight segments that joins the junctions of every connected network of cuts: shortest first.
std::vector<Edge> junction_tree(const mesh::Mesh& mesh, const Cuts& cuts, const std::vector<std::uint32_t>& junctions)
{
    UnionFind networks(mesh.vertices.size());
    for (const auto& [pair, edges] : cuts)
        for (const Edge& e : edges) networks.unite(e.first, e.second);
    std::vector<std::pair<double, Edge>> candidates;
    for (std::size_t i = 0; i < junctions.size(); ++i)
        for (std::size_t j = i + 1; j < junctions.size(); ++j)
            if (networks.find(junctions[i]) == networks.find(junctions[j]))
                candidates.emplace_back(norm_sq(mesh.vertices[junctions[i]] - mesh.vertices[junctions[j]]),
                                        Edge{junctions[i], junctions[j]});
    std::sort(candidates.begin(), candidates.end());
    UnionFind trees(mesh.vertices.size());
    std::vector<Edge> tree;
    for (const auto& [length, e] : candidates)
        if (trees.unite(e.first, e.second)) tree.push_back(e);
    return tree;
}

}  // namespace

std::vector<std::vector<CapTriangle>> cap_parts(const mesh::Mesh& mesh, const decompose::Partition& partition)
{
    std::vector<std::vector<CapTriangle>> caps(partition.part_count);
    const Cuts cuts = find_cuts(mesh, partition);

    // Ends of every cut, with multiplicity: + where the chain starts, - where it stops.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::map<std::uint32_t, int>> ends;
    std::vector<std::uint32_t> junctions;
    for (const auto& [pair, edges] : cuts) {
        std::map<std::uint32_t, int>& e = ends[pair];
        for (const Edge& edge : edges) {
            ++e[edge.first];
            --e[edge.second];
        }
        std::erase_if(e, [](const auto& entry) { return entry.second == 0; });
        for (const auto& [v, n] : e) junctions.push_back(v);
    }
    std::sort(junctions.begin(), junctions.end());
    junctions.erase(std::unique(junctions.begin(), junctions.end()), junctions.end());
    const std::vector<Edge> tree = junction_tree(mesh, cuts, junctions);
    std::map<std::uint32_t, std::vector<std::pair<std::uint32_t, std::size_t>>> neighbours;
    for (std::size_t i = 0; i < tree.size(); ++i) {
        neighbours[tree[i].first].emplace_back(tree[i].second, i);
        neighbours[tree[i].second].emplace_back(tree[i].first, i);
    }

    for (const auto& [pair, edges] : cuts) {
        std::vector<Edge> chain = edges;
        // Close the chain along the tree: a walk from the leaves collects how often each segment is needed.
        std::map<std::uint32_t, int> owed = ends[pair];
        std::map<std::uint32_t, int> visited;
        for (const auto& [root, n] : ends[pair]) {
            if (visited[root] != 0) continue;
            std::vector<std::pair<std::uint32_t, std::uint32_t>> order;  // vertex, parent
            std::vector<std::pair<std::uint32_t, std::uint32_t>> stack{{root, root}};
            while (!stack.empty()) {
                const auto [v, parent] = stack.back();
                stack.pop_back();
                visited[v] = 1;
                order.emplace_back(v, parent);
                for (const auto& [u, index] : neighbours[v])
                    if (u != parent) stack.emplace_back(u, v);
            }
            for (auto it = order.rbegin(); it != order.rend(); ++it) {
                const auto [v, parent] = *it;
                const int n_owed = owed[v];
                if (v == parent) continue;
                // A chain starting at v (+) must be entered from the parent, one stopping there (-) returns to it.
                for (int k = 0; k < n_owed; ++k) chain.emplace_back(parent, v);
                for (int k = 0; k < -n_owed; ++k) chain.emplace_back(v, parent);
                owed[parent] += n_owed;
            }
        }
        UnionFind loops(mesh.vertices.size());
        for (const Edge& e : chain) loops.unite(e.first, e.second);
        std::map<std::uint32_t, std::vector<Edge>> by_loop;
        for (const Edge& e : chain) by_loop[loops.find(e.first)].push_back(e);
        for (const auto& [root, loop] : by_loop) {
            std::vector<std::uint32_t> vertices;
            for (const Edge& e : loop) {
                vertices.push_back(e.first);
                vertices.push_back(e.second);
            }
            std::sort(vertices.begin(), vertices.end());
            vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
            Vec3d apex{};
            for (const std::uint32_t v : vertices) apex += mesh.vertices[v];
            apex = apex / static_cast<double>(vertices.size());
            for (const Edge& e : loop) {
                caps[pair.first].push_back({mesh.vertices[e.second], mesh.vertices[e.first], apex});
                caps[pair.second].push_back({mesh.vertices[e.first], mesh.vertices[e.second], apex});
            }
        }
    }
    return caps;
}

}  // namespace sqmap::bake
