// Parts of a surface that is its own mirror image: those of one half, and their images.
#include "cut.h"
#include "mirror.h"
#include "partition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace sqmap::decompose {

namespace {

/// The sides of a mirror that triangles lie on, one byte each: 1 ahead of it.
std::vector<std::uint8_t> sides_of(const mesh::Mesh& mesh, const Mirror& mirror)
{
    std::vector<std::uint8_t> sides;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3d centre = mesh::triangle_centroid(mesh, t);
        sides.push_back(dot(mirror.normal, centre) > mirror.offset ? 1 : 0);
    }
    return sides;
}

/// Length of the borders on either side that run in creases, less a share of all: a crease has to be deep enough to be worth its
/// length.
std::array<double, 2> merit_of_halves(const CutSurface& s, const Partition& partition, const std::vector<std::uint8_t>& sides)
{
    constexpr double k_least_concavity = 0.2;
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> length;
    for (const Boundary& b : partition.boundaries) length[{b.part_a, b.part_b}] = b.length;
    std::array<double, 2> merit{};
    for (std::uint32_t t = 0; t < s.area.size(); ++t)
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t o = s.graph.neighbours[t][e];
            if (o == mesh::k_no_triangle || partition.part_of_triangle[o] == partition.part_of_triangle[t]) continue;
            const double radius =
                length[std::minmax(partition.part_of_triangle[o], partition.part_of_triangle[t])] / (2 * std::numbers::pi);
            merit[sides[t]] += s.edge_length[t][e] * (std::min(1.0, radius * s.edge_concavity[t][e]) - k_least_concavity);
        }
    return merit;
}

/// The partition of the half on one side, and its mirror image.
Partition mirrored(const CutSurface& s, const Mirror& mirror, const Partition& partition,
                   const std::vector<std::uint8_t>& is_kept)
{
    // Shares of a part's area on one side: a part with more than the first on the other lies across the plane, a kept part with
    // less than the second is an uneven border of the other half.
    constexpr double k_across = 0.2, k_uneven = 0.05;
    const std::uint32_t n = partition.part_count;
    std::vector<std::array<double, 2>> area(n, {0, 0});
    for (std::uint32_t t = 0; t < s.area.size(); ++t) area[partition.part_of_triangle[t]][is_kept[t]] += s.area[t];
    std::vector<std::vector<std::uint32_t>> former;  // labels of the half that is kept, then of their images
    for (std::uint32_t l = 0; l < 2 * n; ++l) former.push_back({l % n});
    std::vector<std::uint32_t> labels(s.area.size(), mesh::k_no_triangle);
    for (std::uint32_t t = 0; t < s.area.size(); ++t) {
        const std::uint32_t from = is_kept[t] != 0 ? t : mirror.of_triangle[t];
        if (from == mesh::k_no_triangle || is_kept[from] == 0) continue;
        const std::uint32_t part = partition.part_of_triangle[from];
        const auto [left, kept] = area[part];
        if (kept < k_uneven * left) continue;
        labels[t] = is_kept[t] != 0 || left > k_across * kept ? part : n + part;
    }
    return grown(s, partition, std::move(labels), std::move(former));
}

}  // namespace

Partition symmetrised(const mesh::Mesh& mesh, const Mirror& mirror, Partition partition, std::uint32_t max_parts)
{
    const CutSurface s(mesh);
    std::vector<std::uint8_t> is_kept = sides_of(mesh, mirror);
    const auto [behind, ahead] = merit_of_halves(s, partition, is_kept);
    const auto turn = [&] {
        for (std::uint8_t& kept : is_kept) kept ^= 1;
    };
    if (behind > ahead) turn();
    for (int half = 0; half < 2; ++half, turn())
        if (Partition found = mirrored(s, mirror, partition, is_kept); found.part_count <= max_parts) return found;
    return partition;
}

}  // namespace sqmap::decompose
