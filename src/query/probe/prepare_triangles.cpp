// Constructors of triangles, which allocate: they run outside the frame.
#include "halves.h"
#include "math/predicates.h"
#include "math/union_find.h"
#include "query/probe/triangle_tree.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace sqmap::query {

namespace {

constexpr std::uint32_t k_no_twin = TriangleTree::k_no_half_edge;

/// For each point the first one at the same position.
std::vector<std::uint32_t> first_at_position(std::span<const Vec3d> points)
{
    std::vector<std::uint32_t> order(points.size()), first(points.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t i) { return std::array{points[i].x, points[i].y, points[i].z}; };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] = i > 0 && key(order[i - 1]) == key(order[i]) ? first[order[i - 1]] : order[i];
    return first;
}

/// A side of a triangle between positions, the lower number first.
struct SidedEdge {
    std::uint32_t lower, higher;
    bool is_down;  ///< the triangle runs from the higher to the lower one
    std::uint32_t half_edge;
};

std::vector<SidedEdge> sorted_edges(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles)
{
    const std::vector<std::uint32_t> first = first_at_position(points);
    std::vector<SidedEdge> edges;
    edges.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t from = first[triangles[t][k]], to = first[triangles[t][(k + 1) % 3]];
            edges.push_back({std::min(from, to), std::max(from, to), from > to, 3 * t + k});
        }
    std::sort(edges.begin(), edges.end(), [](const SidedEdge& a, const SidedEdge& b) {
        return std::tie(a.lower, a.higher, a.half_edge) < std::tie(b.lower, b.higher, b.half_edge);
    });
    return edges;
}

/// Twins of the half-edges; of several along one edge the first of either direction, then the second, and so on. A side of no
/// length is its own twin. Where one has none, it is the fault.
std::vector<std::uint32_t> find_twins(std::span<const SidedEdge> edges, TriangleFault& fault)
{
    std::vector<std::uint32_t> twin(edges.size(), k_no_twin), up, down;
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i;
        up.clear();
        down.clear();
        for (; end < edges.size() && edges[end].lower == edges[i].lower && edges[end].higher == edges[i].higher; ++end)
            (edges[end].is_down ? down : up).push_back(edges[end].half_edge);
        if (edges[i].lower == edges[i].higher) {
            for (const std::uint32_t h : up) twin[h] = h;
        } else if (up.size() != down.size()) {
            const std::uint32_t h = (up.size() > down.size() ? up : down).back();
            const bool is_odd = (up.size() + down.size()) % 2 == 1;
            if (fault.kind == TriangleFault::Kind::None)
                fault = {is_odd ? TriangleFault::Kind::Open : TriangleFault::Kind::TurnedRound, h / 3, h % 3};
        }
        for (std::size_t k = 0; k < std::min(up.size(), down.size()); ++k) {
            twin[up[k]] = down[k];
            twin[down[k]] = up[k];
        }
        i = end;
    }
    return twin;
}

/// Bits of the sides at which the cosine of the angle between both faces' normals is below 0.6.
std::vector<std::uint8_t> find_sharp_sides(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles,
                                           std::span<const std::uint32_t> twin)
{
    std::vector<Vec3d> normals;
    for (const ProbeTriangle& t : triangles)
        normals.push_back(normalized(cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]])));
    std::vector<std::uint8_t> sharp(triangles.size());
    for (std::uint32_t h = 0; h < twin.size(); ++h)
        if (dot(normals[h / 3], normals[twin[h] / 3]) < 0.6) sharp[h / 3] = static_cast<std::uint8_t>(sharp[h / 3] | 1u << h % 3);
    return sharp;
}

/// True where a position is in the solid of other shells: a ray upwards leaves them more often than it enters. A triangle is
/// above by those of its sides that pass to the right of the position, seen from above.
bool is_within_others(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles,
                      std::span<const std::uint32_t> shell, std::uint32_t own, Vec3d p)
{
    int winding = 0;
    const auto seen = [](Vec3d q) { return Vec2d{q.x, q.y}; };
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (shell[t] == own) continue;
        int turns = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d from = points[triangles[t][k]], to = points[triangles[t][(k + 1) % 3]];
            if ((from.y <= p.y) == (to.y <= p.y)) continue;
            const int side = orient2d(seen(from), seen(to), seen(p));
            if (from.y <= p.y && side > 0) ++turns;
            if (to.y <= p.y && side < 0) --turns;
        }
        if (turns != 0 && turns * orient3d(points[triangles[t][0]], points[triangles[t][1]], points[triangles[t][2]], p) > 0)
            winding += turns;
    }
    return winding > 0;
}

