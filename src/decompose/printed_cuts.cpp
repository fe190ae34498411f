// Locales, Boundary Strength and step 3 of section 3 as printed.
#include "decompose/locales.h"

#include "cut.h"
#include "partition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace sqmap::decompose {

namespace {

/// The surface between two levels of geodesic distance.
struct Locale {
    double area = 0, hyperbolic_area = 0;
    double curvature_sum = 0, weighted_curvature_sum = 0;  ///< of the hyperbolic dual vertices
    std::size_t hyperbolic_count = 0;

    [[nodiscard]] double mean_curvature(CurvatureMean mean) const
    {
        if (hyperbolic_count == 0) return 0;
        return mean == CurvatureMean::Count ? curvature_sum / static_cast<double>(hyperbolic_count)
                                            : weighted_curvature_sum / hyperbolic_area;
    }
};

/// The share of a triangle's area at which a field that is linear over it stays below a level. ascending: its values at the
/// corners.
double share_below(const std::array<double, 3>& ascending, double level)
{
    const auto [low, middle, high] = ascending;
    if (level <= low) return 0;
    if (level >= high) return 1;
    if (level <= middle) return (level - low) * (level - low) / ((middle - low) * (high - low));
    return 1 - (high - level) * (high - level) / ((high - middle) * (high - low));
}

/// Adds a triangle to the locales between whose levels it lies, each with the area that the levels cut out of it.
void add_triangle(const PrintedCuts& input, std::uint32_t t, std::array<double, 3> corners, std::vector<Locale>& locales)
{
    std::sort(corners.begin(), corners.end());
    const double curvature = input.curvature[t];
    double below = 0;
    for (auto k = static_cast<std::size_t>(corners[0] / input.width); below < 1; ++k) {
        if (k >= locales.size()) locales.resize(k + 1);
        const double next = share_below(corners, static_cast<double>(k + 1) * input.width);
        const double area = (next - below) * input.surface.area[t];
        below = next;
        if (!(area > 0)) continue;
        Locale& locale = locales[k];
        locale.area += area;
        if (!(curvature < 0)) continue;
        locale.hyperbolic_area += area;
        locale.curvature_sum += curvature;
        locale.weighted_curvature_sum += area * curvature;
        ++locale.hyperbolic_count;
    }
}

/// Locales of the triangles that a field reaches. A run without a limit reaches all corners of a triangle or none.
std::vector<Locale> locales_over(const PrintedCuts& input, const std::vector<std::uint32_t>& triangles,
                                 const std::vector<double>& field)
{
    std::vector<Locale> locales;
    for (const std::uint32_t t : triangles) {
        const mesh::Triangle& c = input.surface.mesh.triangles[t];
        if (field[c[0]] < k_unreached) add_triangle(input, t, {field[c[0]], field[c[1]], field[c[2]]}, locales);
    }
    return locales;
}

std::vector<double> strengths_of(const std::vector<Locale>& locales, double width)
{
    std::vector<double> area;
    for (const Locale& l : locales) area.push_back(l.area);
    return boundary_strength(area, width);
}

/// A locale's outcome of the tests: by how many times it passes one, 0 where it passes neither.
struct Passed {
    double by = 0;
    CutKind kind = CutKind::Salient;
};

/// Cuts one part again and again as the locales of one feature advance over it.
class Advance {
public:
    Advance(const PrintedCuts& input, const DecomposeOptions& options, std::uint32_t feature, Partition& partition)
        : input_(input),
          options_(options),
          partition_(partition),
          part_(partition.part_of_triangle[input.geodesics.around(feature).front()])
    {
        std::vector<double> field;
        input.geodesics.run({&feature, 1}, field, k_unreached, {partition.part_of_triangle, part_});
        distance_ = at_triangles(input.surface.mesh, field);
        locales_ = locales_over(input, triangles_of(partition, part_), field);
        strength_ = strengths_of(locales_, input.width);
    }

    void run()
    {
        double inside = 0;  // area since the last cut
        for (std::size_t k = 1, end = 1; k < locales_.size() && partition_.part_count < options_.max_parts; k = end) {
            end = k + 1;
            inside += locales_[k - 1].area;
            Passed best = tests(k);
            if (best.by == 0 || inside < input_.least_area) continue;
            // Consecutive locales that pass the same test are one place, which is cut once: at the locale that passes by most.
            std::size_t at = k;
            for (; end < locales_.size(); ++end) {
                const Passed next = tests(end);
                if (next.by == 0 || next.kind != best.kind) break;
                if (next.by <= best.by) continue;
                best = next;
                at = end;
            }
            const bool is_cut = cut(at, best.kind);
            if (is_cut) inside = 0;
            for (std::size_t i = is_cut ? at : k; i + 1 < end; ++i) inside += locales_[i].area;
        }
    }

private:
    /// Section 3.1's test is a significant increase of Boundary Strength from the locale before, section 3.2's has two
    /// conditions.
    Passed tests(std::size_t k) const
    {
        // The second locale is the first that has a strength: a rise needs one before it.
        if (const double rise = k >= 2 ? strength_[k] - strength_[k - 1] : 0; rise > options_.printed_strength)
            return {rise / options_.printed_strength, CutKind::Salient};
        const Locale& here = locales_[k];
        const double curvature = std::abs(here.mean_curvature(options_.curvature_mean)) * input_.surface.total_area;
        if (here.hyperbolic_area > options_.hyperbolic_share * here.area && curvature > options_.printed_curvature)
            return {curvature / options_.printed_curvature, CutKind::Curvature};
        return {};
    }

