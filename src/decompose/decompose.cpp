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
#include <map>
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
    return {(here - l.mean_radius(k - reach - 1, k - reach + 1)) / distance,
            (l.mean_radius(k + reach - 1, k + reach + 1) - here) / distance};
}

// Limits of a salient cut.
struct Limits {
    double part_area, least_area;  // of the part that is cut, and of a piece
    double height;                 // geodesic height of the parts cut off before
    double least_level;            // cuts up to this level were tried without success
};

// The locale where a protruding part meets the rest of the body.
LocaleCut salient_cut(const Locales& l, const Limits& limits, const DecomposeOptions& o)
{
    const auto [part_area, least_area, height, least_level] = limits;
    std::vector<LocaleCut> rises;
    double inside = 0;
    for (std::size_t k = 1; k + 2 < l.area.size(); ++k) {
        inside += l.area[k - 1];
        const auto at = static_cast<std::ptrdiff_t>(k);
        const double level = l.width * static_cast<double>(k);
        const double radius = l.mean_radius(at - 2, at);
        if (inside > 0.5 * part_area) break;
        if (level <= least_level || inside < least_area || height + level < o.protrusion_ratio * radius ||
            (height > 0 && level < radius))
            continue;
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
            const double weight = close ? 1.0 : (other.level > rise.level && other.radius < 1.5 * rise.radius ? 0.6 : 0.0);
            first = first && weight * other.strength <= rise.strength;
        }
        if (first) return rise;
    }
    return {};
}

class Decomposer {
public:
    Decomposer(const mesh::Mesh& mesh, const DecomposeOptions& options)
        : mesh_(mesh),
          options_(options),
          surface_(mesh),
          geodesics_(mesh),
          root_area_(std::sqrt(surface_.total_area)),
          least_area_(options.minimum_part_area * surface_.total_area),
          width_(options.locale_width * root_area_)
    {
    }

    Decomposition run()
    {
        Decomposition out;
        protrusion_ = protrusion_at_vertices(mesh_, geodesics_, options_);
        out.protrusion = at_triangles(mesh_, protrusion_);
        out.curvature =
            gaussian_curvature(mesh_, surface_.graph, options_.curvature_window, options_.curvature_floor * surface_.total_area);
        curvature_ = out.curvature;
        partition_ = components(surface_);
        for (const auto v : salient_vertices(mesh_, geodesics_, protrusion_,
                                             {options_.salient_window * root_area_, options_.salient_prominence}))
            out.salient_vertices.push_back(v);
        if (options_.cutting == Cutting::Printed) {
            cut_as_printed({surface_, geodesics_, curvature_, out.salient_vertices, least_area_, width_}, options_, partition_);
        } else {
            cut_salient(out.salient_vertices);
            cut_bends();
            merge_fragments();
        }
        order_by_area(surface_, partition_);
        out.partition = partition_;
        return out;
    }

private:
    // The start of locales: a salient feature, or the rim that the last cut of that feature left on the body.
    struct Front {
        std::vector<std::uint32_t> sources;  // vertices
        std::vector<std::uint32_t> ahead;    // triangles at the sources, on the side away from the feature
        double height = 0;                   // geodesic height of the parts cut off before
        double least_level = 0;              // cuts up to this level were tried without success
        LocaleCut cut{};                     // the cut that waits
    };

    LocaleCut locale_cut(const Front& front, std::vector<std::uint32_t>& triangles, std::vector<double>& field)
    {
        const std::uint32_t part = main_part(front.ahead);
        triangles = triangles_of(partition_, part);
        geodesics_.run(front.sources, field, k_unreached, region(part));
        return salient_cut(locales_of(mesh_, triangles, {field, curvature_}, width_),
                           {surface_.area_of(triangles), least_area_, front.height, front.least_level}, options_);
    }

    GeodesicSolver::Region region(std::uint32_t part) const { return {partition_.part_of_triangle, part}; }

