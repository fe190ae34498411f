// By the divergence theorem the volume of a polyhedron is a third of the sum over its faces of a point's product with the area
// vector, and an area vector is half the sum of s x e over the face's oriented sides (W. R. Franklin, "Polygon properties
// calculated from the vertex neighborhoods", SoCG 1987, sums over neighbourhoods in the same way). Sides of the intersection are
// the parts of either mesh's edges within the other, and where triangles cross. No face of it has to be put together.
#include "sqmap/query/overlap.h"

#include "candidates.h"
#include "math/triangle_crossing.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::query {

class OverlapQuery {
public:
    OverlapQuery(const TriangleTree& a, const TriangleTree& b, const Affine& move, OverlapWorkspace& workspace)
        : a_{a, workspace.a_}, b_{b, workspace.b_}, move_(move)
    {
        const Vec3d size_a = size(a.box()), size_b = size(b.box());
        origin_ = centre(a.box());
        largest_ = std::max(norm(size_a), norm(size_b));
    }

    /// False in special position.
    bool run(Vec3d shift, double& volume)
    {
        shift_ = shift;
        sum_ = 0;
        is_special_ = false;
        for (Mesh* m : {&a_, &b_}) {
            std::fill_n(m->space.change.begin(), 3 * m->tree.size(), std::int16_t{0});
            std::fill_n(m->space.inside.begin(), 3 * m->tree.size(), 0.);
        }
        const Affine moved{move_.linear, move_.shift + shift_};
        const CandidateJob job(a_.tree, b_.tree, moved);
        find_candidates(
            job,
            [](void* self, std::span<const TrianglePair> pairs) noexcept {
                return static_cast<OverlapQuery*>(self)->take(pairs);
            },
            this);
        if (is_special_ || !walk(a_, b_) || !walk(b_, a_)) return false;
        add_edges(a_);
        add_edges(b_);
        volume = std::max(sum_ / 6, 0.);
        return true;
    }

    [[nodiscard]] double largest() const { return largest_; }

private:
    struct Mesh {
        const TriangleTree& tree;
        OverlapWorkspace::Side& space;
    };

    /// About the middle of a, where little is lost by rounding.
    [[nodiscard]] Vec3d point(const Mesh& m, std::uint32_t i) const
    {
        const Vec3d p = m.tree.point(i);
        return (&m == &a_ ? p : apply(move_, p) + shift_) - origin_;
    }
    [[nodiscard]] TriangleCorners corners(const Mesh& m, std::uint32_t t) const
    {
        const ProbeTriangle& v = m.tree.triangle(t);
        return {point(m, v[0]), point(m, v[1]), point(m, v[2])};
    }

    bool take(std::span<const TrianglePair> pairs)
    {
        for (const TrianglePair& pair : pairs) {
            const TriangleCorners a = corners(a_, pair.a), b = corners(b_, pair.b);
            const Crossing crossing = crossing_of(a, b);
            if (!crossing.meets()) continue;
            std::array<Vec3d, 6> ends;
            std::size_t count = 0;
            for (std::uint32_t k = 0; k < 3 && !is_special_; ++k) {
                if ((crossing.sides_a >> k & 1u) != 0) ends[count++] = pierce(a_, 3 * pair.a + k, b);
                if ((crossing.sides_b >> k & 1u) != 0) ends[count++] = pierce(b_, 3 * pair.b + k, a);
            }
            is_special_ = is_special_ || count != 2;
            if (is_special_) return false;
            const Vec3d normal_a = cross(a.b - a.a, a.c - a.a), normal_b = cross(b.b - b.a, b.c - b.a);
            // Seen from outside of a, b's inside is to the left of a x b.
            if (dot(ends[1] - ends[0], cross(normal_a, normal_b)) < 0) std::swap(ends[0], ends[1]);
            sum_ += dot(a.a - b.a, cross(ends[0], ends[1]));
        }
        return true;
    }

