#include "project.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sqmap::bake {

namespace {

constexpr double k_same_depth = 1e-9;  // of w: surfaces that lie on each other

/// Keeps the side of a convex polygon where value(corner) >= 0.
template <class Value>
void cut(std::vector<Vec3d>& polygon, Value&& value)
{
    if (polygon.empty()) return;
    thread_local std::vector<Vec3d> kept;  // keeps its memory
    kept.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3d a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        const double va = value(a), vb = value(b);
        if (va >= 0) kept.push_back(a);
        if ((va >= 0) != (vb >= 0)) kept.push_back(a + (va / (va - vb)) * (b - a));
    }
    polygon.swap(kept);
}

/// How far the projection of a triangle reaches on a face.
Extent whole_extent(int face, const std::array<Vec3d, 3>& corners)
{
    const int m = model::face_axis(face);
    const double sign = model::face_sign<double>(face), infinity = std::numeric_limits<double>::infinity();
    Extent e{infinity, -infinity, infinity, -infinity};
    for (const Vec3d& x : corners) {
        const double major = sign * x[m], s = x[(m + 1) % 3] / major, t = x[(m + 2) % 3] / major;
        if (!(major > 1e-3 * norm(x))) return {-infinity, infinity, -infinity, infinity};
        e = {std::min(e.lo_s, s), std::max(e.hi_s, s), std::min(e.lo_t, t), std::max(e.hi_t, t)};
    }
    return e;
}

/// True where a ray is clear of a triangle's projection, nudged as it may be.
bool is_beside(const Extent& whole, FacePoint at)
{
    constexpr double k_clear = 4e-6;
    return at.s < whole.lo_s - k_clear || at.s > whole.hi_s + k_clear || at.t < whole.lo_t - k_clear ||
           at.t > whole.hi_t + k_clear;
}

/// Puts a polygon of the chart's frame, a triangle's part in the domain, on the faces that see it.
void spread(std::uint32_t triangle, const std::array<Vec3d, 3>& corners, const std::vector<Vec3d>& whole, Footprints& to)
{
    std::vector<Vec3d> polygon;
    for (int face = 0; face < model::k_faces; ++face) {
        const int m = model::face_axis(face), iu = (m + 1) % 3, iv = (m + 2) % 3;
        const double sign = model::face_sign<double>(face);
        polygon.clear();
        for (const Vec3d& p : whole) polygon.push_back({sign * p[m], p[iu], p[iv]});
        const double e = 1 + k_cell_border;
        cut(polygon, [](Vec3d p) { return p.x - 1e-4; });
        cut(polygon, [&](Vec3d p) { return e * p.x - p.y; });
        cut(polygon, [&](Vec3d p) { return e * p.x + p.y; });
        cut(polygon, [&](Vec3d p) { return e * p.x - p.z; });
        cut(polygon, [&](Vec3d p) { return e * p.x + p.z; });
        if (polygon.empty()) continue;
        Polygon footprint;
        footprint.triangle = triangle;
        footprint.whole = whole_extent(face, corners);
        for (const Vec3d& p : polygon)
            footprint.corner[static_cast<std::size_t>(footprint.count++)] = {p.y / p.x, p.z / p.x, 1 / p.x};
        to[static_cast<std::size_t>(face)].push_back(footprint);
    }
}

}  // namespace

Projection::Projection(const mesh::Solid& solid, const PartChart& chart)
    : solid_(solid), chart_(chart), centre_(cast<double>(chart.centre)), centre_winding_(solid.bvh().winding_number(centre_))
{
    const mesh::Mesh& mesh = solid.mesh();
    own_.assign(mesh.triangles.size(), 0);
    for (const std::uint32_t t : chart.own_triangles) own_[t] = 1;
    const shape::Superquadricd& sq = chart.superquadric;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) rows_.row[i][j] = static_cast<float>(sq.rotation.row[i][j] / sq.a[i]);
    x_.resize(mesh.vertices.size());
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = rows_ * (mesh.vertices[i] - centre_);
    side_of_.resize(mesh.triangles.size());
    std::vector<Vec3d> polygon;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const mesh::Triangle& tri = mesh.triangles[t];
        polygon.assign({x_[tri[0]], x_[tri[1]], x_[tri[2]]});
        clip_to_domain(polygon);
        if (polygon.empty()) continue;
        side_of_[t] = static_cast<std::uint32_t>(sides_.size());
        sides_.push_back(sides_of(tri));
        spread(t, {x_[tri[0]], x_[tri[1]], x_[tri[2]]}, polygon, footprints_);
    }
    double lo = std::numeric_limits<double>::infinity(), hi = 0;
    for (const std::vector<Polygon>& face : footprints_)
        for (const Polygon& p : face)
            for (int i = 0; i < p.count; ++i) {
                lo = std::min(lo, p.corner[static_cast<std::size_t>(i)].w);
                hi = std::max(hi, p.corner[static_cast<std::size_t>(i)].w);
            }
    if (!(hi > 0)) return;
    least_w_ = lo;
    max_w_ = hi;
}

