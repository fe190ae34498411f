// Steps 1 to 3 of section 3: salient features, locales and Boundary Strength, curvature, cuts locale by locale.
#include "sqmap/decompose/decompose.h"

#include "curvature.h"
#include "cut.h"
#include "geodesic.h"
#include "partition.h"
#include "saliency.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::decompose {

namespace {

struct LocaleCut {
    bool found = false;
    double level = 0;   // geodesic distance of the cut
    double radius = 0;  // radius of the locale there
    double area = 0;    // area of the part cut off
    double strength = 0;
};

// Where Boundary Strength rises most. A locale's radius grows by the geodesic distance itself on flat ground, so growth
// per distance is free of scale; it is taken over one radius to either side.
LocaleCut salient_cut(const Locales& l, double part_area, double least_area, const DecomposeOptions& o)
{
    LocaleCut best;
    double inside = 0;
    for (std::size_t k = 1; k + 2 < l.area.size(); ++k) {
        inside += l.area[k - 1];
        const auto at = static_cast<std::ptrdiff_t>(k);
        const double level = l.width * static_cast<double>(k);
        const double radius = l.mean_radius(at - 2, at);
        if (inside < least_area || inside > 0.5 * part_area) continue;
        if (level < o.protrusion_ratio * radius) continue;
        const auto reach = std::max<std::ptrdiff_t>(2, static_cast<std::ptrdiff_t>(std::lround(radius / l.width)));
        const double before = l.mean_radius(at - reach, at), after = l.mean_radius(at, at + reach);
        const double strength = (after - before) / (static_cast<double>(reach) * l.width);
        if (strength > o.boundary_strength && strength > best.strength) best = {true, level, radius, inside, strength};
    }
    return best;
}

class Decomposer {
public:
    Decomposer(const mesh::Mesh& mesh, const DecomposeOptions& options)
        : mesh_(mesh), options_(options), surface_(mesh), geodesics_(mesh), root_area_(std::sqrt(surface_.total_area)),
          least_area_(options.minimum_part_area * surface_.total_area), width_(options.locale_width * root_area_)
    {
    }

    Decomposition run()
    {
        Decomposition out;
        const auto p = protrusion_at_vertices(mesh_, geodesics_, options_);
        out.protrusion = at_triangles(mesh_, p);
        out.curvature = gaussian_curvature(mesh_, surface_.graph, options_.curvature_window, surface_.total_area / 8000);
        curvature_ = out.curvature;
        partition_ = components(surface_);
        for (const auto v : salient_vertices(mesh_, geodesics_, p, options_.salient_window * root_area_, options_.salient_prominence))
            out.salient_triangles.push_back(geodesics_.around(v).front());
        cut_salient(out.salient_triangles);
        order_by_area(surface_, partition_);
        out.partition = partition_;
        return out;
    }

private:
    LocaleCut locale_cut(std::uint32_t feature, std::vector<std::uint32_t>& triangles, std::vector<double>& field)
    {
        const std::uint32_t part = partition_.part_of_triangle[feature];
        triangles = triangles_of(partition_, part);
        geodesics_.run({&feature, 1}, field, k_unreached, partition_.part_of_triangle, part);
        double area = 0;
        for (const auto t : triangles) area += surface_.area[t];
        return salient_cut(locales_of(mesh_, triangles, field, curvature_, width_), area, least_area_, options_);
    }

    // Small features first: ears are gone when the head's locales are measured.
    void cut_salient(const std::vector<std::uint32_t>& features)
    {
        std::vector<std::uint32_t> triangles;
        std::vector<double> field;
        std::vector<std::pair<double, std::uint32_t>> order;
        for (const auto f : features)
            if (const LocaleCut cut = locale_cut(f, triangles, field); cut.found) order.emplace_back(cut.area, f);
        std::sort(order.begin(), order.end());
        for (const auto& [unused, f] : order) {
            const LocaleCut cut = locale_cut(f, triangles, field);
            if (!cut.found) continue;
            const auto near = best_cut(surface_, triangles, at_triangles(mesh_, field), cut.level, 0.6 * cut.radius, cut.radius);
            apply_cut(surface_, partition_, partition_.part_of_triangle[f], triangles, near, CutKind::Salient, least_area_);
        }
    }

    const mesh::Mesh& mesh_;
    const DecomposeOptions& options_;
    CutSurface surface_;
    GeodesicSolver geodesics_;
    double root_area_, least_area_, width_;
    std::vector<double> curvature_;
    Partition partition_;
};

}  // namespace

Decomposition decompose_with_diagnostics(const mesh::Mesh& mesh, const DecomposeOptions& options)
{
    return Decomposer(mesh, options).run();
}

Partition decompose(const mesh::Mesh& mesh, const DecomposeOptions& options)
{
    return decompose_with_diagnostics(mesh, options).partition;
}

}  // namespace sqmap::decompose
