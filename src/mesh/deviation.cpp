// Points over a triangle by the R2 sequence: M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018.
#include "sqmap/mesh/wrap.h"

#include "math/percentile.h"
#include "sqmap/math/assert.h"
#include "sqmap/mesh/bvh.h"

#include "wrap/winding.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::mesh {
namespace {

constexpr double k_beside = 1e-5;  ///< share of R_max beside a surface, where its two sides are probed

struct Sample {
    Vec3d point;
    std::uint32_t triangle;
};

/// Points at equal steps of area, in the order of the triangles: each stands for the same share of the surface.
std::vector<Sample> spread(const Mesh& mesh, std::span<const std::uint8_t> left_out, std::uint32_t count)
{
    std::vector<double> area(mesh.triangles.size());
    double total = 0;
    for (std::uint32_t t = 0; t < area.size(); ++t) {
        area[t] = !left_out.empty() && left_out[t] != 0 ? 0 : triangle_area(mesh, t);
        total += area[t];
    }
    std::vector<Sample> out;
    if (!(total > 0)) return out;
    out.reserve(count + 1);
    constexpr double k_step_u = 0.7548776662466927, k_step_v = 0.5698402909980532;  // 1/p, 1/p^2 of the plastic number
    double u = 0.5, v = 0.5, passed = 0, next = 0.5;
    for (std::uint32_t t = 0; t < area.size(); ++t) {
        passed += area[t] / total * count;
        for (; next < passed; next += 1) {
            u = std::fmod(u + k_step_u, 1.0);
            v = std::fmod(v + k_step_v, 1.0);
            const bool beyond = u + v > 1;
            const double s = beyond ? 1 - u : u, r = beyond ? 1 - v : v;
            const Triangle& corners = mesh.triangles[t];
            const Vec3d a = mesh.vertices[corners[0]];
            out.push_back({a + s * (mesh.vertices[corners[1]] - a) + r * (mesh.vertices[corners[2]] - a), t});
        }
    }
    return out;
}

/// Every n-th vertex of the triangles that count, at most `count`.
std::vector<Vec3d> vertices_of(const Mesh& mesh, std::span<const std::uint8_t> left_out, std::uint32_t count)
{
    std::vector<bool> used(mesh.vertices.size(), false);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (left_out.empty() || left_out[t] == 0)
            for (const std::uint32_t v : mesh.triangles[t]) used[v] = true;
    std::vector<Vec3d> out;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v]) out.push_back(mesh.vertices[v]);
    const std::size_t stride = (out.size() + count - 1) / std::max<std::size_t>(count, 1);
    if (stride < 2) return out;
    std::vector<Vec3d> some;
    for (std::size_t i = 0; i < out.size(); i += stride) some.push_back(out[i]);
    return some;
}

/// values: distances of samples; in no order afterwards.
Distances summed(std::vector<double>& values)
{
    Distances out;
    if (values.empty()) return out;
    double sum = 0;
    for (const double d : values) {
        sum += d;
        out.max = std::max(out.max, d);
    }
    out.mean = sum / static_cast<double>(values.size());
    out.p99 = percentile(values, 99);
    return out;
}

Distances distances(const Mesh& from, std::span<const std::uint8_t> left_out, const Bvh& to, std::uint32_t samples)
{
    std::vector<double> values;
    for (const Sample& s : spread(from, left_out, samples)) values.push_back(to.closest_point(s.point).distance);
    Distances out = summed(values);
    for (const Vec3d& p : vertices_of(from, left_out, samples)) out.max = std::max(out.max, to.closest_point(p).distance);
    return out;
}

}  // namespace

Deviation deviation(const Mesh& input, const Mesh& result, std::span<const std::uint8_t> made_up, std::uint32_t samples)
{
    SQMAP_ASSERT(!input.triangles.empty() && !result.triangles.empty());
    SQMAP_ASSERT(made_up.empty() || made_up.size() == result.triangles.size());
    Deviation out;
    out.input_to_result = distances(input, {}, Bvh(result), samples);
    out.result_to_input = distances(result, made_up, Bvh(input), samples);
    double area = 0;
    for (std::uint32_t t = 0; t < result.triangles.size(); ++t) {
        const double own = triangle_area(result, t);
        area += own;
        if (!made_up.empty() && made_up[t] != 0) out.made_up_area += own;
    }
    out.made_up_share = area > 0 ? out.made_up_area / area : 0;
    return out;
}

Distances bounding_distances(const Mesh& input, const Mesh& result, std::uint32_t samples)
{
    SQMAP_ASSERT(!input.triangles.empty() && !result.triangles.empty());
    const WindingNumber winding(input);
    const Bvh to(result);
    const double step = k_beside * largest_vertex_distance(input);
    std::vector<double> values;
    for (const Sample& s : spread(input, {}, samples)) {
        const auto& [i, j, k] = input.triangles[s.triangle];
        const Vec3d a = input.vertices[i], normal = cross(input.vertices[j] - a, input.vertices[k] - a);
        const Vec3d beside = step / norm(normal) * normal;
        if ((winding.at(s.point - beside) > 0.5) != (winding.at(s.point + beside) > 0.5))
            values.push_back(to.closest_point(s.point).distance);
    }
    return summed(values);
}

}  // namespace sqmap::mesh