void Projection::append_footprints(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, Footprints& to) const
{
    std::vector<Vec3d> polygon;
    for (const std::uint32_t t : triangles) {
        polygon.clear();
        for (const std::uint32_t v : mesh.triangles[t]) polygon.push_back(rows_ * (mesh.vertices[v] - centre_));
        const std::array<Vec3d, 3> corners = {polygon[0], polygon[1], polygon[2]};
        clip_to_domain(polygon);
        if (!polygon.empty()) spread(t, corners, polygon, to);
    }
}

void Projection::clip_to_domain(std::vector<Vec3d>& polygon) const
{
    for (std::size_t k = 0; k < model::k_domain_directions && !polygon.empty(); ++k) {
        double least = std::numeric_limits<double>::infinity(), largest = -least;
        for (const Vec3d& p : polygon) {
            const double v = model::domain_coordinate(p, k);
            least = std::min(least, v);
            largest = std::max(largest, v);
        }
        const double lo = chart_.domain.lo[k] - k_cell_border, hi = chart_.domain.hi[k] + k_cell_border;
        if (largest < lo || least > hi) polygon.clear();
        if (least < lo) cut(polygon, [&](Vec3d p) { return model::domain_coordinate(p, k) - lo; });
        if (largest > hi) cut(polygon, [&](Vec3d p) { return hi - model::domain_coordinate(p, k); });
    }
}

Projection::Sides Projection::sides_of(const mesh::Triangle& tri) const
{
    const Vec3d a = x_[tri[0]], b = x_[tri[1]], c = x_[tri[2]];
    // The same for both triangles of an edge.
    const auto edge = [&](std::size_t i, std::size_t j) {
        const Vec3d e = x_[tri[i]], f = x_[tri[j]];
        return tri[i] < tri[j] ? cross(e, f) : -cross(f, e);
    };
    const double size = std::sqrt(std::max({norm_sq(a), norm_sq(b), norm_sq(c)}));
    return {{edge(1, 2), edge(2, 0), edge(0, 1)}, 1e-14 * size * size, dot(a, cross(b, c))};
}

template <class Target>
RaySample Projection::cross_nudged(FacePoint at, std::size_t count, Target&& target) const
{
    // A ray through an edge or corner is moved by less than a cell border; the certificates measure what is stored.
    static constexpr double k_nudge[][2] = {{0.61e-6, 0.37e-6}, {-0.83e-6, 0.29e-6}, {0.17e-6, -0.91e-6}, {-0.41e-6, -0.67e-6}};
    RaySample result;
    for (const auto& nudge : k_nudge)
        if (cross_all(model::face_direction(at.face, at.s + nudge[0], at.t + nudge[1]), count, target, result)) return result;
    return result;
}

RaySample Projection::crossings(FacePoint at, std::span<const Polygon> near) const
{
    return cross_nudged(at, near.size(),
                        [&](std::size_t i) { return is_beside(near[i].whole, at) ? nullptr : &side_of(near[i]); });
}

RaySample Projection::crossings(FacePoint at, std::span<const Polygon* const> near) const
{
    return cross_nudged(at, near.size(),
                        [&](std::size_t i) { return is_beside(near[i]->whole, at) ? nullptr : &side_of(*near[i]); });
}

