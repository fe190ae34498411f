// The best cut of one part: candidates are the level sets of geodesic fields from the part's extremes, refined to the
// least-weight cut nearby; the winner saves most bounding volume and lies in the deepest crease, for its length.
#include "cut.h"
#include "geodesic.h"
#include "partition.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::decompose {

namespace {

double cut_length(const CutSurface& s, const std::vector<std::uint8_t>& near)
{
    double length = 0;
    for (std::uint32_t t = 0; t < s.area.size(); ++t)
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t o = s.graph.neighbours[t][e];
            if (o != mesh::k_no_triangle && o > t && near[o] != near[t]) length += s.edge_length[t][e];
        }
    return length;
}

/// Geodesic distances of triangles from a surface's extremes, and the difference of the first two: its level sets bisect them.
std::vector<std::vector<double>> fields_of(const CutSurface& s)
{
    const mesh::Mesh& mesh = s.mesh;
    // Extremes: the vertex farthest from the centroid, then farthest-point sampling.
    GeodesicSolver geodesics(mesh);
    Vec3d centre{};
    for (std::uint32_t t = 0; t < s.area.size(); ++t) centre += s.area[t] * mesh::triangle_centroid(mesh, t);
    centre = centre / s.total_area;
    std::uint32_t extreme = mesh.triangles[0][0];
    double farthest = -1;
    for (const mesh::Triangle& t : mesh.triangles)
        for (const auto v : t)
            if (const double d = norm(mesh.vertices[v] - centre); d > farthest) {
                farthest = d;
                extreme = v;
            }
    constexpr int k_extremes = 4;
    std::vector<double> field, nearest(mesh.vertices.size(), k_unreached);
    std::vector<std::vector<double>> fields;
    for (int k = 0; k < k_extremes; ++k) {
        geodesics.run({&extreme, 1}, field);
        fields.push_back(at_triangles(mesh, field));
        farthest = -1;
        for (const auto v : geodesics.reached()) {
            nearest[v] = std::min(nearest[v], field[v]);
            if (nearest[v] > farthest) {
                farthest = nearest[v];
                extreme = v;
            }
        }
    }
    fields.push_back(fields[0]);
    for (std::size_t t = 0; t < s.area.size(); ++t) fields.back()[t] = fields[0][t] - fields[1][t];
    return fields;
}

/// Calls consider(near) with the best cut near each of a field's levels that divide the area evenly.
template <class Consider>
void cut_at_levels(const CutSurface& s, std::span<const double> field, Consider&& consider)
{
    constexpr int k_levels = 12;
    const std::vector<std::uint32_t> triangles = all_triangles(s);
    std::vector<std::pair<double, double>> sorted;
    for (const auto t : triangles)
        if (field[t] < k_unreached) sorted.emplace_back(field[t], s.area[t]);
    if (sorted.empty()) return;
    std::sort(sorted.begin(), sorted.end());
    double below = 0;
    int next = 1;
    for (const auto& [value, a] : sorted) {
        below += a;
        if (next >= k_levels || below < s.total_area * next / k_levels) continue;
        const double extent = sorted.back().first - sorted.front().first;
        const double radius = s.total_area / (2 * std::numbers::pi * extent);
        consider(best_cut(s, triangles, field, {value, 0.5 * extent / k_levels, radius}));
        ++next;
    }
}

}  // namespace

std::vector<CandidateCut> candidate_cuts(const CutSurface& s, double least)
{
    std::vector<CandidateCut> cuts;
    if (s.area.size() < 4) return cuts;
    const std::vector<std::uint32_t> triangles = all_triangles(s);
    const double whole = ellipsoid_volume(s, triangles);
    if (whole <= 0) return cuts;
    const auto consider = [&](std::vector<std::uint8_t> near) {
        std::vector<std::uint32_t> a, b;
        for (const std::uint32_t t : triangles) (near[t] ? a : b).push_back(t);
        const double area_a = s.area_of(a), area_b = s.total_area - area_a;
        if (area_a < least || area_b < least) return;
        const double gain = 1 - (ellipsoid_volume(s, a) + ellipsoid_volume(s, b)) / whole;
        const double length = cut_length(s, near);
        const double concavity = mean_concavity(s, triangles, near, length / (2 * std::numbers::pi));
        const double score = gain + 0.3 * concavity - 0.1 * length / std::sqrt(4 * std::numbers::pi * std::min(area_a, area_b));
        cuts.push_back({score, gain, std::move(near)});
    };
    for (const auto& field : fields_of(s)) cut_at_levels(s, field, consider);
    return cuts;
}

Cutter::Cutter(const mesh::Mesh& mesh) : surface_(std::make_unique<const CutSurface>(mesh)) {}
Cutter::~Cutter() = default;

Split Cutter::split(const Partition& partition, std::uint32_t part, const DecomposeOptions& options) const
{
    const CutSurface& s = *surface_;
    Split out;
    out.partition = partition;
    const auto triangles = triangles_of(partition, part);
    const double least = options.minimum_part_area * s.total_area;
    const PartSurface own(s, triangles);
    const std::vector<CandidateCut> cuts = candidate_cuts(own.surface(), least);
    if (cuts.empty()) return out;
    const auto best = std::max_element(cuts.begin(), cuts.end(),
                                       [](const CandidateCut& l, const CandidateCut& r) { return l.score < r.score; });
    out.found = apply_cut(s, out.partition, {part, triangles, best->near, CutKind::Error, least}) > 1;
    out.gain = best->gain;
    return out;
}

Partition Cutter::merge(const Partition& partition, std::uint32_t part_a, std::uint32_t part_b) const
{
    Partition out = partition;
    apply_merge(*surface_, out, part_a, part_b);
    return out;
}

Partition Cutter::ordered_by_area(const Partition& partition) const
{
    Partition out = partition;
    order_by_area(*surface_, out);
    return out;
}

}  // namespace sqmap::decompose
