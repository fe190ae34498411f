#include "cut.h"

#include "partition.h"

#include <cmath>
#include <numbers>

namespace sqmap::decompose {

namespace {

/// A locale: the dual vertices of a band of geodesic distances.
struct Locale {
    double area = 0, hyperbolic_area = 0;
    double curvature_sum = 0, weighted_curvature_sum = 0;  ///< of the hyperbolic ones
    std::size_t hyperbolic_count = 0;

    [[nodiscard]] double mean_curvature(CurvatureMean mean) const
    {
        if (hyperbolic_count == 0) return 0;
        return mean == CurvatureMean::Count ? curvature_sum / static_cast<double>(hyperbolic_count)
                                            : weighted_curvature_sum / hyperbolic_area;
    }
};

/// Locales of a feature over the triangles of its part, and each triangle's distance.
struct Bands {
    std::vector<std::uint32_t> triangles;
    std::vector<double> distance;  ///< #triangles of the mesh
    std::vector<Locale> locales;
};

Bands bands_from(const PrintedCuts& input, const Partition& partition, std::uint32_t feature, std::uint32_t part)
{
    Bands bands;
    bands.triangles = triangles_of(partition, part);
    std::vector<double> field;
    input.geodesics.run({&feature, 1}, field, k_unreached, {partition.part_of_triangle, part});
    bands.distance = at_triangles(input.surface.mesh, field);
    for (const std::uint32_t t : bands.triangles) {
        if (!(bands.distance[t] < k_unreached)) continue;
        const auto k = static_cast<std::size_t>(bands.distance[t] / input.width);
        if (k >= bands.locales.size()) bands.locales.resize(k + 1);
        Locale& locale = bands.locales[k];
        const double area = input.surface.area[t], curvature = input.curvature[t];
        locale.area += area;
        if (!(curvature < 0)) continue;
        locale.hyperbolic_area += area;
        locale.curvature_sum += curvature;
        locale.weighted_curvature_sum += area * curvature;
        ++locale.hyperbolic_count;
    }
    return bands;
}

/// The tests of sections 3.1 and 3.2 at a locale. Boundary Strength is the difference of the areas of consecutive locales: over
/// the area by which locales grow on a plane, so that it is free of scale.
bool is_boundary(const Locale& before, const Locale& here, const PrintedCuts& input, const DecomposeOptions& o, CutKind& kind)
{
    const double strength = (here.area - before.area) / (2 * std::numbers::pi * input.width * input.width);
    kind = strength > o.printed_strength ? CutKind::Salient : CutKind::Curvature;
    return kind == CutKind::Salient ||
           (here.hyperbolic_area > o.hyperbolic_share * here.area &&
            std::abs(here.mean_curvature(o.curvature_mean)) * input.surface.total_area > o.printed_curvature);
}

}  // namespace

void cut_as_printed(const PrintedCuts& input, const DecomposeOptions& options, Partition& partition)
{
    for (const std::uint32_t feature : input.features) {
        // The part that extends from the feature: its own at first, then the rest after the last cut.
        std::uint32_t part = partition.part_of_triangle[input.geodesics.around(feature).front()];
        Bands bands = bands_from(input, partition, feature, part);
        double inside = 0;
        for (std::size_t k = 1; k < bands.locales.size() && partition.part_count < options.max_parts; ++k) {
            inside += bands.locales[k - 1].area;
            CutKind kind{};
            if (inside < input.least_area || !is_boundary(bands.locales[k - 1], bands.locales[k], input, options, kind)) continue;
            const double level = static_cast<double>(k) * input.width;
            const std::vector<std::uint32_t> triangles = triangles_of(partition, part);
            std::vector<std::uint8_t> near;
            std::uint32_t ahead = mesh::k_no_triangle;
            double nearest = k_unreached;
            for (const std::uint32_t t : triangles) {
                near.push_back(bands.distance[t] < level ? 1 : 0);
                if (near.back() != 0 || !(bands.distance[t] < nearest)) continue;
                nearest = bands.distance[t];
                ahead = t;
            }
            if (ahead == mesh::k_no_triangle) break;
            if (apply_cut(input.surface, partition, {part, triangles, near, kind, input.least_area}) < 2) continue;
            part = partition.part_of_triangle[ahead];
            inside = 0;
        }
    }
}

}  // namespace sqmap::decompose
