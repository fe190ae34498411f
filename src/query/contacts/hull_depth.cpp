// G. van den Bergen, "Proximity queries and penetration depth computation on 3D game objects", GDC 2001. The polytope need not
// hold the origin in the beginning: where it does not, its nearest facet has a negative distance, and it grows there first.
#include "hull_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::query {

HullDepth::HullDepth(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a, SeparatingWorkspace& workspace) noexcept
    : a_(a),
      b_(b),
      b_in_a_(b_in_a),
      workspace_(workspace),
      middle_(centre(a.box())),
      upper_(std::numeric_limits<double>::infinity())
{
    near_ = 1e-13 * (norm(size(a.box())) + norm(size(b.box())) + norm(b_in_a.shift - middle_));
}

Vec3d HullDepth::support(Vec3d direction)
{
    const Vec3d in_b = transpose_mul(b_in_a_.linear, direction);
    double high = -std::numeric_limits<double>::infinity(), low = -high;
    std::size_t at_a = 0, at_b = 0;
    for (std::size_t i = 0; i < a_.points(); ++i)
        if (const double v = dot(direction, a_.point(i) - middle_);
            v > high && a_.half_edge_from(i) != TriangleTree::k_no_half_edge) {
            high = v;
            at_a = i;
        }
    for (std::size_t i = 0; i < b_.points(); ++i)
        if (const double v = dot(in_b, b_.point(i)); v < low && b_.half_edge_from(i) != TriangleTree::k_no_half_edge) {
            low = v;
            at_b = i;
        }
    const Vec3d corner = (a_.point(at_a) - middle_) - (apply(b_in_a_, b_.point(at_b)) - middle_);
    if (const double depth = std::max(dot(direction, corner), 0.); depth < upper_) {
        upper_ = depth;
        direction_ = direction;
    }
    return corner;
}

bool HullDepth::set_facet(std::uint32_t f, std::uint32_t a, std::uint32_t b, std::uint32_t c)
{
    const std::vector<Vec3d>& p = workspace_.corners_;
    const Vec3d n = cross(p[b] - p[a], p[c] - p[a]);
    const double length = norm(n), side = std::max({norm(p[b] - p[a]), norm(p[c] - p[a]), norm(p[c] - p[b])});
    if (!(length > near_ * side)) return false;
    workspace_.facets_[f] = {{a, b, c}, {0, 0, 0}, n / length, 0, false};
    workspace_.facets_[f].distance = dot(workspace_.facets_[f].normal, p[a]);
    return true;
}

