// Separating axes: two triangles that share no point are parted by a plane upright on one of these directions (Gottschalk, Lin,
// Manocha 1996). An axis that rounding made inexact still proves what it parts.
#include "enclosed.h"

#include <algorithm>
#include <cmath>

namespace sqmap::mesh {

namespace {

constexpr std::uint32_t k_enclosed_leaf = 4;
constexpr double k_on_face = 1e-9;  ///< barycentric coordinate of a point that may lie on a tetrahedron's face

bool axis_parts(Vec3d axis, const Enclosed::Corners& s, const Enclosed::Corners& t, double margin)
{
    // No std::minmax of a list: it branches, and which corner is least cannot be guessed.
    const auto least = [](double x, double y, double z) { return std::min(std::min(x, y), z); };
    const auto greatest = [](double x, double y, double z) { return std::max(std::max(x, y), z); };
    const double s0 = dot(axis, s[0]), s1 = dot(axis, s[1]), s2 = dot(axis, s[2]);
    const double t0 = dot(axis, t[0]), t1 = dot(axis, t[1]), t2 = dot(axis, t[2]);
    const double gap = std::max(least(t0, t1, t2) - greatest(s0, s1, s2), least(s0, s1, s2) - greatest(t0, t1, t2));
    return gap > 0 && gap * gap > margin * margin * norm_sq(axis);
}

}  // namespace

Enclosed::Enclosed(const Mesh& soup, double margin) : margin_(margin)
{
    std::vector<Vec3d> middles;
    for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
        const Triangle& v = soup.triangles[t];
        corners_.push_back({soup.vertices[v[0]], soup.vertices[v[1]], soup.vertices[v[2]]});
        Box box = box_of(corners_[t]);
        box.lo -= Vec3d{margin, margin, margin};
        box.hi += Vec3d{margin, margin, margin};
        boxes_.push_back(box);
        middles.push_back(box.lo + box.hi);
        order_.push_back(t);
    }
    if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()), middles);
}

void Enclosed::build(std::uint32_t first, std::uint32_t last, std::span<const Vec3d> middles)
{
    const std::size_t index = nodes_.size();
    nodes_.emplace_back();
    Box box, spread;
    for (std::uint32_t i = first; i < last; ++i) {
        extend(box, boxes_[order_[i]]);
        extend(spread, middles[order_[i]]);
    }
    nodes_[index].box = box;
    if (last - first <= k_enclosed_leaf) {
        nodes_[index].first = first;
        nodes_[index].count = last - first;
    } else {
        const int axis = longest_axis(spread);
        const std::uint32_t middle = first + (last - first) / 2;
        std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                         [&](std::uint32_t a, std::uint32_t b) {
                             return middles[a][axis] != middles[b][axis] ? middles[a][axis] < middles[b][axis] : a < b;
                         });
        build(first, middle, middles);
        build(middle, last, middles);
    }
    nodes_[index].skip = static_cast<std::uint32_t>(nodes_.size());
}

template <class Visit>
void Enclosed::visit(const Box& box, Visit&& visit) const
{
    for (std::uint32_t i = 0; i < nodes_.size();) {
        const Node& node = nodes_[i];
        if (!overlap(node.box, box)) {
            i = node.skip;
            continue;
        }
        for (std::uint32_t k = node.first; k < node.first + node.count; ++k)
            if (overlap(boxes_[order_[k]], box) && visit(order_[k])) return;
        ++i;
    }
}

void Enclosed::collect(const Box& box, std::vector<std::uint32_t>& out) const
{
    visit(box, [&](std::uint32_t t) {
        out.push_back(t);
        return false;
    });
}

bool Enclosed::are_apart(std::uint32_t soup_triangle, const Corners& other, const Box& box) const
{
    if (!overlap(boxes_[soup_triangle], box)) return true;
    const Vec3d origin = other[0];  // small numbers, small rounding
    Corners s = corners_[soup_triangle], t = other;
    for (int k = 0; k < 3; ++k) {
        s[k] -= origin;
        t[k] -= origin;
    }
    const Vec3d se[3] = {s[1] - s[0], s[2] - s[1], s[0] - s[2]}, te[3] = {t[1] - t[0], t[2] - t[1], t[0] - t[2]};
    const Vec3d sn = cross(se[0], se[1]), tn = cross(te[0], te[1]);
    if (axis_parts(tn, s, t, margin_) || axis_parts(sn, s, t, margin_)) return true;
    for (const Vec3d& a : se)
        for (const Vec3d& b : te)
            if (axis_parts(cross(a, b), s, t, margin_)) return true;
    for (int k = 0; k < 3; ++k)
        if (axis_parts(cross(se[k], sn), s, t, margin_) || axis_parts(cross(te[k], tn), s, t, margin_)) return true;
    return false;
}

std::optional<std::uint32_t> Enclosed::met_by(const Corners& other) const
{
    std::optional<std::uint32_t> met;
    const Box box = box_of(other);
    visit(box, [&](std::uint32_t t) {
        if (are_apart(t, other, box)) return false;
        met = t;
        return true;
    });
    return met;
}

bool Enclosed::is_swept(std::uint32_t soup_triangle, const std::array<Vec3d, 4>& tetrahedron) const
{
    const Vec3d o = tetrahedron[0], a = tetrahedron[1] - o, b = tetrahedron[2] - o, c = tetrahedron[3] - o;
    const double volume = dot(a, cross(b, c));
    if (volume == 0) return false;
    const Vec3d p = corners_[soup_triangle][0] - o;
    const double u = dot(p, cross(b, c)) / volume, v = dot(p, cross(c, a)) / volume, w = dot(p, cross(a, b)) / volume;
    return std::min({u, v, w, 1 - u - v - w}) >= -k_on_face;
}

}  // namespace sqmap::mesh