    // The part that has most of the area of some triangles.
    std::uint32_t main_part(std::span<const std::uint32_t> triangles) const
    {
        std::vector<double> area(partition_.part_count, 0.0);
        for (const auto t : triangles) area[partition_.part_of_triangle[t]] += surface_.area[t];
        return static_cast<std::uint32_t>(std::max_element(area.begin(), area.end()) - area.begin());
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
        const auto propose = [&](std::size_t f) {
            fronts[f].cut = locale_cut(fronts[f], triangles, field);
            if (fronts[f].cut.found) push(fronts[f].cut.area, f);
        };
        for (const auto f : features) {
            fronts.push_back({{f}, {geodesics_.around(f).begin(), geodesics_.around(f).end()}});
            propose(fronts.size() - 1);
        }
        while (!queue.empty() && partition_.part_count < options_.max_parts) {
            std::pop_heap(queue.begin(), queue.end(), std::greater<>());
            const auto [area, f] = queue.back();
            queue.pop_back();
            // The body may have lost what made the rise (the other ear or leg): then the cut found before still stands.
            LocaleCut cut = locale_cut(fronts[f], triangles, field);
            if (!cut.found || cut.level > fronts[f].cut.level + fronts[f].cut.radius) cut = fronts[f].cut;
            if (!queue.empty() && cut.area > 1.01 * area && cut.area > queue.front().first) {  // no longer the smallest
                fronts[f].cut = cut;
                push(cut.area, f);
                continue;
            }
            const std::uint32_t part = main_part(fronts[f].ahead);
            const Crease crease = crease_at(cut, triangles, at_triangles(mesh_, field));
            // Parts meet in a concavity (the minima rule), unless a feature is slender or set off beyond doubt.
            const bool clear = fronts[f].height == 0 && (cut.level > 2 * options_.protrusion_ratio * cut.radius ||
                                                         cut.strength > 2 * options_.boundary_strength);
            const bool meets = clear || crease.concavity > options_.boundary_concavity;
            if (!meets || apply_cut(surface_, partition_, {part, triangles, crease.near, CutKind::Salient, least_area_}) < 2) {
                fronts[f].least_level = cut.level + 0.5 * cut.radius;
                propose(f);
                continue;
            }
            Front rim = rim_left_by(crease.near, triangles);
            if (rim.sources.empty()) continue;
            rim.height = fronts[f].height + cut.level;
            fronts.push_back(std::move(rim));
            propose(fronts.size() - 1);
        }
    }

    // The course of a salient cut: one byte per triangle of the part, and the concavity along the best crease.
    struct Crease {
        std::vector<std::uint8_t> near;
        double concavity = 0;
    };

    Crease crease_at(const LocaleCut& cut, std::span<const std::uint32_t> triangles, std::span<const double> field)
    {
        Crease crease{best_cut(surface_, triangles, field, {cut.level, 1.0 * cut.radius, cut.radius})};
        const auto concavity = [&](const std::vector<std::uint8_t>& near) {
            return mean_concavity(surface_, triangles, near, cut.radius);
        };
        crease.concavity = concavity(crease.near);
        // A locale that meets a slanted crease only in part: once more around the cut itself, kept if it is a better crease.
        std::vector<std::uint8_t> again = around_cut(triangles, crease.near, 0.7 * cut.radius, cut.radius);
        if (const double of_again = concavity(again); of_again > crease.concavity + 0.15) crease = {std::move(again), of_again};
        if (crease.concavity < options_.boundary_concavity)  // nothing to hold on to: stay at the locale
            crease.near = best_cut(surface_, triangles, field, {cut.level, 0.4 * cut.radius, cut.radius});
        return crease;
    }

    // The rim that a cut has left on the largest neighbour of the part cut off.
    Front rim_left_by(std::span<const std::uint8_t> near, std::span<const std::uint32_t> triangles) const
    {
        std::vector<std::uint32_t> cut_off;
        for (std::size_t i = 0; i < triangles.size(); ++i)
            if (near[i]) cut_off.push_back(triangles[i]);
        const std::uint32_t piece = main_part(cut_off);
        std::uint32_t body = mesh::k_no_triangle;
        double longest = 0;
        for (const Boundary& b : partition_.boundaries)
            if ((b.part_a == piece || b.part_b == piece) && b.length > longest) {
                longest = b.length;
                body = b.part_a == piece ? b.part_b : b.part_a;
            }
        Front rim;
        for (const auto t : triangles)
            for (int e = 0; e < 3; ++e) {
                const std::uint32_t o = surface_.graph.neighbours[t][e];
                if (partition_.part_of_triangle[t] != body || o == mesh::k_no_triangle || partition_.part_of_triangle[o] != piece)
                    continue;
                rim.sources.push_back(mesh_.triangles[t][e]);
                rim.sources.push_back(mesh_.triangles[t][(e + 1) % 3]);
                rim.ahead.push_back(t);
            }
        return rim;
    }

