// Named parts by the minima rule: D. D. Hoffman, W. A. Richards, "Parts of recognition", Cognition 18, 1984: people cut where a
// surface is concave. Regions are merged as in A. Golovinskiy, T. Funkhouser, "Randomized cuts for 3D mesh analysis", ACM
// Trans. Graph. 27(5), 2008 (their hierarchical clustering), by the bend of their border.
#include "decompose/named_parts.h"

#include "cut.h"
#include "mirror.h"
#include "partition.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

namespace sqmap::decompose {

namespace {

using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// An edge between two parts: the triangles on either side, the one of the part with the lower number first.
struct BorderEdge {
    std::uint32_t triangle[2];
    double length;
};

/// How far the surface bends inwards along a border, radians times length, and the border's length.
struct Bend {
    double sum = 0, length = 0;
    [[nodiscard]] double mean() const { return length > 0 ? sum / length : 0; }
};

/// Directions and centres of the surface on one side of a border, an entry an edge.
struct Sides {
    std::vector<Vec3d> normal, centre;
};

/// The surface beside a border up to a distance, each triangle with the edge of the border that is nearest in its part.
class Surroundings {
public:
    explicit Surroundings(const CutSurface& surface)
        : surface_(surface), distance_(surface.area.size(), k_unreached), edge_of_(surface.area.size())
    {
        for (std::uint32_t t = 0; t < surface.area.size(); ++t) centre_.push_back(mesh::triangle_centroid(surface.mesh, t));
    }

    Sides beside(std::span<const BorderEdge> border, int side, double reach, std::span<const std::uint32_t> part_of_triangle)
    {
        std::vector<Vec3d> normal(border.size()), centre(border.size());
        std::vector<double> area(border.size(), 0.0);
        std::vector<std::pair<double, std::uint32_t>> heap;
        std::vector<std::uint32_t> touched;
        for (std::uint32_t e = 0; e < border.size(); ++e) {
            const std::uint32_t t = border[e].triangle[side];
            if (distance_[t] == 0) continue;  // several edges of a triangle share its surroundings
            edge_of_[t] = e;
            distance_[t] = 0;
            touched.push_back(t);
            heap.emplace_back(0.0, t);
        }
        std::make_heap(heap.begin(), heap.end(), std::greater<>());
        while (!heap.empty()) {
            std::pop_heap(heap.begin(), heap.end(), std::greater<>());
            const auto [d, t] = heap.back();
            heap.pop_back();
            if (d > distance_[t]) continue;
            const std::uint32_t e = edge_of_[t];
            const mesh::Triangle& tri = surface_.mesh.triangles[t];
            const std::vector<Vec3d>& v = surface_.mesh.vertices;
            normal[e] += cross(v[tri[1]] - v[tri[0]], v[tri[2]] - v[tri[0]]);
            centre[e] += surface_.area[t] * centre_[t];
            area[e] += surface_.area[t];
            for (const std::uint32_t o : surface_.graph.neighbours[t]) {
                if (o == mesh::k_no_triangle || part_of_triangle[o] != part_of_triangle[t]) continue;
                const double to = d + norm(centre_[o] - centre_[t]);
                if (to > reach || to >= distance_[o]) continue;
                if (distance_[o] == k_unreached) touched.push_back(o);
                distance_[o] = to;
                edge_of_[o] = e;
                heap.emplace_back(to, o);
                std::push_heap(heap.begin(), heap.end(), std::greater<>());
            }
        }
        for (const std::uint32_t t : touched) distance_[t] = k_unreached;
        Sides out;
        for (const BorderEdge& edge : border) {
            const std::uint32_t e = edge_of_[edge.triangle[side]];
            out.normal.push_back(sqmap::normalized(normal[e]));
            out.centre.push_back(area[e] > 0 ? centre[e] / area[e] : centre_[edge.triangle[side]]);
        }
        return out;
    }

private:
    const CutSurface& surface_;
    std::vector<Vec3d> centre_;
    std::vector<double> distance_;        ///< scratch, k_unreached between calls
    std::vector<std::uint32_t> edge_of_;  ///< scratch: the nearest edge of a triangle that was reached
};

/// The borders between parts, by pair.
std::map<Pair, std::vector<BorderEdge>> borders_of(const CutSurface& s, const Partition& partition)
{
    std::map<Pair, std::vector<BorderEdge>> borders;
    for (std::uint32_t t = 0; t < s.area.size(); ++t)
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t o = s.graph.neighbours[t][e];
            if (o == mesh::k_no_triangle || o < t) continue;
            const std::uint32_t a = partition.part_of_triangle[t], b = partition.part_of_triangle[o];
            if (a < b) borders[{a, b}].push_back({{t, o}, s.edge_length[t][e]});
            if (b < a) borders[{b, a}].push_back({{o, t}, s.edge_length[t][e]});
        }
    return borders;
}

/// The angle by which the surface turns inwards across a border, where it does; convex edges count as flat. Directions are means
/// over half the radius of a circle as long as the border, so that noise and a cut beside its crease matter little.
Bend bend_of(Surroundings& surroundings, std::span<const BorderEdge> border, std::span<const std::uint32_t> part_of_triangle)
{
    Bend bend;
    for (const BorderEdge& edge : border) bend.length += edge.length;
    const double reach = 0.5 * bend.length / (2 * std::numbers::pi);
    const Sides a = surroundings.beside(border, 0, reach, part_of_triangle);
    const Sides b = surroundings.beside(border, 1, reach, part_of_triangle);
    for (std::size_t e = 0; e < border.size(); ++e) {
        if (dot(a.normal[e] - b.normal[e], b.centre[e] - a.centre[e]) <= 0) continue;
        bend.sum += border[e].length * std::atan2(norm(cross(a.normal[e], b.normal[e])), dot(a.normal[e], b.normal[e]));
    }
    return bend;
}

/// The part at the mirror image of each: itself where no part has most of it, or without a mirror.
std::vector<std::uint32_t> images_of(const mesh::Mesh& mesh, const Partition& partition, const Mirror* mirror)
{
    std::vector<std::uint32_t> image(partition.part_count);
    std::iota(image.begin(), image.end(), 0u);
    if (mirror == nullptr) return image;
    std::map<Pair, double> shared;
    std::vector<double> area(partition.part_count, 0.0);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint32_t part = partition.part_of_triangle[t], o = mirror->of_triangle[t];
        const double a = mesh::triangle_area(mesh, t);
        area[part] += a;
        if (o != mesh::k_no_triangle) shared[{part, partition.part_of_triangle[o]}] += a;
    }
    for (const auto& [pair, common] : shared)
        if (2 * common > area[pair.first]) image[pair.first] = pair.second;
    return image;
}

