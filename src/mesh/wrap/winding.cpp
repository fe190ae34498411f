// Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding numbers", 2013; fast by
// Barill, Dickson, Schmidt, Levin, Jacobson, "Fast winding numbers for soups and clouds", 2018, to the second order.
// The solid angle of a triangle: van Oosterom, Strackee, 1983.
#include "winding.h"

#include "sqmap/math/box.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace sqmap::mesh {

namespace {

constexpr std::uint32_t k_group_size = 8;
constexpr double k_group_reach = 2.5;         ///< in radii of a group; at 2 the error is some 4e-3, at 2.5 below 1e-3
constexpr double k_pieces_across = 40;        ///< length of a split triangle in the whole
constexpr std::size_t k_max_pieces = 40'000;  ///< beside four for each triangle

/// Sums angles as a product of complex numbers: one arc tangent for all of them.
class AngleSum {
public:
    /// Adds half the solid angle of a triangle about p.
    void add(const std::array<Vec3d, 3>& t, Vec3d p)
    {
        const Vec3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
        const double la = norm(a), lb = norm(b), lc = norm(c);
        const double sine = dot(a, cross(b, c));
        const double cosine = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
        const double size = std::abs(sine) + std::abs(cosine);
        if (size == 0) return;
        const double scale = 1 / size, im = (im_ * cosine + re_ * sine) * scale;
        re_ = (re_ * cosine - im_ * sine) * scale;
        // An angle that is added to one of its own sign passes pi where the sign of the sum's sine is the other one.
        if (sine > 0 && im_ >= 0 && im < 0) ++turns_;
        if (sine < 0 && im_ < 0 && im >= 0) --turns_;
        im_ = im;
        if (++count_ % k_rescale == 0) {
            const double length = std::sqrt(re_ * re_ + im_ * im_);
            re_ /= length;
            im_ /= length;
        }
    }
    [[nodiscard]] double sum() const { return std::atan2(im_, re_) + 2 * std::numbers::pi * turns_; }

private:
    static constexpr int k_rescale = 64;  ///< a factor is at least 0.7 long
    double re_ = 1, im_ = 0;
    int turns_ = 0, count_ = 0;
};

double longest_side(const std::array<Vec3d, 3>& t)
{
    return std::sqrt(std::max({norm_sq(t[1] - t[0]), norm_sq(t[2] - t[1]), norm_sq(t[0] - t[2])}));
}

/// Appends the pieces of a triangle, halved along the middle of its longest side until that is short enough.
void split(const std::array<Vec3d, 3>& t, double length, std::vector<std::array<Vec3d, 3>>& out)
{
    int k = 0;
    for (int i = 1; i < 3; ++i)
        if (norm_sq(t[(i + 1) % 3] - t[i]) > norm_sq(t[(k + 1) % 3] - t[k])) k = i;
    const Vec3d a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3], m = 0.5 * (a + b);
    if (!(norm_sq(b - a) > length * length)) {
        out.push_back(t);
        return;
    }
    split({a, m, c}, length, out);
    split({m, b, c}, length, out);
}

/// Groups of long triangles are wide, and wide groups are summed triangle by triangle; so long triangles are split, if not too
/// many.
std::vector<std::array<Vec3d, 3>> pieces_of_soup(const Mesh& soup)
{
    std::vector<std::array<Vec3d, 3>> triangles, pieces;
    Box box;
    for (const Triangle& t : soup.triangles) {
        triangles.push_back({soup.vertices[t[0]], soup.vertices[t[1]], soup.vertices[t[2]]});
        for (const std::uint32_t v : t) extend(box, soup.vertices[v]);
    }
    double length = norm(size(box)) / k_pieces_across, estimate = 0;
    do {
        estimate = 0;
        for (const auto& t : triangles) estimate += 1 + 2 * longest_side(t) / length;
        length *= 1.5;
    } while (estimate > double(k_max_pieces + 4 * triangles.size()));
    for (const auto& t : triangles) split(t, length / 1.5, pieces);
    return pieces;
}

}  // namespace

WindingNumber::WindingNumber(const Mesh& soup)
{
    const std::vector<Corners> pieces = pieces_of_soup(soup);
    std::vector<std::uint32_t> order(pieces.size());
    std::iota(order.begin(), order.end(), 0u);
    triangles_.resize(order.size());
    if (!order.empty()) build(0, static_cast<std::uint32_t>(order.size()), order, pieces);
}