    // The best cut within a geodesic band around a cut.
    std::vector<std::uint8_t> around_cut(std::span<const std::uint32_t> triangles, const std::vector<std::uint8_t>& near,
                                         double band, double radius)
    {
        std::vector<std::uint8_t> side(surface_.area.size(), 2);
        for (std::size_t i = 0; i < triangles.size(); ++i) side[triangles[i]] = near[i];
        std::vector<std::uint32_t> sources;
        for (const auto t : triangles)
            for (int e = 0; e < 3; ++e) {
                const std::uint32_t o = surface_.graph.neighbours[t][e];
                if (o == mesh::k_no_triangle || side[o] == 2 || side[o] == side[t]) continue;
                sources.push_back(mesh_.triangles[t][e]);
                sources.push_back(mesh_.triangles[t][(e + 1) % 3]);
            }
        if (sources.empty()) return near;
        std::vector<double> distance;
        geodesics_.run(sources, distance, k_unreached, region(partition_.part_of_triangle[triangles.front()]));
        auto field = at_triangles(mesh_, distance);
        for (std::size_t i = 0; i < triangles.size(); ++i)
            if (near[i]) field[triangles[i]] *= -1;
        return best_cut(surface_, triangles, field, {0.0, band, radius});
    }

    // The rims of a part: the vertices of its border with other parts, by loop, the most protruding loop first.
    std::vector<std::vector<std::uint32_t>> rims_of(std::uint32_t part, std::span<const std::uint32_t> triangles) const
    {
        std::map<std::uint32_t, std::vector<std::uint32_t>> next;  // along the border, both ways
        for (const auto t : triangles)
            for (int e = 0; e < 3; ++e) {
                const std::uint32_t o = surface_.graph.neighbours[t][e];
                if (o != mesh::k_no_triangle && partition_.part_of_triangle[o] == part) continue;
                const std::uint32_t a = mesh_.triangles[t][e], b = mesh_.triangles[t][(e + 1) % 3];
                next[a].push_back(b);
                next[b].push_back(a);
            }
        std::vector<std::vector<std::uint32_t>> rims;
        while (!next.empty()) {
            auto& rim = rims.emplace_back(1, next.begin()->first);
            for (std::size_t i = 0; i < rim.size(); ++i)
                if (auto node = next.extract(rim[i]); !node.empty())
                    for (const auto v : node.mapped())
                        if (next.contains(v)) rim.push_back(v);
            std::sort(rim.begin(), rim.end());
            rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
        }
        const auto height = [&](const std::vector<std::uint32_t>& rim) {
            double sum = 0;
            for (const auto v : rim) sum += protrusion_[v];
            return sum / static_cast<double>(rim.size());
        };
        std::stable_sort(rims.begin(), rims.end(), [&](const auto& a, const auto& b) { return height(a) > height(b); });
        return rims;
    }

    // Tubes are cut where they bend. The negative curvature of a tube that turns by an angle amounts to twice that angle,
    // so a part is given as many pieces as its hyperbolic locales' curvature makes up t_h, with equal shares of it.
    // A body that three parts or more grow from is no tube: its saddles are theirs.
    void cut_bends()
    {
        for (std::uint32_t part = 0; part < partition_.part_count && partition_.part_count < options_.max_parts;)
            if (!cut_bend(part)) ++part;
    }

