// Ratio of the area of the Gauss map to the area of the surface: no surface is fitted and no derivative estimated, as in
// J. Peng, Q. Li, C.-C. J. Kuo, M. Zhou, Estimating Gaussian curvatures from 3D meshes, Proc. SPIE (Human Vision and Electronic
// Imaging), 2003 (the paper's [18]). The signed area of the spherical image of a patch is the sum of the angle
// deficits inside it, exactly (Gauss and Bonnet).
#include "curvature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

namespace sqmap::decompose {

namespace {

constexpr std::size_t k_many = 100000;  ///< triangles from which on windows are shared
constexpr double k_shared = 0.25;       ///< of a window's radius

}  // namespace

std::vector<double> gaussian_curvature(const mesh::Mesh& mesh, const mesh::DualGraph& graph, double window, double least_area)
{
    const std::size_t n = mesh.triangles.size();
    std::vector<double> deficit(mesh.vertices.size(), 2 * std::numbers::pi), around(mesh.vertices.size(), 0.0), area(n);
    std::vector<Vec3d> centre(n);
    for (std::uint32_t t = 0; t < n; ++t) {
        const mesh::Triangle& tri = mesh.triangles[t];
        area[t] = mesh::triangle_area(mesh, t);
        centre[t] = mesh::triangle_centroid(mesh, t);
        for (int i = 0; i < 3; ++i) {
            const Vec3d p = mesh.vertices[tri[i]], a = mesh.vertices[tri[(i + 1) % 3]] - p,
                        b = mesh.vertices[tri[(i + 2) % 3]] - p;
            deficit[tri[i]] -= std::atan2(norm(cross(a, b)), dot(a, b));
            around[tri[i]] += area[t];
        }
    }
    // A border vertex has no spherical image of its own: its deficit is the border's turning.
    for (std::uint32_t t = 0; t < n; ++t)
        for (int e = 0; e < 3; ++e)
            if (graph.neighbours[t][e] == mesh::k_no_triangle)
                deficit[mesh.triangles[t][e]] = deficit[mesh.triangles[t][(e + 1) % 3]] = 0;

    std::vector<double> image(n, 0.0);
    for (std::uint32_t t = 0; t < n; ++t)
        for (const auto v : mesh.triangles[t])
            if (around[v] > 0) image[t] += deficit[v] * area[t] / around[v];

    std::vector<std::array<double, 3>> step(n);  // from centre to centre
    for (std::uint32_t t = 0; t < n; ++t)
        for (std::size_t e = 0; e < 3; ++e)
            if (const std::uint32_t w = graph.neighbours[t][e]; w != mesh::k_no_triangle)
                step[t][e] = norm(centre[w] - centre[t]);

    // Triangles about the middle of a window have nearly the same one. If there are many, they share its curvature: else the cost
    // would grow with the square of their number.
    const double shared = n >= k_many ? k_shared : 0;
    std::vector<std::uint8_t> is_known(n, 0);
    std::vector<double> k(n, 0.0), distance(n, -1.0);
    std::vector<std::uint32_t> touched;
    std::vector<std::pair<double, std::uint32_t>> heap;
    for (std::uint32_t t = 0; t < n; ++t) {
        if (is_known[t] != 0) continue;
        const double radius = window * std::sqrt(std::max(area[t], least_area));
        double sum_image = 0, sum_area = 0;
        heap.assign(1, {0.0, t});
        touched.assign(1, t);
        distance[t] = 0;
        while (!heap.empty()) {
            std::pop_heap(heap.begin(), heap.end(), std::greater<>());
            const auto [d, u] = heap.back();
            heap.pop_back();
            if (d > distance[u]) continue;
            sum_image += image[u];
            sum_area += area[u];
            for (std::size_t e = 0; e < 3; ++e) {
                const std::uint32_t w = graph.neighbours[u][e];
                if (w == mesh::k_no_triangle) continue;
                const double dw = d + step[u][e];
                if (dw >= radius || (distance[w] >= 0 && distance[w] <= dw)) continue;
                if (distance[w] < 0) touched.push_back(w);
                distance[w] = dw;
                heap.emplace_back(dw, w);
                std::push_heap(heap.begin(), heap.end(), std::greater<>());
            }
        }
        for (const auto u : touched) {
            if (u == t || (distance[u] < shared * radius && is_known[u] == 0)) {
                k[u] = sum_area > 0 ? sum_image / sum_area : 0;
                is_known[u] = 1;
            }
            distance[u] = -1;
        }
    }
    return k;
}

}  // namespace sqmap::decompose