void WindingNumber::build(std::uint32_t begin, std::uint32_t end, std::span<std::uint32_t> order, std::span<const Corners> pieces)
{
    const std::size_t index = nodes_.size();
    nodes_.emplace_back();
    const bool leaf = end - begin <= k_group_size;
    if (leaf) {
        for (std::uint32_t i = begin; i < end; ++i) triangles_[i] = pieces[order[i]];
    } else {
        const auto middle_of = [&](std::uint32_t t) { return pieces[t][0] + pieces[t][1] + pieces[t][2]; };
        Box box;
        for (std::uint32_t i = begin; i < end; ++i) extend(box, middle_of(order[i]));
        const int axis = longest_axis(box);
        const std::uint32_t middle = begin + (end - begin) / 2;
        std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                         [&](std::uint32_t u, std::uint32_t v) {
                             return std::pair(middle_of(u)[axis], u) < std::pair(middle_of(v)[axis], v);
                         });
        build(begin, middle, order, pieces);
        build(middle, end, order, pieces);
    }
    Node& node = nodes_[index];
    node.begin = begin;
    node.end = end;
    node.leaf = leaf;
    node.skip = static_cast<std::uint32_t>(nodes_.size());
    sum_moments(node);
}

void WindingNumber::sum_moments(Node& node) const
{
    double weight = 0;
    Box box;
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const auto& [a, b, c] = triangles_[i];
        const double area = norm(cross(b - a, c - a));
        weight += area;
        node.centre += area * (a + b + c) / 3.0;
        for (const Vec3d& v : triangles_[i]) extend(box, v);
    }
    node.centre = weight > 0 ? node.centre / weight : sqmap::centre(box);
    double radius_sq = 0;
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const Vec3d v[3] = {triangles_[i][0] - node.centre, triangles_[i][1] - node.centre, triangles_[i][2] - node.centre};
        const Vec3d n = 0.5 * cross(v[1] - v[0], v[2] - v[0]), sum = v[0] + v[1] + v[2], m = sum / 3.0;
        for (const Vec3d& corner : v) radius_sq = std::max(radius_sq, norm_sq(corner));
        node.area += n;
        node.trace += dot(m, n);
        const double first[6] = {
            m.x * n.x, m.y * n.y, m.z * n.z, m.x * n.y + m.y * n.x, m.x * n.z + m.z * n.x, m.y * n.z + m.z * n.y};
        for (int k = 0; k < 6; ++k) node.first[k] += first[k];
        // The triangle's mean of x_i x_j.
        const auto mean = [&](int k, int l) {
            return (v[0][k] * v[0][l] + v[1][k] * v[1][l] + v[2][k] * v[2][l] + sum[k] * sum[l]) / 12;
        };
        const double xx = mean(0, 0), yy = mean(1, 1), zz = mean(2, 2), xy = mean(0, 1), xz = mean(0, 2), yz = mean(1, 2);
        node.contracted += Vec3d{2 * (xx * n.x + xy * n.y + xz * n.z), 2 * (xy * n.x + yy * n.y + yz * n.z),
                                 2 * (xz * n.x + yz * n.y + zz * n.z)} +
                           (xx + yy + zz) * n;
        const double second[10] = {xx * n.x,
                                   yy * n.y,
                                   zz * n.z,
                                   xx * n.y + 2 * xy * n.x,
                                   xx * n.z + 2 * xz * n.x,
                                   yy * n.x + 2 * xy * n.y,
                                   yy * n.z + 2 * yz * n.y,
                                   zz * n.x + 2 * xz * n.z,
                                   zz * n.y + 2 * yz * n.z,
                                   2 * (xy * n.z + xz * n.y + yz * n.x)};
        for (int k = 0; k < 10; ++k) node.second[k] += second[k];
    }
    node.reach_sq = k_group_reach * k_group_reach * radius_sq;
}

double WindingNumber::at(Vec3d p) const
{
    double sum = 0;
    AngleSum angle;
    for (std::uint32_t i = 0; i < nodes_.size();) {
        const Node& node = nodes_[i];
        const Vec3d r = node.centre - p;
        const double d_sq = norm_sq(r);
        if (d_sq > node.reach_sq) {
            const double s = 1 / d_sq, s3 = s * std::sqrt(s), s5 = s3 * s;
            const double x = r.x, y = r.y, z = r.z;
            const double* f = node.first;
            const double* g = node.second;
            const double first = f[0] * x * x + f[1] * y * y + f[2] * z * z + f[3] * x * y + f[4] * x * z + f[5] * y * z;
            const double second = x * x * (g[0] * x + g[3] * y + g[4] * z) + y * y * (g[1] * y + g[5] * x + g[6] * z) +
                                  z * z * (g[2] * z + g[7] * x + g[8] * y) + g[9] * x * y * z;
            sum +=
                s3 * (dot(node.area, r) + node.trace) - 3 * s5 * (first + 0.5 * dot(node.contracted, r)) + 7.5 * s5 * s * second;
            i = node.skip;
        } else {
            if (node.leaf)
                for (std::uint32_t t = node.begin; t < node.end; ++t) angle.add(triangles_[t], p);
            ++i;
        }
    }
    return (sum + 2 * angle.sum()) / (4 * std::numbers::pi);
}

double WindingNumber::direct(Vec3d p) const
{
    AngleSum angle;
    for (const Corners& t : triangles_) angle.add(t, p);
    return angle.sum() / (2 * std::numbers::pi);
}

}  // namespace sqmap::mesh