    bool cut_bend(std::uint32_t part)
    {
        const auto triangles = triangles_of(partition_, part);
        const double part_area = surface_.area_of(triangles);
        if (part_area < 2 * least_area_) return false;
        const auto rims = rims_of(part, triangles);
        if (rims.size() > 2) return false;
        const std::vector<std::uint32_t> sources =
            rims.size() == 2 ? rims[0] : std::vector<std::uint32_t>{max_protruding(triangles)};
        std::vector<double> field;
        geodesics_.run(sources, field, k_unreached, region(part));
        if (rims.size() == 2) {  // between two rims, locales turn from the one into the other
            std::vector<double> other;
            geodesics_.run(rims[1], other, k_unreached, region(part));
            double length = 0;
            for (const auto v : rims[1]) length += field[v] / static_cast<double>(rims[1].size());
            for (const auto v : geodesics_.reached())
                field[v] = field[v] + other[v] > 0 ? length * field[v] / (field[v] + other[v]) : 0;
        }
        const Locales l = locales_of(mesh_, triangles, {field, curvature_}, width_);
        const auto hyperbolic = [&](std::size_t k) { return l.hyperbolic_area[k] > options_.hyperbolic_share * l.area[k]; };
        // In a bend the outer side is as elliptic as the inner is hyperbolic. A waist is hyperbolic all around: no bend.
        const auto bending = [&](std::size_t k) {
            return hyperbolic(k) ? std::min(-l.hyperbolic_curvature[k] * l.hyperbolic_area[k], l.elliptic_curvature[k]) : 0.0;
        };
        double total = 0;
        for (std::size_t k = 0; k < l.area.size(); ++k) total += bending(k);
        const double pieces = std::round(total / options_.hyperbolic_curvature);
        if (pieces < 2) return false;
        double sum = 0, inside = 0;
        const auto at_centres = at_triangles(mesh_, field);
        for (std::size_t k = 1; k + 1 < l.area.size(); ++k) {
            inside += l.area[k - 1];
            sum += bending(k - 1);
            const double radius = l.mean_radius(static_cast<std::ptrdiff_t>(k) - 1, static_cast<std::ptrdiff_t>(k) + 2);
            const double level = l.width * static_cast<double>(k), rest = l.width * static_cast<double>(l.area.size() - k);
            if (sum < total / pieces || !hyperbolic(k) || inside < least_area_ || std::min(level, rest) < radius) continue;
            const auto near = best_cut(surface_, triangles, at_centres, {level, 0.5 * radius, radius});
            if (apply_cut(surface_, partition_, {part, triangles, near, CutKind::Curvature, least_area_}) > 1) return true;
        }
        return false;
    }

    std::uint32_t max_protruding(std::span<const std::uint32_t> triangles) const
    {
        std::uint32_t best = mesh_.triangles[triangles.front()][0];
        for (const auto t : triangles)
            for (const auto v : mesh_.triangles[t])
                if (protrusion_[v] > protrusion_[best]) best = v;
        return best;
    }

    // Fragments, parts with a long border for their area, join the neighbour that takes them with the least loss of
    // tightness: a ring goes to the limb rather than to the body.
    void merge_fragments()
    {
        while (true) {
            const std::uint32_t n = partition_.part_count;
            std::vector<double> area(n), border(n, 0.0);
            std::vector<std::vector<std::uint32_t>> triangles(n);
            for (std::uint32_t p = 0; p < n; ++p) {
                triangles[p] = triangles_of(partition_, p);
                area[p] = surface_.area_of(triangles[p]);
            }
            for (const Boundary& b : partition_.boundaries) {
                border[b.part_a] += b.length;
                border[b.part_b] += b.length;
            }
            std::uint32_t fragment = n;
            double worst = options_.fragment_roundness;
            for (std::uint32_t p = 0; p < n; ++p)
                if (const double round = 4 * std::numbers::pi * area[p] / (border[p] * border[p]);
                    border[p] > 0 && round < worst) {
                    // A body that many parts grow from has a long border too.
                    const auto larger = [&](const Boundary& b) {
                        return (b.part_a == p && area[b.part_b] > area[p]) || (b.part_b == p && area[b.part_a] > area[p]);
                    };
                    if (std::none_of(partition_.boundaries.begin(), partition_.boundaries.end(), larger)) continue;
                    worst = round;
                    fragment = p;
                }
            if (fragment == n) return;
            double least = k_unreached;
            std::uint32_t into = n;
            for (const Boundary& b : partition_.boundaries) {
                if (b.part_a != fragment && b.part_b != fragment) continue;
                const std::uint32_t other = b.part_a == fragment ? b.part_b : b.part_a;
                auto both = triangles[other];
                both.insert(both.end(), triangles[fragment].begin(), triangles[fragment].end());
                const double loss = ellipsoid_volume(surface_, both) - ellipsoid_volume(surface_, triangles[other]);
                if (loss < least) {
                    least = loss;
                    into = other;
                }
            }
            apply_merge(surface_, partition_, into, fragment);
        }
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
