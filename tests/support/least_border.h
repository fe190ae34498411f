// Borders between parts beside the shortest ones near them: Boost's maximum flow (Boykov, Kolmogorov) over the triangles of a
// band has the length of the shortest cut along edges. It shares no code with the cuts that it judges.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace sqmap::test {

/// One connected border of two labels.
struct BorderLength {
    std::uint32_t label_a, label_b;
    double length;        ///< mesh units
    double least;         ///< of a border within a quarter of the radius of a circle as long, mesh units
    double crease_share;  ///< of its length, where the surface turns inwards by over k_crease_angle
    [[nodiscard]] double excess() const { return length / least; }
};

inline constexpr double k_border_band = 0.25;   ///< of the radius
inline constexpr double k_crease_angle = 0.44;  ///< radians: 25 degrees, between means over k_border_band on either side

/// An edge of two triangles.
struct SharedEdge {
    std::array<std::uint32_t, 2> vertex, triangle;
    double length;
};

inline std::vector<SharedEdge> shared_edges(const mesh::Mesh& mesh)
{
    std::map<std::array<std::uint32_t, 2>, std::vector<std::uint32_t>> triangles;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
            triangles[{std::min(a, b), std::max(a, b)}].push_back(t);
        }
    std::vector<SharedEdge> out;
    for (const auto& [vertex, of] : triangles)
        if (of.size() == 2) out.push_back({vertex, {of[0], of[1]}, norm(mesh.vertices[vertex[0]] - mesh.vertices[vertex[1]])});
    return out;
}

/// Edges that hang together at vertices, as one list each.
inline std::vector<std::vector<SharedEdge>> chains_of(const std::vector<SharedEdge>& edges)
{
    std::map<std::uint32_t, std::uint32_t> root;
    const auto find = [&](std::uint32_t v) {
        while (root.try_emplace(v, v).first->second != v) v = root[v] = root[root[v]];
        return v;
    };
    for (const SharedEdge& e : edges) root[find(e.vertex[0])] = find(e.vertex[1]);
    std::map<std::uint32_t, std::vector<SharedEdge>> chains;
    for (const SharedEdge& e : edges) chains[find(e.vertex[0])].push_back(e);
    std::vector<std::vector<SharedEdge>> out;
    for (auto& [v, chain] : chains) out.push_back(std::move(chain));
    return out;
}

inline double distance_to_edge(const mesh::Mesh& mesh, const SharedEdge& edge, Vec3d p)
{
    const Vec3d a = mesh.vertices[edge.vertex[0]], d = mesh.vertices[edge.vertex[1]] - a;
    return norm(p - a - std::clamp(dot(p - a, d) / dot(d, d), 0.0, 1.0) * d);
}

/// Length of the shortest cut between two labels' triangles beyond a band, less that of the cut there is: <= 0.
/// distance: #triangles, from the border.
inline double shortening(const std::vector<SharedEdge>& edges, const std::vector<std::uint32_t>& label,
                         std::span<const double> distance, const BorderLength& border, double band)
{
    using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;
    struct Node {
        boost::default_color_type color{};
        long distance = 0;
        Traits::edge_descriptor predecessor;
    };
    struct Arc {
        double capacity, residual;
        Traits::edge_descriptor reverse;
    };
    using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, Node, Arc>;
    // A part within the band keeps what is farther from the border than half of it.
    double far_a = 0, far_b = 0;
    for (std::size_t t = 0; t < label.size(); ++t) {
        if (label[t] == border.label_a) far_a = std::max(far_a, distance[t]);
        if (label[t] == border.label_b) far_b = std::max(far_b, distance[t]);
    }
    const double band_a = std::min(band, 0.5 * far_a), band_b = std::min(band, 0.5 * far_b);
    constexpr std::size_t k_outside = ~std::size_t{0}, k_source = 0, k_sink = 1;
    std::vector<std::size_t> node(label.size(), k_outside);
    std::size_t count = 2;
    for (std::size_t t = 0; t < label.size(); ++t) {
        if (label[t] == border.label_a) node[t] = distance[t] > band_a ? k_source : count++;
        if (label[t] == border.label_b) node[t] = distance[t] > band_b ? k_sink : count++;
    }
    Graph graph(count);
    double today = 0;
    for (const SharedEdge& e : edges) {
        const std::size_t a = node[e.triangle[0]], b = node[e.triangle[1]];
        if (a == k_outside || b == k_outside || (a < 2 && b < 2)) continue;
        if (label[e.triangle[0]] != label[e.triangle[1]]) today += e.length;
        const auto there = boost::add_edge(a, b, {e.length, 0, {}}, graph).first;
        const auto back = boost::add_edge(b, a, {e.length, 0, there}, graph).first;
        graph[there].reverse = back;
    }
    const double least = boost::boykov_kolmogorov_max_flow(
        graph, get(&Arc::capacity, graph), get(&Arc::residual, graph), get(&Arc::reverse, graph), get(&Node::predecessor, graph),
        get(&Node::color, graph), get(&Node::distance, graph), get(boost::vertex_index, graph), k_source, k_sink);
    return least - today;
}

/// Every border between triangles of two labels. label: #triangles.
inline std::vector<BorderLength> border_lengths(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& label)
{
    const std::vector<SharedEdge> edges = shared_edges(mesh);
    std::vector<Vec3d> centre, normal;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        centre.push_back(mesh::triangle_centroid(mesh, t));
        normal.push_back(cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]));
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<SharedEdge>> of_pair;
    for (const SharedEdge& e : edges) {
        const std::uint32_t a = label[e.triangle[0]], b = label[e.triangle[1]];
        if (a != b) of_pair[{std::min(a, b), std::max(a, b)}].push_back(e);
    }
    std::vector<BorderLength> out;
    for (const auto& [pair, all] : of_pair)
        for (const std::vector<SharedEdge>& chain : chains_of(all)) {
            BorderLength border{pair.first, pair.second, 0, 0, 0};
            for (const SharedEdge& e : chain) border.length += e.length;
            const double band = k_border_band * border.length / (2 * std::numbers::pi);
            std::vector<double> distance(label.size(), 1e300);
            for (std::size_t t = 0; t < label.size(); ++t)
                if (label[t] == pair.first || label[t] == pair.second)
                    for (const SharedEdge& e : chain) distance[t] = std::min(distance[t], distance_to_edge(mesh, e, centre[t]));
            border.least = border.length + shortening(edges, label, distance, border, band);
            for (const SharedEdge& e : chain) {
                std::array<Vec3d, 2> facing{}, middle{};
                std::array<double, 2> area{};
                for (std::size_t t = 0; t < label.size(); ++t) {
                    if (distance[t] > band || distance_to_edge(mesh, e, centre[t]) > band) continue;
                    const std::size_t side = label[t] == pair.first ? 0 : 1;
                    facing[side] += normal[t];
                    middle[side] += norm(normal[t]) * centre[t];
                    area[side] += norm(normal[t]);
                }
                if (!(area[0] > 0 && area[1] > 0)) continue;
                const bool inwards =
                    dot(facing[0] / norm(facing[0]) - facing[1] / norm(facing[1]), middle[1] / area[1] - middle[0] / area[0]) > 0;
                if (inwards && std::atan2(norm(cross(facing[0], facing[1])), dot(facing[0], facing[1])) > k_crease_angle)
                    border.crease_share += e.length / border.length;
            }
            out.push_back(border);
        }
    return out;
}

}  // namespace sqmap::test