/// A tetrahedron of supports.
bool HullDepth::begin()
{
    std::vector<Vec3d>& p = workspace_.corners_;
    const Vec3d to = apply(b_in_a_, centre(b_.box())) - middle_;
    const Vec3d first = norm(to) > near_ ? normalized(to) : Vec3d{0, 0, 1};
    p[0] = support(first);
    p[1] = support(-first);
    if (!(norm(p[1] - p[0]) > near_)) return false;
    const auto farther = [&](Vec3d axis, auto&& measure) {
        const Vec3d one = support(axis), other = support(-axis);
        return measure(one) >= measure(other) ? one : other;
    };
    const Vec3d line = normalized(p[1] - p[0]);
    const Vec3d beside = normalized(cross(std::abs(line.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, line));
    p[2] = farther(beside, [&](Vec3d v) { return norm(cross(line, v - p[0])); });
    Vec3d n = cross(p[1] - p[0], p[2] - p[0]);
    if (!(norm(n) > near_ * norm(p[1] - p[0]))) return false;
    n = normalized(n);
    p[3] = farther(n, [&](Vec3d v) { return std::abs(dot(n, v - p[0])); });
    const double height = dot(n, p[3] - p[0]);
    if (!(std::abs(height) > near_)) return false;
    if (height > 0) std::swap(p[1], p[2]);
    corners_ = facets_ = 4;
    constexpr std::uint32_t k_sides[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    constexpr std::uint32_t k_neighbours[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
    for (std::uint32_t f = 0; f < 4; ++f) {
        if (!set_facet(f, k_sides[f][0], k_sides[f][1], k_sides[f][2])) return false;
        std::copy_n(k_neighbours[f], 3, workspace_.facets_[f].neighbour);
    }
    return true;
}

bool HullDepth::grow(std::uint32_t facet, Vec3d corner)
{
    std::vector<Facet>& f = workspace_.facets_;
    std::vector<std::uint32_t>& visible = workspace_.visible_;
    if (corners_ == workspace_.corners_.size()) return false;
    const auto apex = static_cast<std::uint32_t>(corners_);
    workspace_.corners_[corners_++] = corner;
    std::size_t count = 0;
    visible[count++] = facet;
    f[facet].is_gone = true;
    for (std::size_t i = 0; i < count; ++i)
        for (const std::uint32_t next : f[visible[i]].neighbour)
            if (!f[next].is_gone && is_visible(f[next], corner)) {
                f[next].is_gone = true;
                visible[count++] = next;
            }
    // A facet from each side of the horizon to the corner; its neighbours beside it are found by the ends of that side.
    const std::size_t first = facets_;
    for (std::size_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            const Facet& gone = f[visible[i]];
            const std::uint32_t beyond = gone.neighbour[k], from = gone.corner[k], to = gone.corner[(k + 1) % 3];
            if (f[beyond].is_gone) continue;
            if (facets_ == f.size()) return false;
            const auto self = static_cast<std::uint32_t>(facets_++);
            if (!set_facet(self, from, to, apex)) return false;
            f[self].neighbour[0] = beyond;
            for (int j = 0; j < 3; ++j)
                if (f[beyond].corner[j] == to && f[beyond].corner[(j + 1) % 3] == from) f[beyond].neighbour[j] = self;
        }
    for (std::size_t i = first; i < facets_; ++i) {
        bool is_closed = false;
        for (std::size_t j = first; j < facets_; ++j)
            if (f[j].corner[0] == f[i].corner[1]) {
                f[i].neighbour[1] = static_cast<std::uint32_t>(j);
                f[j].neighbour[2] = static_cast<std::uint32_t>(i);
                is_closed = true;
            }
        if (!is_closed) return false;
    }
    return facets_ > first;
}

void HullDepth::run() noexcept
{
    if (!begin()) return;
    const std::vector<Facet>& f = workspace_.facets_;
    for (;;) {
        std::size_t nearest = f.size();
        for (std::size_t i = 0; i < facets_; ++i)
            if (!f[i].is_gone && (nearest == f.size() || f[i].distance < f[nearest].distance)) nearest = i;
        if (nearest == f.size()) return;
        lower_ = std::max({lower_, f[nearest].distance - near_, 0.});
        const Vec3d corner = support(f[nearest].normal);
        if (upper_ == 0) {
            lower_ = 0;
            is_exact_ = true;
            return;
        }
        if (dot(f[nearest].normal, corner) <= f[nearest].distance + 4 * near_) {
            is_exact_ = true;
            lower_ = std::min(std::max(f[nearest].distance - near_, 0.), upper_);
            return;
        }
        if (!grow(static_cast<std::uint32_t>(nearest), corner)) return;
    }
}

bool is_convex(const TriangleTree& tree, SeparatingWorkspace& workspace) noexcept
{
    SeparatingWorkspace::Side& s = workspace.a_.holds(tree) ? workspace.a_ : workspace.b_;
    const double near = 1e-12 * norm(size(tree.box()));
    std::fill_n(s.is_reached.begin(), tree.size(), std::uint8_t{0});
    std::size_t count = 0, reached = 1;
    s.stack[count++] = 0;
    s.is_reached[0] = 1;
    while (count > 0) {
        const std::uint32_t t = s.stack[--count];
        const ProbeTriangle& v = tree.triangle(t);
        const Vec3d a = tree.point(v[0]), normal = normalized(cross(tree.point(v[1]) - a, tree.point(v[2]) - a));
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t twin = tree.twin(3 * t + k), next = twin / 3;
            const ProbeTriangle& w = tree.triangle(next);
            const Vec3d from = tree.point(w[0]), other = cross(tree.point(w[1]) - from, tree.point(w[2]) - from);
            const double height = dot(normal, tree.point(w[(twin % 3 + 2) % 3]) - a);
            const bool falls = height < -near, is_flat = height <= near && dot(normal, other) > 0;
            if (!falls && !is_flat) return false;  // a ridge the other way round, folded back, or without area
            if (s.is_reached[next] != 0) continue;
            s.is_reached[next] = 1;
            s.stack[count++] = next;
            ++reached;
        }
    }
    return reached == tree.size();
}

}  // namespace sqmap::query
