// Lin, Liao and Lin, "Visual salience-guided mesh decomposition", IEEE Trans. Multimedia 2007 (the paper's [16]);
// protrusion after Hilaga et al., "Topology matching", SIGGRAPH 2001.
#include "saliency.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace sqmap::decompose {

namespace {

struct Components {
    std::vector<std::uint32_t> of_triangle;
    std::uint32_t count = 0;
};

Components components_of(const mesh::Mesh& mesh, const GeodesicSolver& geodesics)
{
    Components c;
    c.of_triangle.assign(mesh.triangles.size(), mesh::k_no_triangle);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t seed = 0; seed < mesh.triangles.size(); ++seed) {
        if (c.of_triangle[seed] != mesh::k_no_triangle) continue;
        c.of_triangle[seed] = c.count;
        stack.push_back(seed);
        while (!stack.empty()) {
            const std::uint32_t t = stack.back();
            stack.pop_back();
            for (const auto v : mesh.triangles[t])
                for (const auto o : geodesics.around(v))
                    if (c.of_triangle[o] == mesh::k_no_triangle) {
                        c.of_triangle[o] = c.count;
                        stack.push_back(o);
                    }
        }
        ++c.count;
    }
    return c;
}

/// A component, and how many sources stand for all of its triangles.
struct SampledComponent {
    const std::vector<std::uint32_t>& triangles;
    const std::vector<double>& area;  ///< #triangles of the mesh
    std::uint32_t sources;
};

/// Eq. 4 over area-weighted sources, added to p at the component's vertices, which are returned.
std::vector<std::uint32_t> add_sampled(const mesh::Mesh& mesh, GeodesicSolver& geodesics, const SampledComponent& component,
                                       std::vector<double>& p)
{
    const auto& [triangles, area, sources] = component;
    std::vector<std::uint32_t> vertices;
    std::vector<double> field;
    // Farthest-point sources, each with the area of its Voronoi region. The first is the point farthest from
    // the area centroid: a choice that neither the vertex order nor the axes have a say in.
    Vec3d centre{};
    double total = 0;
    for (const auto t : triangles) {
        centre += area[t] * mesh::triangle_centroid(mesh, t);
        total += area[t];
    }
    centre = centre / total;
    std::uint32_t source = triangles.front();
    double farthest = -1;
    for (const auto t : triangles)
        if (const double d = norm(mesh::triangle_centroid(mesh, t) - centre); d > farthest) {
            farthest = d;
            source = t;
        }
    std::vector<std::vector<double>> fields;
    std::vector<double> nearest(mesh.triangles.size(), k_unreached);
    std::vector<std::uint32_t> owner(mesh.triangles.size(), 0);
    for (std::uint32_t k = 0; k < sources; ++k) {
        geodesics.run_from_triangle(source, field);
        if (k == 0) vertices = geodesics.reached();
        fields.emplace_back();
        fields.back().reserve(vertices.size());
        for (const auto v : vertices) fields.back().push_back(field[v]);
        farthest = -1;
        for (const auto t : triangles) {
            const mesh::Triangle& tri = mesh.triangles[t];
            const double d = (field[tri[0]] + field[tri[1]] + field[tri[2]]) / 3.0;
            if (d < nearest[t]) {
                nearest[t] = d;
                owner[t] = k;
            }
            if (nearest[t] > farthest) {
                farthest = nearest[t];
                source = t;
            }
        }
    }
    std::vector<double> weight(fields.size(), 0.0);
    for (const auto t : triangles) weight[owner[t]] += area[t];
    for (std::size_t k = 0; k < fields.size(); ++k)
        for (std::size_t i = 0; i < vertices.size(); ++i) p[vertices[i]] += fields[k][i] * weight[k];
    return vertices;
}

}  // namespace

std::vector<double> protrusion_at_vertices(const mesh::Mesh& mesh, GeodesicSolver& geodesics, const DecomposeOptions& options)
{
    const std::size_t n = mesh.vertices.size();
    std::vector<double> p(n, 0.0);
    std::vector<double> area(mesh.triangles.size());
    for (std::uint32_t t = 0; t < area.size(); ++t) area[t] = mesh::triangle_area(mesh, t);
    const Components components = components_of(mesh, geodesics);
    std::vector<std::vector<std::uint32_t>> members(components.count);
    for (std::uint32_t t = 0; t < area.size(); ++t) members[components.of_triangle[t]].push_back(t);

    std::vector<double> field;
    for (const auto& triangles : members) {
        std::vector<std::uint32_t> vertices;
        if (options.protrusion == ProtrusionSum::Exact || triangles.size() <= options.protrusion_sources) {
            for (const auto s : triangles) {
                geodesics.run_from_triangle(s, field);
                vertices = geodesics.reached();
                for (const auto v : vertices) p[v] += field[v] * area[s];
            }
        } else {
            vertices = add_sampled(mesh, geodesics, {triangles, area, options.protrusion_sources}, p);
        }
        double mean = 0, total = 0;
        for (const auto t : triangles) {
            const mesh::Triangle& tri = mesh.triangles[t];
            mean += area[t] * (p[tri[0]] + p[tri[1]] + p[tri[2]]) / 3.0;
            total += area[t];
        }
        if (mean > 0)
            for (const auto v : vertices) p[v] *= total / mean;
    }
    return p;
}

