#include "pieces.h"

#include <algorithm>
#include <cmath>

namespace sqmap::mesh {

namespace {

using Convex = std::vector<Vec3d>;

std::array<Vec3d, 3> corners_of(const Mesh& mesh, std::uint32_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

Vec3d unit_normal(const std::array<Vec3d, 3>& t) { return normalized(cross(t[1] - t[0], t[2] - t[0])); }

struct Plane {
    Vec3d normal;  ///< unit
    Vec3d point;
    double height(Vec3d p) const { return dot(normal, p - point); }
};

/// The part of the segment from a to b that lies in a convex polygon of its plane, as shares of the segment; empty if from >= to.
struct Stretch {
    double from = 0, to = 1;
};
Stretch within(const Convex& polygon, Vec3d normal, Vec3d a, Vec3d b)
{
    Stretch s;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3d e = polygon[(i + 1) % polygon.size()] - polygon[i], inward = cross(normal, e);
        const double at_a = dot(inward, a - polygon[i]), at_b = dot(inward, b - polygon[i]);
        if (at_a < 0 && at_b < 0) return {1, 0};
        if (at_a < 0) s.from = std::max(s.from, at_a / (at_a - at_b));
        if (at_b < 0) s.to = std::min(s.to, at_a / (at_a - at_b));
    }
    return s;
}

/// Cuts a polygon in two along a plane; makes no pieces thinner than tolerance.
void cut(const Convex& polygon, const Plane& plane, double tolerance, std::vector<Convex>& out)
{
    double lowest = 0, highest = 0;
    for (const Vec3d& p : polygon) {
        lowest = std::min(lowest, plane.height(p));
        highest = std::max(highest, plane.height(p));
    }
    if (lowest > -tolerance || highest < tolerance) {
        out.push_back(polygon);
        return;
    }
    Convex sides[2];
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3d a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        const double at_a = plane.height(a), at_b = plane.height(b);
        sides[at_a >= 0 ? 0 : 1].push_back(a);
        if ((at_a >= 0) == (at_b >= 0)) continue;
        const Vec3d p = a + (at_a / (at_a - at_b)) * (b - a);
        for (Convex& side : sides) side.push_back(p);
    }
    for (Convex& side : sides) out.push_back(std::move(side));
}

/// The segment in which a triangle meets a plane that it passes through.
bool meets(const std::array<Vec3d, 3>& t, const Plane& plane, double tolerance, Vec3d& a, Vec3d& b)
{
    const double h[3] = {plane.height(t[0]), plane.height(t[1]), plane.height(t[2])};
    Vec3d found[4];
    int count = 0;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        if (std::abs(h[i]) <= tolerance) found[count++] = t[static_cast<std::size_t>(i)];
        if ((h[i] > tolerance && h[j] < -tolerance) || (h[i] < -tolerance && h[j] > tolerance))
            found[count++] = t[static_cast<std::size_t>(i)] +
                             (h[i] / (h[i] - h[j])) * (t[static_cast<std::size_t>(j)] - t[static_cast<std::size_t>(i)]);
    }
    if (count < 2) return false;
    a = found[0];
    b = found[1];
    return norm(b - a) > tolerance;
}

}  // namespace

std::optional<std::vector<std::array<Vec3d, 3>>> pieces_of(const Mesh& mesh, std::uint32_t triangle,
                                                           std::span<const std::uint32_t> others, double tolerance,
                                                           std::size_t max_pieces)
{
    const std::array<Vec3d, 3> whole = corners_of(mesh, triangle);
    const Plane own{unit_normal(whole), whole[0]};
    std::vector<Convex> pieces = {Convex(whole.begin(), whole.end())}, next;
    const auto cut_along = [&](Vec3d a, Vec3d b) {
        // Cuts only pieces that the segment itself crosses; the cut runs on to the piece's ends, so that pieces stay convex.
        const Plane across{normalized(cross(own.normal, b - a)), a};
        next.clear();
        for (Convex& piece : pieces) {
            const Stretch s = within(piece, own.normal, a, b);
            if ((s.to - s.from) * norm(b - a) > tolerance)
                cut(piece, across, tolerance, next);
            else
                next.push_back(std::move(piece));
        }
        std::swap(pieces, next);
    };
    for (const std::uint32_t other : others) {
        const std::array<Vec3d, 3> t = corners_of(mesh, other);
        const bool flat = std::all_of(t.begin(), t.end(), [&](Vec3d p) { return std::abs(own.height(p)) <= tolerance; });
        Vec3d a, b;
        if (flat) {
            for (std::size_t i = 0; i < 3; ++i)
                if (norm(t[(i + 1) % 3] - t[i]) > tolerance) cut_along(t[i], t[(i + 1) % 3]);
        } else if (meets(t, own, tolerance, a, b)) {
            cut_along(a, b);
        }
        if (pieces.size() > max_pieces) return std::nullopt;
    }
    std::vector<std::array<Vec3d, 3>> out;
    for (const Convex& piece : pieces)
        for (std::size_t i = 2; i < piece.size(); ++i) {
            if (piece.size() == 3 || norm(cross(piece[i - 1] - piece[0], piece[i] - piece[0])) > 0)
                out.push_back({piece[0], piece[i - 1], piece[i]});
        }
    return out;
}

}  // namespace sqmap::mesh