/// The first triangle of a shell that is inside out and no cavity of others; their number where there is none.
std::size_t find_inverted(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles,
                          std::span<const std::uint32_t> twin)
{
    std::vector<std::uint32_t> shell(triangles.size());
    std::iota(shell.begin(), shell.end(), 0u);
    for (std::uint32_t h = 0; h < twin.size(); ++h) join(shell, h / 3, twin[h] / 3);
    struct Volume {
        double sum = 0, size = 0;
    };
    std::vector<Volume> volumes(triangles.size());  // of each shell, at its first triangle
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        shell[t] = root_of(shell, t);
        const ProbeTriangle &v = triangles[t], &first = triangles[shell[t]];
        const Vec3d origin = points[first[0]], a = points[v[0]] - origin, n = cross(points[v[1]] - origin, points[v[2]] - origin);
        volumes[shell[t]].sum += dot(a, n);
        volumes[shell[t]].size += norm(a) * norm(points[v[1]] - origin) * norm(points[v[2]] - origin);
    }
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (shell[t] != t || !(volumes[t].sum < -1e-14 * volumes[t].size)) continue;  // rounding gives a sheet some volume
        const auto is_within = [&](std::uint32_t corner) {
            return is_within_others(points, triangles, shell, t, points[corner]);
        };
        if (std::none_of(triangles[t].begin(), triangles[t].end(), is_within)) return t;
    }
    return triangles.size();
}

}  // namespace

TriangleFault find_fault(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles)
{
    using Kind = TriangleFault::Kind;
    if (triangles.size() > TriangleTree::k_max) return {Kind::TooMany, 0, 0};
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (triangles[t][k] >= points.size()) return {Kind::OutOfRange, t, k};
            if (!is_finite(points[triangles[t][k]])) return {Kind::NotFinite, t, k};
        }
    if (triangles.empty()) return {};
    if (const double extent = norm(size(box_of(points))); !(extent >= k_least_size && extent <= k_largest_size))
        return {Kind::OutOfScale, 0, 0};
    TriangleFault fault;
    const std::vector<std::uint32_t> twin = find_twins(sorted_edges(points, triangles), fault);
    if (fault.kind != Kind::None) return fault;
    if (const std::size_t t = find_inverted(points, triangles, twin); t < triangles.size())
        return {Kind::Inverted, static_cast<std::uint32_t>(t), 0};
    return fault;
}

TriangleTree::TriangleTree(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles)
    : points_(points.begin(), points.end()), triangles_(triangles.begin(), triangles.end())
{
    SQMAP_ASSERT(triangles.size() <= k_max);
    if (triangles.empty()) return;
    TriangleFault fault;
    twin_ = find_twins(sorted_edges(points, triangles), fault);
    for (std::uint32_t h = 0; h < twin_.size(); ++h)
        if (twin_[h] == k_no_twin) twin_[h] = h;  // against the precondition: an edge with one face
    sharp_ = find_sharp_sides(points, triangles, twin_);
    from_.assign(points.size(), k_no_half_edge);
    for (std::uint32_t h = 0; h < twin_.size(); ++h) from_[triangles[h / 3][h % 3]] = h;

    std::vector<Vec3d> centres;
    for (const ProbeTriangle& t : triangles) centres.push_back((points[t[0]] + points[t[1]] + points[t[2]]) / 3.0);
    std::vector<std::uint32_t> order(triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    order_by_halves(order, centres, k_leaf);
    const std::size_t leaves = (triangles.size() + k_leaf - 1) / k_leaf, groups = (leaves + k_group - 1) / k_group;
    numbers_.resize(leaves * k_leaf);
    for (std::size_t i = 0; i < numbers_.size(); ++i) numbers_[i] = order[std::min(i, order.size() - 1)];
    corners_.resize(leaves);
    leaves_.resize(groups);
    slabs_.resize(groups);
    groups_.resize((groups + k_group - 1) / k_group);
    refit();
}

}  // namespace sqmap::query
