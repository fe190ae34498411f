#include "surface.h"

#include <cmath>
#include <numeric>
#include <tuple>

namespace sqmap::mesh {

std::vector<EdgeUse> edge_uses(std::span<const Face> faces)
{
    std::vector<EdgeUse> uses;
    uses.reserve(3 * faces.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = faces[f].v[k], b = faces[f].v[(k + 1) % 3];
            uses.push_back({std::min(a, b), std::max(a, b), 3 * f + k, a < b});
        }
    std::sort(uses.begin(), uses.end(),
              [](const EdgeUse& a, const EdgeUse& b) { return std::tie(a.lo, a.hi, a.half) < std::tie(b.lo, b.hi, b.half); });
    return uses;
}

bool is_closed(std::span<const Face> faces)
{
    bool closed = true;
    for_each_edge(edge_uses(faces), [&](std::span<const EdgeUse> edge) { closed = closed && edge.size() == 2; });
    return closed;
}

namespace {

Vec3d newell_normal(std::span<const Vec3d> corners)
{
    // Relative to a corner: far from zero the cross products of the points themselves have no digits left.
    Vec3d n{};
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) n += cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
    return normalized(n);
}

/// Twice the area over the square of the longest edge, seen along n: the shape of a triangle, negative if turned over.
double shape(Vec3d a, Vec3d b, Vec3d c, Vec3d n)
{
    const double longest_sq = std::max({norm_sq(b - a), norm_sq(c - b), norm_sq(a - c)});
    return longest_sq > 0 ? dot(cross(b - a, c - a), n) / longest_sq : 0;
}

bool contains(Vec3d a, Vec3d b, Vec3d c, Vec3d p, Vec3d n)
{
    return dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 && dot(cross(a - c, p - c), n) >= 0;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> triangulated(std::span<const Vec3d> corners)
{
    const Vec3d n = newell_normal(corners);
    const auto s = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
        return shape(corners[i], corners[j], corners[k], n);
    };
    if (corners.size() == 4) {
        const double across_02 = std::min(s(0, 1, 2), s(0, 2, 3)), across_13 = std::min(s(0, 1, 3), s(1, 2, 3));
        const bool both = across_02 > 0 && across_13 > 0;
        const double length_02 = norm_sq(corners[2] - corners[0]), length_13 = norm_sq(corners[3] - corners[1]);
        const auto least = [](Vec3d a, Vec3d b) { return std::min(std::tuple(a.x, a.y, a.z), std::tuple(b.x, b.y, b.z)); };
        // A tie is settled by position, so that the corner a file starts with has no say.
        const bool choose_02 = !both                    ? across_02 >= across_13
                               : length_02 != length_13 ? length_02 < length_13
                                                        : least(corners[0], corners[2]) < least(corners[1], corners[3]);
        if (choose_02) return {{0, 1, 2}, {0, 2, 3}};
        return {{0, 1, 3}, {1, 2, 3}};
    }
    std::vector<std::array<std::uint32_t, 3>> out;
    std::vector<std::uint32_t> ring(corners.size());
    std::iota(ring.begin(), ring.end(), 0u);
    struct Ear {
        double shape = 0;
        bool is_empty = false;
    };
    std::vector<Ear> ears(ring.size());
    const auto corner = [&](std::size_t i, std::size_t step) { return ring[(i + step) % ring.size()]; };
    // Only corners that are not convex can lie in an ear.
    std::vector<bool> is_convex(corners.size());
    for (std::size_t i = 0; i < ring.size(); ++i) is_convex[i] = s(corner(i, ring.size() - 1), ring[i], corner(i, 1)) > 0;
    const auto look = [&](std::size_t i) {
        const std::uint32_t a = corner(i, ring.size() - 1), b = ring[i], c = corner(i, 1);
        const double ear = s(a, b, c);
        is_convex[b] = ear > 0;
        return Ear{ear, ear > 0 && std::none_of(ring.begin(), ring.end(), [&](std::uint32_t p) {
                            return !is_convex[p] && p != a && p != b && p != c &&
                                   contains(corners[a], corners[b], corners[c], corners[p], n);
                        })};
    };
    for (std::size_t i = 0; i < ring.size(); ++i) ears[i] = look(i);
    while (ring.size() > 3) {
        // The best ear that holds no other corner; where rounding leaves none, the best ear.
        const auto worse = [](const Ear& a, const Ear& b) {
            return std::tie(a.is_empty, a.shape) < std::tie(b.is_empty, b.shape);
        };
        auto best = std::max_element(ears.begin(), ears.end(), worse);
        if (!best->is_empty) {  // cutting may have emptied ears since their last examination
            for (std::size_t i = 0; i < ring.size(); ++i) ears[i] = look(i);
            best = std::max_element(ears.begin(), ears.end(), worse);
        }
        const auto at = static_cast<std::size_t>(best - ears.begin());
        out.push_back({corner(at, ring.size() - 1), ring[at], corner(at, 1)});
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(at));
        ears.erase(best);
        const std::size_t before = (at + ring.size() - 1) % ring.size(), after = at % ring.size();
        ears[before] = look(before);
        ears[after] = look(after);
    }
    out.push_back({ring[0], ring[1], ring[2]});
    return out;
}

std::vector<std::uint32_t> coincident(std::span<const Vec3d> points)
{
    std::vector<std::uint32_t> order(points.size()), first(points.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t v) { return std::tie(points[v].x, points[v].y, points[v].z); };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
    return first;
}

std::vector<std::uint32_t> coincident_within(std::span<const Vec3d> points, double distance)
{
    // Cells eight times as wide: most points lie away from a cell's walls and look into their own only.
    using Cell = std::array<double, 3>;
    const double width = 8 * distance;
    const auto cell_of = [&](Vec3d p) { return Cell{std::floor(p.x / width), std::floor(p.y / width), std::floor(p.z / width)}; };
    std::vector<std::pair<Cell, std::uint32_t>> cells;
    cells.reserve(points.size());
    for (std::uint32_t v = 0; v < points.size(); ++v) cells.emplace_back(cell_of(points[v]), v);
    std::sort(cells.begin(), cells.end());
    UnionFind groups(points.size());
    const Vec3d reach{distance, distance, distance};
    for (std::uint32_t v = 0; v < points.size(); ++v) {
        const Cell lo = cell_of(points[v] - reach), hi = cell_of(points[v] + reach);
        for (double x = lo[0]; x <= hi[0]; ++x)
            for (double y = lo[1]; y <= hi[1]; ++y)
                for (double z = lo[2]; z <= hi[2]; ++z) {
                    const Cell cell{x, y, z};
                    // Only later points of the cell: each pair is seen from its first.
                    for (auto i = std::lower_bound(cells.begin(), cells.end(), std::pair(cell, v + 1));
                         i != cells.end() && i->first == cell; ++i)
                        if (norm(points[i->second] - points[v]) <= distance) groups.unite(v, i->second);
                }
    }
    std::vector<std::uint32_t> first(points.size());
    for (std::uint32_t v = 0; v < points.size(); ++v) first[v] = groups.find(v);
    return first;
}

}  // namespace sqmap::mesh