/// The parts at the mirror images of two.
Pair images(const std::vector<std::uint32_t>& image, const Pair& pair)
{
    const std::uint32_t a = image[pair.first], b = image[pair.second];
    return {std::min(a, b), std::max(a, b)};
}

/// A border bends as much as its mirror image.
void bend_with_images(std::map<Pair, Bend>& bends, const std::vector<std::uint32_t>& image)
{
    const std::map<Pair, Bend> single = bends;
    for (auto& [pair, bend] : bends) {
        const auto it = single.find(images(image, pair));
        const Bend& other = it != single.end() ? it->second : single.at(pair);
        bend.sum = bend.length * std::max(bend.mean(), other.mean());
    }
}

/// Joins b to a.
void join(std::map<Pair, Bend>& bends, std::uint32_t a, std::uint32_t b)
{
    std::map<Pair, Bend> joined;
    for (const auto& [pair, bend] : bends) {
        const std::uint32_t x = pair.first == b ? a : pair.first, y = pair.second == b ? a : pair.second;
        if (x == y) continue;
        Bend& sum = joined[{std::min(x, y), std::max(x, y)}];
        sum.sum += bend.sum;
        sum.length += bend.length;
    }
    bends = std::move(joined);
}

/// Finds the most concave cut of each part, and keeps it: other cuts leave it as it is.
class CreaseFinder {
public:
    CreaseFinder(const mesh::Mesh& mesh, const CreaseOptions& options) : surface_(mesh), options_(options) {}

    /// Makes the most concave cut; false where none is concave enough.
    bool cut(Partition& partition)
    {
        const Found* deepest = nullptr;
        PartCut best{0, {}, {}, CutKind::Crease, least_area()};
        for (std::uint32_t part = 0; part < partition.part_count; ++part) {
            const auto [it, is_new] = found_.try_emplace(triangles_of(partition, part));
            if (is_new) it->second = found_in(it->first);
            if (!(it->second.merit > (deepest != nullptr ? deepest->merit : 1))) continue;
            deepest = &it->second;
            best.part = part;
            best.triangles = it->first;
        }
        if (deepest == nullptr) return false;
        best.near = deepest->near;
        return apply_cut(surface_, partition, best) > 1;
    }

private:
    struct Found {
        double merit = 0;  ///< bend or gain over the least one
        std::vector<std::uint8_t> near;
    };