std::vector<std::uint32_t> salient_vertices(const mesh::Mesh& mesh, GeodesicSolver& geodesics, const std::vector<double>& p,
                                            const SalientLimits& limits)
{
    // Prominence by flooding from above: where two peaks meet, the lower one ends, and its height above the pass is
    // what it is worth. This discards the wobble of p on a sphere, which a window alone cannot tell from a feature.
    std::vector<std::uint32_t> order(p.size()), root(p.size(), mesh::k_no_triangle);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return p[a] != p[b] ? p[a] > p[b] : a < b; });
    const auto find = [&](std::uint32_t v) {
        while (root[v] != v) v = root[v] = root[root[v]];
        return v;
    };
    std::vector<double> rise(p.size(), 0.0);
    std::vector<double> lowest(p.size(), 0.0);
    for (const auto v : order) {
        root[v] = v;
        lowest[v] = p[v];
        for (const auto t : geodesics.around(v))
            for (const auto u : mesh.triangles[t]) {
                if (u == v || root[u] == mesh::k_no_triangle) continue;
                std::uint32_t a = find(u), b = find(v);
                if (a == b) continue;
                if (p[a] < p[b] || (p[a] == p[b] && a > b)) std::swap(a, b);
                rise[b] = p[b] - p[v];
                lowest[a] = std::min(lowest[a], p[v]);
                root[b] = a;
            }
    }
    std::vector<std::uint32_t> salient;
    std::vector<double> field;
    for (const auto v : order) {
        if (root[v] == v) rise[v] = p[v] - lowest[v];
        if (rise[v] < limits.prominence) continue;
        geodesics.run({&v, 1}, field, limits.window);
        bool greatest = true;
        for (const auto u : geodesics.reached()) greatest = greatest && (p[u] < p[v] || (p[u] == p[v] && u >= v));
        if (greatest) salient.push_back(v);
    }
    return salient;
}

double Locales::radius(std::size_t k) const { return area[k] / (2 * std::numbers::pi * width); }

double Locales::mean_radius(std::ptrdiff_t first, std::ptrdiff_t last) const
{
    first = std::max<std::ptrdiff_t>(first, 0);
    last = std::min<std::ptrdiff_t>(last, static_cast<std::ptrdiff_t>(area.size()));
    double sum = 0;
    for (auto k = first; k < last; ++k) sum += radius(static_cast<std::size_t>(k));
    return last > first ? sum / static_cast<double>(last - first) : 0.0;
}

Locales locales_of(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, const LocaleFields& fields, double width)
{
    const auto& [distance, curvature] = fields;
    Locales out;
    out.width = width;
    double greatest = 0;
    for (const auto t : triangles)
        for (const auto v : mesh.triangles[t])
            if (distance[v] < k_unreached) greatest = std::max(greatest, distance[v]);
    const std::size_t count = static_cast<std::size_t>(greatest / width) + 1;
    out.area.assign(count, 0.0);
    out.hyperbolic_area.assign(count, 0.0);
    out.hyperbolic_curvature.assign(count, 0.0);
    out.elliptic_curvature.assign(count, 0.0);
    for (const auto t : triangles) {
        const mesh::Triangle& tri = mesh.triangles[t];
        double d[3] = {distance[tri[0]], distance[tri[1]], distance[tri[2]]};
        std::sort(d, d + 3);
        if (!(d[2] < k_unreached)) continue;
        const double area = mesh::triangle_area(mesh, t);
        // Share of the triangle below a level of the linear interpolant: exact, so that bands may be thinner than edges.
        const auto below = [&](double level) {
            if (level <= d[0]) return 0.0;
            if (level >= d[2]) return 1.0;
            if (level <= d[1]) return (level - d[0]) * (level - d[0]) / ((d[1] - d[0]) * (d[2] - d[0]));
            return 1.0 - (d[2] - level) * (d[2] - level) / ((d[2] - d[1]) * (d[2] - d[0]));
        };
        double previous = 0;
        for (auto k = static_cast<std::size_t>(d[0] / width); k < count; ++k) {
            const double upto = below(width * static_cast<double>(k + 1));
            const double a = area * (upto - previous);
            previous = upto;
            out.area[k] += a;
            if (curvature[t] < 0) {
                out.hyperbolic_area[k] += a;
                out.hyperbolic_curvature[k] += a * curvature[t];
            } else {
                out.elliptic_curvature[k] += a * curvature[t];
            }
            if (upto >= 1.0) break;
        }
    }
    for (std::size_t k = 0; k < count; ++k)
        if (out.hyperbolic_area[k] > 0) out.hyperbolic_curvature[k] /= out.hyperbolic_area[k];
    return out;
}

}  // namespace sqmap::decompose