    /// Cuts before a locale; the part ahead of it is the one that goes on.
    bool cut(std::size_t locale, CutKind kind)
    {
        const double level = static_cast<double>(locale) * input_.width;
        const std::vector<std::uint32_t> triangles = triangles_of(partition_, part_);
        std::vector<std::uint8_t> near;
        std::uint32_t ahead = mesh::k_no_triangle;
        double nearest = k_unreached;
        for (const std::uint32_t t : triangles) {
            near.push_back(distance_[t] < level ? 1 : 0);
            if (near.back() != 0 || !(distance_[t] < nearest)) continue;
            nearest = distance_[t];
            ahead = t;
        }
        if (ahead == mesh::k_no_triangle ||
            apply_cut(input_.surface, partition_, {part_, triangles, near, kind, input_.least_area}) < 2)
            return false;
        part_ = partition_.part_of_triangle[ahead];
        return true;
    }

    const PrintedCuts& input_;
    const DecomposeOptions& options_;
    Partition& partition_;
    std::uint32_t part_;
    std::vector<double> distance_, strength_;
    std::vector<Locale> locales_;
};

}  // namespace

std::vector<double> boundary_strength(const std::vector<double>& area, double width)
{
    std::vector<double> strength(area.size(), 0);
    for (std::size_t k = 1; k < area.size(); ++k) strength[k] = (area[k] - area[k - 1]) / (2 * std::numbers::pi * width * width);
    return strength;
}

void cut_as_printed(const PrintedCuts& input, const DecomposeOptions& options, Partition& partition)
{
    for (const std::uint32_t feature : input.features) Advance(input, options, feature, partition).run();
}

LocaleBands locale_bands(const mesh::Mesh& mesh, const Decomposition& found, const DecomposeOptions& options)
{
    const CutSurface surface(mesh);
    GeodesicSolver geodesics(mesh);
    const PrintedCuts input{
        surface, geodesics, found.curvature, found.salient_vertices, 0, options.locale_width * std::sqrt(surface.total_area)};
    std::vector<std::uint32_t> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    LocaleBands out{.width = input.width,
                    .distance = std::vector<double>(mesh.vertices.size(), k_unreached),
                    .feature = std::vector<std::uint32_t>(all.size(), LocaleBands::k_none),
                    .strength = {}};
    std::vector<double> nearest(all.size(), k_unreached), field;
    for (std::uint32_t f = 0; f < input.features.size(); ++f) {
        geodesics.run({&input.features[f], 1}, field);
        out.strength.push_back(strengths_of(locales_over(input, all, field), input.width));
        for (std::size_t v = 0; v < field.size(); ++v) out.distance[v] = std::min(out.distance[v], field[v]);
        const std::vector<double> at_centres = at_triangles(mesh, field);
        for (const std::uint32_t t : all)
            if (at_centres[t] < nearest[t]) {
                nearest[t] = at_centres[t];
                out.feature[t] = f;
            }
    }
    return out;
}

DecomposeOptions printed_cuts()
{
    DecomposeOptions options;
    options.cutting = Cutting::Printed;
    options.locale_width = 0.045;
    options.minimum_part_area = 0.016;
    options.printed_strength = 0.25;
    options.printed_curvature = 350;
    options.curvature_floor = 0;
    return options;
}

std::optional<IdleOption> idle_threshold(const DecomposeOptions& options)
{
    const DecomposeOptions plain, printed = printed_cuts();
    constexpr const char *k_passes = "is of the default cuts", *k_printed = "is of printed cuts";
    const bool passes = options.cutting == Cutting::Passes;
    // Either kind's default counts as one.
    const auto changed = [&](auto DecomposeOptions::*member) {
        return options.*member != plain.*member && options.*member != printed.*member;
    };
    const struct {
        const char* name;
        bool is_changed, is_of_passes;
        const char* cure;
    } thresholds[] = {
        {"boundary_strength", changed(&DecomposeOptions::boundary_strength), true, "give 'printed_strength'"},
        {"hyperbolic_curvature", changed(&DecomposeOptions::hyperbolic_curvature), true, "give 'printed_curvature'"},
        {"protrusion_ratio", changed(&DecomposeOptions::protrusion_ratio), true, "leave it out"},
        {"boundary_concavity", changed(&DecomposeOptions::boundary_concavity), true, "leave it out"},
        {"fragment_roundness", changed(&DecomposeOptions::fragment_roundness), true, "leave it out"},
        {"printed_strength", changed(&DecomposeOptions::printed_strength), false, "set 'cuts' to printed"},
        {"printed_curvature", changed(&DecomposeOptions::printed_curvature), false, "set 'cuts' to printed"},
        {"mean_curvature", changed(&DecomposeOptions::curvature_mean), false, "set 'cuts' to printed"}};
    for (const auto& t : thresholds)
        if (t.is_changed && t.is_of_passes != passes) return IdleOption{t.name, t.is_of_passes ? k_passes : k_printed, t.cure};
    if (options.protrusion == ProtrusionSum::Exact && changed(&DecomposeOptions::protrusion_sources))
        return IdleOption{"protrusion_sources", "is of the sampled sum of eq. 4", "leave out 'exact_geodesics'"};
    return std::nullopt;
}

}  // namespace sqmap::decompose
