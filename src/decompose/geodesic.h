// Geodesic distances over a mesh or one part of it.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sqmap::decompose {

inline constexpr double k_unreached = std::numeric_limits<double>::infinity();

/// Fast marching over the triangles. The object holds the vertex-to-triangle lists and scratch memory for many runs.
class GeodesicSolver {
public:
    explicit GeodesicSolver(const mesh::Mesh& mesh);

    /// Triangles that paths may lead over: those whose entry in mask (#triangles) is label; all, where mask is empty.
    struct Region {
        std::span<const std::uint32_t> mask{};
        std::uint32_t label = 0;
    };

    /// Distance from the source vertices to every vertex, k_unreached beyond limit or where there is no path.
    /// Cost: O(n log n) in the vertices reached.
    void run(std::span<const std::uint32_t> sources, std::vector<double>& vertex_distance, double limit, Region region);
    /// The same over the whole mesh.
    void run(std::span<const std::uint32_t> sources, std::vector<double>& vertex_distance, double limit = k_unreached)
    {
        run(sources, vertex_distance, limit, Region{});
    }

    /// The same from the centroid of one triangle: g(u, v_i) of eq. 4.
    void run_from_triangle(std::uint32_t triangle, std::vector<double>& vertex_distance, double limit = k_unreached);

    /// Vertices reached by the last run, in order of distance.
    [[nodiscard]] const std::vector<std::uint32_t>& reached() const { return reached_; }

    /// Triangles around a vertex.
    [[nodiscard]] std::span<const std::uint32_t> around(std::uint32_t vertex) const
    {
        return {triangles_.data() + first_[vertex], first_[vertex + 1] - first_[vertex]};
    }

private:
    void offer(std::uint32_t vertex, double distance, double limit, std::vector<double>& vertex_distance);
    void start(std::vector<double>& vertex_distance);
    void march(std::vector<double>& vertex_distance, double limit, Region region);

    /// A triangle around a vertex v, with its other corners and the lengths of its sides: marches read them in order.
    struct Fan {
        std::uint32_t a, b;
        double va, vb, ab;
    };

    const mesh::Mesh& mesh_;
    std::vector<std::uint32_t> first_, triangles_;  // triangles around each vertex, CSR
    std::vector<Fan> fans_;                         // as triangles_
    std::vector<std::uint8_t> done_;
    std::vector<std::uint32_t> reached_;
    std::vector<std::pair<double, std::uint32_t>> heap_;
};

/// Distance of a triangle: mean over its corners (k_unreached if one is).
[[nodiscard]] std::vector<double> at_triangles(const mesh::Mesh& mesh, const std::vector<double>& vertex_distance);

}  // namespace sqmap::decompose
