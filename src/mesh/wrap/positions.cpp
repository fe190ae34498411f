// Ju, Losasso, Schaefer, Warren, "Dual contouring of Hermite data", 2002: the vertex of a sheet is nearest to the planes of the
// triangles that bound the solid on the crossed edges of its cell.
#include "steps.h"

#include "symmetric.h"

#include "math/triangle.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace sqmap::mesh {

namespace {

constexpr double k_flat = 0.03;      ///< share of the greatest eigenvalue below which planes agree
constexpr double k_facing = 0.2;     ///< cosine between a triangle and the sheet that it carries
constexpr double k_reach = 0.7;      ///< how far a vertex moves to the input, cells
constexpr double k_thin_reach = 2;   ///< the same for a wall thinner than a cell
constexpr double k_touching = 0.05;  ///< cells; nearer to a sheet than this the grid's edge decides the side
constexpr int k_halvings = 8;

struct Crossing {
    Crossed kind = Crossed::Level;
    Vec3d point;
    Vec3d normal;  ///< outward; of a level: zero
};

/// Sums over the crossings of a sheet.
struct SheetSum {
    PlaneSum planes;  ///< about the cell's corner
    Vec3d crossings;  ///< sum, relative to the cell's corner
    Vec3d normals;
    int count = 0, input = 0, shell = 0;
};

class Solver {
public:
    Solver(const DualSurface& surface, const Labelled& labelled)
        : surface_(surface),
          in_(labelled.source),
          grid_(labelled.grid),
          labels_(labelled.labels),
          sums_(surface.vertex_cell.size())
    {
    }

    Positions run()
    {
        for (const DualQuad& quad : surface_.quads) add(quad);
        for (std::uint32_t v = 0; v < sums_.size(); ++v) out_.vertices.push_back(solve(v));
        std::vector<std::pair<Vec3d, int>> between(surface_.between_count);
        for (std::size_t q = 0; q < surface_.quads.size(); ++q)
            for (const std::uint32_t v : surface_.quads[q].between)
                if (v != KeyTable::k_absent) {
                    between[v - sums_.size()].first += out_.crossings[q];
                    ++between[v - sums_.size()].second;
                }
        for (const auto& [sum, count] : between) out_.vertices.push_back(sum / double(count));
        return std::move(out_);
    }

private:
    [[nodiscard]] std::array<Vec3d, 3> corners(std::uint32_t t) const
    {
        const Triangle& v = in_.soup.triangles[t];
        return {in_.soup.vertices[v[0]], in_.soup.vertices[v[1]], in_.soup.vertices[v[2]]};
    }

    void add(const DualQuad& quad)
    {
        const LatticePoint &inside = grid_.corners.point(quad.inside), &outside = grid_.corners.point(quad.outside);
        const Vec3d from = position(inside), along = position(outside) - from;
        const Crossing crossing = crossing_of(quad, from, along);
        const Vec3d p = crossing.point;
        out_.crossings.push_back(p);
        out_.kinds.push_back(crossing.kind);
        out_.has_shells |= crossing.kind == Crossed::Shell;
        for (const std::uint32_t v : quad.vertices) {
            SheetSum& sum = sums_[v];
            const Vec3d local = p - position(grid_.cells.point(surface_.vertex_cell[v]));
            sum.crossings += local;
            ++sum.count;
            if (crossing.kind == Crossed::Level) continue;
            ++(crossing.kind == Crossed::Shell ? sum.shell : sum.input);
            sum.planes.add(local, crossing.normal);
            sum.normals += crossing.normal;
        }
    }

    /// The crossing at which the edge leaves the solid: at the triangle whose passing takes the winding number below 1/2.
    [[nodiscard]] Crossing crossing_of(const DualQuad& quad, Vec3d from, Vec3d along) const
    {
        if (labels_.inside[quad.inside] == k_shell) return beside_thin(from + 0.5 * along, along);
        struct Hit {
            double t;
            std::uint32_t triangle;
            int change;
            Vec3d normal;
        };
        std::vector<Hit> hits;
        for (const std::uint32_t t : grid_.triangles_of(quad.cell))
            if (const std::optional<double> at = hit(corners(t), from, along)) {
                const auto [a, b, c] = corners(t);
                const Vec3d n = normalized(cross(b - a, c - a));
                hits.push_back({*at, t, dot(n, along) > 0 ? -1 : 1, n});
            }
        std::sort(hits.begin(), hits.end(),
                  [](const Hit& a, const Hit& b) { return std::pair(a.t, a.triangle) < std::pair(b.t, b.triangle); });
        const double begin = labels_.winding[quad.inside];
        double drift = labels_.winding[quad.outside] - begin;
        for (const Hit& h : hits) drift -= h.change;
        double sum = begin;
        for (const Hit& h : hits) {
            const double before = sum + drift * h.t;
            if (before > 0.5 && before + h.change <= 0.5) return {Crossed::Input, from + h.t * along, h.normal};
            sum += h.change;
        }
        return level_crossing(from, along);
    }