    /// The position at which an edge meets a triangle; both triangles of the edge get the same bits. The edge's own sum is kept
    /// once.
    Vec3d pierce(Mesh& m, std::uint32_t half_edge, const TriangleCorners& t)
    {
        const std::uint32_t edge = std::min(half_edge, m.tree.twin(half_edge));
        const ProbeTriangle& v = m.tree.triangle(edge / 3);
        const Vec3d from = point(m, v[edge % 3]), to = point(m, v[(edge % 3 + 1) % 3]);
        const int above = -orient3d(t.a, t.b, t.c, from), above_end = -orient3d(t.a, t.b, t.c, to);
        const int turns[3] = {orient3d(from, to, t.a, t.b), orient3d(from, to, t.b, t.c), orient3d(from, to, t.c, t.a)};
        is_special_ = is_special_ || above * above_end >= 0 || turns[0] == 0 || turns[1] == 0 || turns[2] == 0;
        const Vec3d normal = cross(t.b - t.a, t.c - t.a);
        const double height = dot(normal, from - t.a), height_end = dot(normal, to - t.a);
        const double share = std::clamp(height / (height - height_end), 0., 1.);
        if (edge == half_edge) {
            const int enters = above > 0 ? 1 : -1;
            m.space.change[edge] = static_cast<std::int16_t>(m.space.change[edge] + enters);
            m.space.inside[edge] -= enters * share;
        }
        return from + share * (to - from);
    }

    /// Windings of all points: from a point of each piece along the edges.
    bool walk(Mesh& m, const Mesh& other)
    {
        OverlapWorkspace::Side& s = m.space;
        std::fill_n(s.is_reached.begin(), m.tree.size(), std::uint8_t{0});
        for (std::uint32_t first = 0; first < m.tree.size(); ++first) {
            if (s.is_reached[first] != 0) continue;
            const std::uint32_t corner = m.tree.triangle(first)[0];
            if (!find_winding(m, other, corner)) return false;
            std::size_t count = 0;
            s.triangles[count++] = first;
            s.is_reached[first] = 1;
            spread(m, 3 * first);
            spread(m, 3 * first + 1);
            for (std::size_t i = 0; i < count; ++i)
                for (std::uint32_t k = 0; k < 3; ++k) {
                    const std::uint32_t twin = m.tree.twin(3 * s.triangles[i] + k), next = twin / 3;
                    if (s.is_reached[next] != 0) continue;
                    s.is_reached[next] = 1;
                    s.triangles[count++] = next;
                    // The twin's ends may be other points at the same positions.
                    const ProbeTriangle &from = m.tree.triangle(s.triangles[i]), &to = m.tree.triangle(next);
                    s.winding[to[(twin % 3 + 1) % 3]] = s.winding[from[k]];
                    s.winding[to[twin % 3]] = s.winding[from[(k + 1) % 3]];
                    spread(m, 3 * next + (twin % 3 + 1) % 3);
                }
        }
        return true;
    }
    /// From the beginning of a half-edge to its end.
    static void spread(Mesh& m, std::uint32_t half_edge)
    {
        const std::uint32_t twin = m.tree.twin(half_edge);
        const int change = half_edge <= twin ? m.space.change[half_edge] : -m.space.change[twin];
        const ProbeTriangle& v = m.tree.triangle(half_edge / 3);
        m.space.winding[v[(half_edge % 3 + 1) % 3]] = static_cast<std::int16_t>(m.space.winding[v[half_edge % 3]] + change);
    }
    /// Counts how a segment from a point to the outside crosses the other mesh. False in special position.
    bool find_winding(Mesh& m, const Mesh& other, std::uint32_t i)
    {
        const Vec3d p = point(m, i);
        Box box = other.tree.box();
        int winding = 0;
        const Vec3d local = &m == &a_ ? transpose_mul(move_.linear, p + origin_ - shift_ - move_.shift) : p + origin_;
        const double rounding = 1e-6 * largest_;
        for (int k = 0; k < 3; ++k) {
            box.lo[k] -= rounding;
            box.hi[k] += rounding;
        }
        if (contains(box, local)) {
            const Vec3d far = p + 4 * largest_ * Vec3d{0.5376, 0.6129, 0.5788};
            for (std::uint32_t t = 0; t < other.tree.size(); ++t) {
                const TriangleCorners c = corners(other, t);
                const int begin = -orient3d(c.a, c.b, c.c, p), end = -orient3d(c.a, c.b, c.c, far);
                if (begin * end > 0) continue;
                const int turns[3] = {orient3d(p, far, c.a, c.b), orient3d(p, far, c.b, c.c), orient3d(p, far, c.c, c.a)};
                const bool beside =
                    (turns[0] > 0 || turns[1] > 0 || turns[2] > 0) && (turns[0] < 0 || turns[1] < 0 || turns[2] < 0);
                if (beside) continue;
                if (begin * end == 0 || turns[0] * turns[1] * turns[2] == 0) return false;
                winding += begin < 0 ? 1 : -1;
            }
        }
        m.space.winding[i] = static_cast<std::int16_t>(winding);
        return true;
    }

