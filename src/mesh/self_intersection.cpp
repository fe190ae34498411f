// Pairs by a bounding volume hierarchy against itself, each decided with exact orientations alone: two triangles meet
// exactly where an edge of one meets the other (P. Guigue and O. Devillers, "Fast and robust triangle-triangle overlap
// test using orientation predicates", 2003).
#include "sqmap/mesh/self_intersection.h"

#include "math/triangle_crossing.h"
#include "sqmap/math/box.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::mesh {
namespace {

using Corners = TriangleCorners;

class Finder {
public:
    Finder(const Mesh& mesh, std::uint64_t max_pairs, std::span<const std::uint8_t> among)
        : mesh_(mesh), max_pairs_(max_pairs), among_(among)
    {
        // By a power of two to unit size: exact, and the determinants stay within double's range.
        double largest = 0;
        for (const Vec3d& p : mesh.vertices) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        int exponent = 0;
        std::frexp(largest, &exponent);
        for (const Vec3d& p : mesh.vertices)
            points_.push_back({std::ldexp(p.x, -exponent), std::ldexp(p.y, -exponent), std::ldexp(p.z, -exponent)});
        for (const Triangle& t : mesh.triangles) centres_.push_back((points_[t[0]] + points_[t[1]] + points_[t[2]]) / 3.0);
        out_.crossed.assign(mesh.triangles.size(), 0);
        // A triangle that meets a wanted one also meets the box around all wanted ones.
        Box wanted;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            if (is_wanted(t)) extend(wanted, box_around(corners(t)));
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            if (overlap(box_around(corners(t)), wanted)) order_.push_back(t);
    }

    SelfIntersections run()
    {
        if (order_.empty()) return std::move(out_);
        build(0, static_cast<std::uint32_t>(order_.size()));
        join(0, 0);
        return std::move(out_);
    }

private:
    struct Node {
        Box box;
        std::uint32_t first = 0, count = 0;  ///< leaf: entries of order_
        std::uint32_t right = 0;             ///< inner: the left child is the next node
        bool wanted = false;                 ///< holds a triangle whose pairs are wanted
    };

    static Box box_around(const Corners& c) { return box_of(std::array{c.a, c.b, c.c}); }

    [[nodiscard]] bool is_wanted(std::uint32_t t) const { return among_.empty() || among_[t] != 0; }

    [[nodiscard]] Corners corners(std::uint32_t t) const
    {
        const Triangle& v = mesh_.triangles[t];
        return {points_[v[0]], points_[v[1]], points_[v[2]]};
    }

    void build(std::uint32_t first, std::uint32_t last)
    {
        constexpr std::uint32_t k_leaf_size = 4;
        const std::size_t index = nodes_.size();
        Node node{.box = {}, .first = first, .count = last - first};
        Box centres;
        for (std::uint32_t i = first; i < last; ++i) {
            node.wanted = node.wanted || is_wanted(order_[i]);
            for (const std::uint32_t v : mesh_.triangles[order_[i]]) extend(node.box, points_[v]);
            extend(centres, centres_[order_[i]]);
        }
        nodes_.push_back(node);
        if (last - first <= k_leaf_size) return;
        const int axis = longest_axis(centres);
        const std::uint32_t middle = first + (last - first) / 2;
        std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                         [&](std::uint32_t a, std::uint32_t b) {
                             return centres_[a][axis] != centres_[b][axis] ? centres_[a][axis] < centres_[b][axis] : a < b;
                         });
        nodes_[index].count = 0;
        build(first, middle);
        nodes_[index].right = static_cast<std::uint32_t>(nodes_.size());
        build(middle, last);
    }

    void join(std::uint32_t i, std::uint32_t j)
    {
        const Node &a = nodes_[i], &b = nodes_[j];
        if (!out_.is_complete || !(a.wanted || b.wanted) || (i != j && !overlap(a.box, b.box))) return;
        if (a.count > 0 && b.count > 0) {
            for (std::uint32_t s = a.first; s < a.first + a.count; ++s)
                for (std::uint32_t t = i == j ? s + 1 : b.first; t < b.first + b.count; ++t) test(order_[s], order_[t]);
        } else if (i == j) {
            join(i + 1, i + 1);
            join(a.right, a.right);
            join(i + 1, a.right);
        } else if (b.count > 0 || (a.count == 0 && norm_sq(size(a.box)) >= norm_sq(size(b.box)))) {
            join(i + 1, j);
            join(a.right, j);
        } else {
            join(i, j + 1);
            join(i, b.right);
        }
    }

    void test(std::uint32_t s, std::uint32_t t)
    {
        if (!out_.is_complete || !(is_wanted(s) || is_wanted(t)) || !triangles_meet(s, t)) return;
        if (out_.pair_count == max_pairs_) {
            out_.is_complete = false;
            return;
        }
        ++out_.pair_count;
        out_.crossed[s] = out_.crossed[t] = 1;
    }

    [[nodiscard]] bool triangles_meet(std::uint32_t s, std::uint32_t t) const
    {
        const Corners p = corners(s), q = corners(t);
        if (!overlap(box_around(p), box_around(q))) return false;
        // Turn both so that their common vertices come first.
        int shared = 0, at_p = 0, at_q = 0, free_p = 0, free_q = 0;
        bool q_is_shared[3] = {false, false, false};
        for (int i = 0; i < 3; ++i) {
            bool is_shared = false;
            for (int j = 0; j < 3; ++j)
                if (mesh_.triangles[s][static_cast<std::size_t>(i)] == mesh_.triangles[t][static_cast<std::size_t>(j)]) {
                    is_shared = q_is_shared[j] = true;
                    at_p = i;
                    at_q = j;
                    ++shared;
                }
            if (!is_shared) free_p = i;
        }
        for (int j = 0; j < 3; ++j)
            if (!q_is_shared[j]) free_q = j;
        const auto turned = [](const Corners& c, int first) {
            return first == 0 ? c : (first == 1 ? Corners{c.b, c.c, c.a} : Corners{c.c, c.a, c.b});
        };
        if (shared >= 3) return true;
        if (shared == 2) {
            const Corners a = turned(p, free_p), b = turned(q, free_q);
            if (orient3d(a.a, a.b, a.c, b.a) != 0) return false;
            const int axis = open_axis(a);
            if (axis < 0) return false;
            const Vec2d from = projected(a.b, axis), to = projected(a.c, axis);
            return orient2d(from, to, projected(a.a, axis)) * orient2d(from, to, projected(b.a, axis)) > 0;
        }
        if (shared == 1) {
            const Corners a = turned(p, at_p), b = turned(q, at_q);
            return segment_meets(a.b, a.c, b) || segment_meets(b.b, b.c, a);
        }
        return segment_meets(p.a, p.b, q) || segment_meets(p.b, p.c, q) || segment_meets(p.c, p.a, q) ||
               segment_meets(q.a, q.b, p) || segment_meets(q.b, q.c, p) || segment_meets(q.c, q.a, p);
    }

    const Mesh& mesh_;
    std::uint64_t max_pairs_;
    std::span<const std::uint8_t> among_;
    std::vector<Vec3d> points_, centres_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
    SelfIntersections out_;
};

}  // namespace

SelfIntersections find_self_intersections(const Mesh& mesh, std::uint64_t max_pairs, std::span<const std::uint8_t> among)
{
    return Finder(mesh, max_pairs, among).run();
}

}  // namespace sqmap::mesh
