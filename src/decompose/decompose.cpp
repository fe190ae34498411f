// Steps 1 to 3 of section 3: salient features, locales and Boundary Strength, curvature, cuts locale by locale.
#include "sqmap/decompose/decompose.h"

#include "curvature.h"
#include "cut.h"
#include "geodesic.h"
#include "partition.h"
#include "saliency.h"

#include <algorithm>
#include <cmath>
#include <functional>
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

// Rise of Boundary Strength at band k, free of scale: a locale's radius grows by the geodesic distance itself on flat
// ground, so growth per distance is 0 on a cylinder and 1 on a plane. Taken over one radius to either side.
struct Growth {
    double before, after;
};

Growth growth_at(const Locales& l, std::ptrdiff_t k, double radius)
{
    const auto reach = std::max<std::ptrdiff_t>(2, static_cast<std::ptrdiff_t>(std::lround(radius / l.width)));
    const double distance = static_cast<double>(reach) * l.width;
    const double here = l.mean_radius(k - 1, k + 1);
    return {(here - l.mean_radius(k - reach - 1, k - reach + 1)) / distance, (l.mean_radius(k + reach - 1, k + reach + 1) - here) / distance};
}

// The locale where a protruding part meets the rest of the body.
LocaleCut salient_cut(const Locales& l, double part_area, double height, double least_area, const DecomposeOptions& o)
{
    std::vector<LocaleCut> rises;
    double inside = 0;
    for (std::size_t k = 1; k + 2 < l.area.size(); ++k) {
        inside += l.area[k - 1];
        const auto at = static_cast<std::ptrdiff_t>(k);
        const double level = l.width * static_cast<double>(k);
        const double radius = l.mean_radius(at - 2, at);
        if (inside > 0.5 * part_area) break;
        if (inside < least_area || height + level < o.protrusion_ratio * radius || (height > 0 && level < radius)) continue;
        const Growth g = growth_at(l, at, radius);
        const double strength = g.after - std::max(g.before, -o.boundary_strength);
        if (g.after > 0.5 * o.boundary_strength && strength > o.boundary_strength)
            rises.push_back({true, level, radius, inside, strength});
    }
    // The first rise counts, unless a clearly stronger one follows before the body has widened to another scale.
    for (const LocaleCut& rise : rises) {
        bool first = true;
        for (const LocaleCut& other : rises) {
            const bool close = std::abs(other.level - rise.level) < rise.radius;
            const double weight = close ? 1.0 : (other.level > rise.level && other.radius < 2 * rise.radius ? 0.6 : 0.0);
            first = first && weight * other.strength <= rise.strength;
        }
        if (first) return rise;
    }
    return {};
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
        protrusion_ = protrusion_at_vertices(mesh_, geodesics_, options_);
        out.protrusion = at_triangles(mesh_, protrusion_);
        out.curvature = gaussian_curvature(mesh_, surface_.graph, options_.curvature_window, surface_.total_area / 8000);
        curvature_ = out.curvature;
        partition_ = components(surface_);
        for (const auto v : salient_vertices(mesh_, geodesics_, protrusion_, options_.salient_window * root_area_, options_.salient_prominence))
            out.salient_triangles.push_back(geodesics_.around(v).front());
        cut_salient(out.salient_triangles);
        cut_within_parts();
        merge_needless();
        order_by_area(surface_, partition_);
        out.partition = partition_;
        return out;
    }