    /// The parts of edges that are in the other mesh: by half-edges, each triangle's own point.
    void add_edges(const Mesh& m)
    {
        for (std::uint32_t t = 0; t < m.tree.size(); ++t)
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t edge = 3 * t + k, twin = m.tree.twin(edge);
                if (edge > twin) continue;
                const ProbeTriangle &v = m.tree.triangle(t), &w = m.tree.triangle(twin / 3);
                const double inside = m.space.inside[edge] + m.space.winding[v[(k + 1) % 3]];
                if (inside == 0) continue;
                // For all sides of a triangle the same point of its plane.
                const Vec3d between = point(m, v[0]) - point(m, w[0]);
                sum_ += inside * dot(between, cross(point(m, v[k]), point(m, v[(k + 1) % 3])));
            }
    }

    Mesh a_, b_;
    const Affine move_;
    Vec3d shift_{}, origin_{};
    double largest_ = 0, sum_ = 0;
    bool is_special_ = false;
};

namespace {

double area_of(const TriangleTree& tree)
{
    double area = 0;
    for (std::uint32_t t = 0; t < tree.size(); ++t) {
        const ProbeTriangle& v = tree.triangle(t);
        const Vec3d p = tree.point(v[0]);
        area += 0.5 * norm(cross(tree.point(v[1]) - p, tree.point(v[2]) - p));
    }
    return area;
}

}  // namespace

Overlap overlap(const Body& a, const Body& b, OverlapWorkspace& workspace) noexcept
{
    if (!is_finite(a.pose) || !is_finite(b.pose)) return {0, 0, k_not_finite};
    if (!has_triangles(a) || !has_triangles(b)) return {0, 0, k_no_triangles};
    const TriangleTree &tree_a = a.probe->triangles(), &tree_b = b.probe->triangles();
    if (!workspace.holds(*a.probe, *b.probe)) return {0, 0, k_full};
    OverlapQuery query(tree_a, tree_b, b_in_a(a, b), workspace);
    Overlap out;
    if (query.run({}, out.volume)) return out;
    // Directions without a pattern: what is special in one is not in the next.
    constexpr Vec3d k_directions[] = {{0.6181, 0.3247, 0.7156},   {-0.2907, 0.8431, 0.4523}, {0.4473, -0.5519, 0.7037},
                                      {-0.7351, -0.4129, 0.5377}, {0.8713, 0.1291, -0.4733}, {-0.1931, 0.6577, -0.7281}};
    double length = 1e-13 * query.largest();
    for (const Vec3d& direction : k_directions) {
        if (query.run(length * direction, out.volume)) {
            out.error = length * std::min(area_of(tree_a), area_of(tree_b));
            return out;
        }
        length *= 2;
    }
    return {0, 0, k_full};
}

}  // namespace sqmap::query