    /// By halving. It may end at a triangle.
    [[nodiscard]] Crossing level_crossing(Vec3d from, Vec3d along) const
    {
        double low = 0, high = 1;
        for (int i = 0; i < k_halvings; ++i) {
            const double middle = 0.5 * (low + high);
            (in_.winding.at(from + middle * along) > 0.5 ? low : high) = middle;
        }
        return {Crossed::Level, from + 0.5 * (low + high) * along, {}};
    }

    /// The position at which an edge along an axis passes through a triangle, borders included.
    static std::optional<double> hit(const std::array<Vec3d, 3>& t, Vec3d from, Vec3d along)
    {
        const int axis = along.x != 0 ? 0 : (along.y != 0 ? 1 : 2), u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto side = [&](const Vec3d& a, const Vec3d& b) {
            return (a[u] - from[u]) * (b[v] - from[v]) - (a[v] - from[v]) * (b[u] - from[u]);
        };
        const double s0 = side(t[1], t[2]), s1 = side(t[2], t[0]), s2 = side(t[0], t[1]), sum = s0 + s1 + s2;
        if (sum == 0 || std::min({s0, s1, s2}) < 0) {
            if (sum == 0 || std::max({s0, s1, s2}) > 0) return std::nullopt;
        }
        const double at = ((s0 * t[0][axis] + s1 * t[1][axis] + s2 * t[2][axis]) / sum - from[axis]) * along[axis];
        if (!(at >= 0 && at <= 1)) return std::nullopt;
        return at;
    }

    [[nodiscard]] Vec3d solve(std::uint32_t v) const
    {
        const SheetSum& sum = sums_[v];
        const Vec3d corner = position(grid_.cells.point(surface_.vertex_cell[v]));
        const Vec3d mean = sum.crossings / double(sum.count);
        if (sum.input + sum.shell == 0) return corner + mean;
        Vec3d x = least_point(sum.planes, mean, k_flat);
        if (sum.shell > 0) return corner + (norm(x - mean) < k_reach ? x : mean);
        // Not beyond the cell: along the line from the crossings' mean.
        double share = 1;
        for (int k = 0; k < 3; ++k) {
            if (x[k] > 1) share = std::min(share, (1 - mean[k]) / (x[k] - mean[k]));
            if (x[k] < 0) share = std::min(share, mean[k] / (mean[k] - x[k]));
        }
        x = corner + mean + share * (x - mean);
        if (sum.input < sum.count) return x;
        return nearest_facing(x, normalized(sum.normals), k_reach, Thin::No).value_or(x);
    }

    /// The nearest point of the triangles that face a direction. least: only of those at least so thin.
    [[nodiscard]] std::optional<Vec3d> nearest_facing(Vec3d p, Vec3d direction, double within, Thin least) const
    {
        std::optional<Vec3d> best;
        in_.bvh.visit_nearest(p, within * within, [&](std::uint32_t t, double radius_sq) {
            if (labels_.thin[t] < least) return radius_sq;
            const auto [a, b, c] = corners(t);
            const Vec3d q = closest_point_on_triangle(p, a, b, c);
            const double d_sq = norm_sq(q - p);
            if (d_sq >= radius_sq || dot(normalized(cross(b - a, c - a)), direction) < k_facing) return radius_sq;
            best = q;
            return d_sq;
        });
        return best;
    }

    /// The plane of a shell beside a thin triangle: a wall's own side, or half the thickness away from a sheet.
    [[nodiscard]] Crossing beside_thin(Vec3d p, Vec3d along) const
    {
        Thin thin = Thin::No;
        Vec3d q = p;
        in_.bvh.visit_nearest(p, k_thin_reach * k_thin_reach, [&](std::uint32_t t, double radius_sq) {
            if (labels_.thin[t] == Thin::No) return radius_sq;
            const auto [a, b, c] = corners(t);
            const Vec3d foot = closest_point_on_triangle(p, a, b, c);
            const double d_sq = norm_sq(foot - p);
            if (d_sq >= radius_sq) return radius_sq;
            thin = labels_.thin[t];
            q = foot;
            return d_sq;
        });
        const Vec3d off = p - q, outward = norm(off) > k_touching ? normalized(off) : along;
        if (thin == Thin::Wall)
            if (const std::optional<Vec3d> wall = nearest_facing(p, outward, k_thin_reach, Thin::Wall))
                return {Crossed::Shell, *wall, outward};
        return {Crossed::Shell, thin == Thin::No ? p : q + 0.5 * in_.thickness * outward, outward};
    }

    const DualSurface& surface_;
    const Source& in_;
    const Grid& grid_;
    const Labels& labels_;
    std::vector<SheetSum> sums_;
    Positions out_;
};

}  // namespace

Positions positions_of(const DualSurface& surface, const Labelled& labelled) { return Solver(surface, labelled).run(); }

}  // namespace sqmap::mesh