private:
    // Where locales start: a salient feature, or the rim that the last cut of that feature left on the body.
    struct Front {
        std::vector<std::uint32_t> sources;
        double height = 0;  // geodesic height of what was cut off before
    };

    LocaleCut locale_cut(const Front& front, std::vector<std::uint32_t>& triangles, std::vector<double>& field)
    {
        const std::uint32_t part = partition_.part_of_triangle[front.sources.front()];
        triangles = triangles_of(partition_, part);
        geodesics_.run(front.sources, field, k_unreached, partition_.part_of_triangle, part);
        return salient_cut(locales_of(mesh_, triangles, field, curvature_, width_), area_of(triangles), front.height, least_area_, options_);
    }

    double area_of(std::span<const std::uint32_t> triangles) const
    {
        double sum = 0;
        for (const auto t : triangles) sum += surface_.area[t];
        return sum;
    }

    // Locales are cut off from the features inwards, the smallest piece first: ears are gone when the head is measured.
    void cut_salient(const std::vector<std::uint32_t>& features)
    {
        std::vector<std::uint32_t> triangles;
        std::vector<double> field;
        std::vector<Front> fronts;
        using Entry = std::pair<double, std::size_t>;  // area cut off, front
        std::vector<Entry> queue;
        const auto push = [&](double area, std::size_t front) {
            queue.emplace_back(area, front);
            std::push_heap(queue.begin(), queue.end(), std::greater<>());
        };
        for (const auto f : features) {
            fronts.push_back({{f}, 0});
            if (const LocaleCut cut = locale_cut(fronts.back(), triangles, field); cut.found) push(cut.area, fronts.size() - 1);
        }
        while (!queue.empty() && partition_.part_count < options_.maximum_parts) {
            std::pop_heap(queue.begin(), queue.end(), std::greater<>());
            const auto [area, f] = queue.back();
            queue.pop_back();
            const LocaleCut cut = locale_cut(fronts[f], triangles, field);
            if (!cut.found) continue;
            if (!queue.empty() && cut.area > 1.01 * area && cut.area > queue.front().first) {  // no longer the smallest
                push(cut.area, f);
                continue;
            }
            const std::uint32_t source = fronts[f].sources.front();
            const auto near = best_cut(surface_, triangles, at_triangles(mesh_, field), cut.level, 0.6 * cut.radius, cut.radius);
            if (apply_cut(surface_, partition_, partition_.part_of_triangle[source], triangles, near, CutKind::Salient, least_area_) < 2) continue;
            const std::uint32_t piece = partition_.part_of_triangle[source];
            Front rim{{}, fronts[f].height + cut.level};
            std::uint32_t body = mesh::k_no_triangle;  // the rim lies on the largest neighbour
            double longest = 0;
            for (const Boundary& b : partition_.boundaries)
                if ((b.part_a == piece || b.part_b == piece) && b.length > longest) {
                    longest = b.length;
                    body = b.part_a == piece ? b.part_b : b.part_a;
                }
            for (const auto t : triangles) {
                if (partition_.part_of_triangle[t] != body) continue;
                for (const auto o : surface_.graph.neighbours[t])
                    if (o != mesh::k_no_triangle && partition_.part_of_triangle[o] == piece) {
                        rim.sources.push_back(t);
                        break;
                    }
            }
            if (rim.sources.empty()) continue;
            fronts.push_back(std::move(rim));
            if (const LocaleCut next = locale_cut(fronts.back(), triangles, field); next.found) push(next.area, fronts.size() - 1);
        }
    }

    // Fragments, parts with a long border for their area, join the neighbour that takes them with the least loss; so do
    // neighbours that one ellipsoid serves nearly as well as two.
    void merge_needless()
    {
        std::vector<double> volume, area, border;
        while (true) {
            const std::uint32_t n = partition_.part_count;
            volume.assign(n, 0);
            area.assign(n, 0);
            border.assign(n, 0);
            for (std::uint32_t p = 0; p < n; ++p) {
                const auto triangles = triangles_of(partition_, p);
                volume[p] = ellipsoid_volume(mesh_, triangles);
                area[p] = area_of(triangles);
            }
            for (const Boundary& b : partition_.boundaries) {
                border[b.part_a] += b.length;
                border[b.part_b] += b.length;
            }
            const auto fragment = [&](std::uint32_t p) {
                return 4 * std::numbers::pi * area[p] < options_.fragment_roundness * border[p] * border[p];
            };
            double least = k_unreached;
            const Boundary* needless = nullptr;
            for (const Boundary& b : partition_.boundaries) {
                auto both = triangles_of(partition_, b.part_a);
                const auto second = triangles_of(partition_, b.part_b);
                both.insert(both.end(), second.begin(), second.end());
                const std::uint32_t smaller = area[b.part_a] < area[b.part_b] ? b.part_a : b.part_b;
                const double loss = ellipsoid_volume(mesh_, both) - volume[b.part_a] - volume[b.part_b];
                const bool joins = fragment(smaller) || (b.kind != CutKind::Salient && loss < options_.needless_loss * (volume[b.part_a] + volume[b.part_b]) &&
                                                         loss < 0.5 * volume[smaller]);
                if (joins && loss / volume[smaller] < least) {
                    least = loss / volume[smaller];
                    needless = &b;
                }
            }
            if (!needless) return;
            apply_merge(surface_, partition_, needless->part_a, needless->part_b);
        }
    }

    // Parts that one convex shape cannot serve are cut further, locale by locale from their most protruding point, where
    // a locale passes the curvature test or Boundary Strength changes.
    void cut_within_parts()
    {
        for (std::uint32_t part = 0; part < partition_.part_count && partition_.part_count < options_.maximum_parts;)
            if (!cut_within(part)) ++part;
    }

    bool cut_within(std::uint32_t part)
    {
        const auto triangles = triangles_of(partition_, part);
        const double part_area = area_of(triangles);
        if (part_area < 2 * least_area_) return false;
        std::uint32_t seed = triangles.front();
        double highest = -1;
        for (const auto t : triangles)
            for (const auto v : mesh_.triangles[t])
                if (protrusion_[v] > highest) {
                    highest = protrusion_[v];
                    seed = t;
                }
        std::vector<double> field;
        geodesics_.run({&seed, 1}, field, k_unreached, partition_.part_of_triangle, part);
        const Locales l = locales_of(mesh_, triangles, field, curvature_, width_);
        const auto at_centres = at_triangles(mesh_, field);
        const double whole = ellipsoid_volume(mesh_, triangles);

        struct Best {
            double gain = 0;
            CutKind kind{};
            Partition partition;
        } best;
        double inside = 0;
        for (std::size_t k = 1; k + 1 < l.area.size(); ++k) {
            inside += l.area[k - 1];
            if (inside < least_area_ || part_area - inside < least_area_) continue;
            const auto at = static_cast<std::ptrdiff_t>(k);
            const double radius = l.mean_radius(at - 1, at + 1);
            const bool hyperbolic = l.hyperbolic_area[k] > options_.hyperbolic_share * l.area[k] &&
                                    -l.hyperbolic_curvature[k] * inside > options_.hyperbolic_curvature;
            const Growth g = growth_at(l, at, radius);
            const bool stepped = std::abs(g.after - g.before) > options_.boundary_strength;
            if (!hyperbolic && !stepped) continue;
            const auto near = best_cut(surface_, triangles, at_centres, l.width * static_cast<double>(k), 0.5 * radius, radius);
            Partition trial = partition_;
            const std::uint32_t before = trial.part_count;
            const CutKind kind = hyperbolic ? CutKind::Curvature : CutKind::Salient;
            if (apply_cut(surface_, trial, part, triangles, near, kind, least_area_) < 2) continue;
            double sum = ellipsoid_volume(mesh_, triangles_of(trial, part));
            for (std::uint32_t p = before; p < trial.part_count; ++p) sum += ellipsoid_volume(mesh_, triangles_of(trial, p));
            if (const double gain = 1 - sum / whole; gain > best.gain) best = {gain, kind, std::move(trial)};
        }
        if (best.gain < options_.least_gain) return false;
        partition_ = std::move(best.partition);
        return true;
    }

    const mesh::Mesh& mesh_;
    const DecomposeOptions& options_;
    CutSurface surface_;
    GeodesicSolver geodesics_;
    double root_area_, least_area_, width_;
    std::vector<double> protrusion_, curvature_;
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