template <class Target>
bool Projection::cross_all(Vec3d q, std::size_t targets, Target&& target, RaySample& result) const
{
    std::array<std::pair<double, int>, 64> hits;
    std::size_t count = 0;
    for (std::size_t i = 0; i < targets; ++i) {
        const Sides* at = target(i);
        if (at == nullptr) continue;
        const Sides& sides = *at;
        const double u = dot(sides.normal[0], q), v = dot(sides.normal[1], q), w = dot(sides.normal[2], q);
        const double tiny = sides.tiny, volume = sides.volume;
        if ((u > tiny || v > tiny || w > tiny) && (u < -tiny || v < -tiny || w < -tiny)) continue;
        if (std::abs(u) <= tiny || std::abs(v) <= tiny || std::abs(w) <= tiny) return false;
        const double along = u + v + w;
        if (!((along > 0) == (volume > 0)) || volume == 0) continue;
        if (count == hits.size()) return false;
        hits[count++] = {along / volume, along > 0 ? 1 : -1};  // w = 1/rho since q has largest coordinate 1
    }
    std::sort(hits.begin(), hits.begin() + static_cast<std::ptrdiff_t>(count),
              [](const auto& l, const auto& r) { return l.first > r.first; });
    result.valid = true;
    result.count = 0;
    int winding = centre_winding_;
    for (std::size_t i = 0; i < count;) {
        // Faces that lie on each other are passed at once: between them there is nothing.
        const double w = hits[i].first;
        int next = winding;
        for (; i < count && hits[i].first >= (1 - k_same_depth) * w; ++i) next -= hits[i].second;
        if ((next > 0) != (winding > 0) && result.count < 16) result.w[static_cast<std::size_t>(result.count++)] = w;
        winding = next;
    }
    return true;
}

CellTriangles::CellTriangles(const Projection& projection, int face, std::span<const Polygon> near) : projection_(projection)
{
    const int m = model::face_axis(face);
    for (const Polygon& p : near) {
        rays_.push_back({p.whole, &projection.side_of(p)});
        const mesh::Triangle& tri = projection.solid().mesh().triangles[p.triangle];
        const Vec3d a = projection.x_[tri[0]], n = cross(projection.x_[tri[1]] - a, projection.x_[tri[2]] - a);
        const double d = dot(n, a);
        if (std::abs(d) < 1e-12) continue;
        planes_.push_back({model::face_sign<double>(face) * n[m] / d, n[(m + 1) % 3] / d, n[(m + 2) % 3] / d, extent_of(p)});
    }
}

RaySample CellTriangles::crossings(FacePoint at) const
{
    return projection_.cross_nudged(at, rays_.size(),
                                    [&](std::size_t i) { return is_beside(rays_[i].whole, at) ? nullptr : rays_[i].sides; });
}

model::ChartPlane<double> CellTriangles::plane_at(FacePoint at, double w) const
{
    double least = std::numeric_limits<double>::infinity();
    model::ChartPlane<double> plane{w, 0, 0};
    for (const Plane& p : planes_) {
        const double miss = std::abs(p.w + p.ws * at.s + p.wt * at.t - w);
        if (!(miss < least)) continue;
        // Planes agree only where the triangle itself is near the ray.
        const Extent& e = p.extent;
        const double off =
            miss + w * (std::max({e.lo_s - at.s, 0.0, at.s - e.hi_s}) + std::max({e.lo_t - at.t, 0.0, at.t - e.hi_t}));
        if (off < least) {
            least = off;
            plane = {w, p.ws, p.wt};
        }
    }
    return plane;
}

bool Projection::is_in_domain(FacePoint at, double w) const
{
    const Vec3d x = model::face_direction(at.face, at.s, at.t) / w;
    for (std::size_t k = 0; k < model::k_domain_directions; ++k) {
        const double v = model::domain_coordinate(x, k);
        if (v < chart_.domain.lo[k] || v > chart_.domain.hi[k]) return false;
    }
    return true;
}

double Projection::metric_deviation(FacePoint at, const model::ChartPlane<double>& plane, double e) const
{
    const Vec3d n = model::plane_vector(at.face, at.s, at.t, plane), axes = chart_.superquadric.a;
    const double length = norm(Vec3d{n.x / axes.x, n.y / axes.y, n.z / axes.z});
    return length > 0 ? e / (plane.w * length) : 0;
}

double Projection::metric_size(int face, double size, double w) const
{
    const int m = model::face_axis(face);
    const Vec3d axes = chart_.superquadric.a;
    return size / w * std::max(axes[(m + 1) % 3], axes[(m + 2) % 3]);
}

}  // namespace sqmap::bake