    [[nodiscard]] double least_area() const { return options_.least_area * surface_.total_area; }

    /// Candidates are judged on the part alone.
    [[nodiscard]] Found found_in(std::span<const std::uint32_t> triangles) const
    {
        Found best;
        if (surface_.area_of(triangles) < 2 * least_area()) return best;
        const PartSurface part(surface_, triangles);
        const CutSurface& own = part.surface();
        const std::vector<std::uint32_t> all = all_triangles(own);
        Surroundings surroundings(own);
        for (CandidateCut& candidate : candidate_cuts(own, least_area())) {
            Partition halves{std::vector<std::uint32_t>(all.size(), 0), 1, {}};
            if (apply_cut(own, halves, {0, all, candidate.near, CutKind::Crease, least_area()}) != 2) continue;
            const double bend = bend_of(surroundings, borders_of(own, halves).at({0, 1}), halves.part_of_triangle).mean();
            const double by_gain = bend > options_.slight_bend ? candidate.gain / options_.least_gain : 0;
            if (const double merit = std::max(bend / options_.least_bend, by_gain); merit > best.merit)
                best = {merit, std::move(candidate.near)};
        }
        return best;
    }

    CutSurface surface_;
    const CreaseOptions& options_;
    std::map<std::vector<std::uint32_t>, Found> found_;  ///< by the part's triangles
};

/// Numbers anew from zero, in the order in which they first come.
void number_anew(std::vector<std::uint32_t>& labels)
{
    std::map<std::uint32_t, std::uint32_t> number;
    for (std::uint32_t& l : labels) l = number.try_emplace(l, static_cast<std::uint32_t>(number.size())).first->second;
}

}  // namespace

Partition cut_creases(const mesh::Mesh& mesh, Partition partition, const CreaseOptions& options)
{
    CreaseFinder finder(mesh, options);
    while (partition.part_count < options.max_parts && finder.cut(partition)) {
    }
    return partition;
}

std::vector<std::uint32_t> labels_of_parts(const Partition& partition, const std::vector<std::uint32_t>& label_of_triangle)
{
    std::vector<std::map<std::uint32_t, std::size_t>> counts(partition.part_count);
    for (std::size_t t = 0; t < label_of_triangle.size(); ++t) ++counts[partition.part_of_triangle[t]][label_of_triangle[t]];
    std::vector<std::uint32_t> labels;
    for (const auto& count : counts) {
        const auto max =
            std::max_element(count.begin(), count.end(), [](const auto& l, const auto& r) { return l.second < r.second; });
        labels.push_back(max->first);
    }
    number_anew(labels);
    return labels;
}

std::vector<std::uint32_t> named_parts(const mesh::Mesh& mesh, const Partition& partition, const NamedPartOptions& options,
                                       const Mirror* mirror)
{
    const CutSurface surface(mesh);
    Surroundings surroundings(surface);
    std::map<Pair, Bend> bends;
    for (const auto& [pair, border] : borders_of(surface, partition))
        bends[pair] = bend_of(surroundings, border, partition.part_of_triangle);
    for (const Boundary& b : partition.boundaries)
        if (const auto it = bends.find({b.part_a, b.part_b}); it != bends.end() && b.kind == CutKind::Salient)
            it->second.sum += (options.least_bend - options.salient_bend) * it->second.length;
    const std::vector<std::uint32_t> image = images_of(mesh, partition, mirror);
    bend_with_images(bends, image);
    std::vector<std::uint32_t> group(partition.part_count);
    std::iota(group.begin(), group.end(), 0u);
    while (!bends.empty()) {
        const auto flattest = std::min_element(bends.begin(), bends.end(),
                                               [](const auto& l, const auto& r) { return l.second.mean() < r.second.mean(); });
        if (flattest->second.mean() > options.least_bend) break;
        const auto [a, b] = flattest->first;
        for (const auto& [x, y] : {Pair{a, b}, images(image, {a, b})}) {
            const std::uint32_t into = std::min(group[x], group[y]), from = std::max(group[x], group[y]);
            if (!bends.contains({into, from})) continue;
            for (std::uint32_t& g : group)
                if (g == from) g = into;
            join(bends, into, from);
        }
    }
    number_anew(group);
    return group;
}

}  // namespace sqmap::decompose
