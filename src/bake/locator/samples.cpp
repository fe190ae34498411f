#include "samples.h"

#include "bake/locator/clip_to_cube.h"

#include <algorithm>
#include <cmath>

namespace sqmap::bake {

namespace {

/// In sides of the cell from its centre.
constexpr Vec3d k_samples[] = {{0, 0, 0},        {-.48, -.48, -.48}, {.48, -.48, -.48}, {.48, .48, -.48},  {-.48, .48, -.48},
                               {-.48, .48, .48}, {.48, .48, .48},    {.48, -.48, .48},  {-.48, -.48, .48}, {-.48, 0, 0},
                               {0, -.48, 0},     {.48, 0, 0},        {0, .48, 0},       {0, 0, .48},       {0, 0, -.48}};
constexpr Vec3d k_more_samples[] = {{-.24, -.24, -.24}, {.24, -.24, -.24}, {.24, .24, -.24},  {-.24, .24, -.24}, {-.24, .24, .24},
                                    {.24, .24, .24},    {.24, -.24, .24},  {-.24, -.24, .24}, {-.48, -.48, 0},   {.48, -.48, 0},
                                    {.48, .48, 0},      {-.48, .48, 0},    {-.48, 0, -.48},   {.48, 0, -.48},    {.48, 0, .48},
                                    {-.48, 0, .48},     {0, -.48, -.48},   {0, .48, -.48},    {0, .48, .48},     {0, -.48, .48}};

constexpr double k_sample_reach = 0.832;  ///< how far from the centre a sample is at most, in sides

Nearby nearby_of(const SurfaceCell& cell)
{
    const mesh::Solid& solid = cell.subject.solid;
    if (!cell.near.empty()) return {solid, cell.cube.centre, cell.near};
    return {solid, cell.cube.centre, (cell.centre.nearest.distance + 2 * k_sample_reach * cell.cube.side) * (1 + 1e-6)};
}

}  // namespace

bool is_inside(const KnownWinding& known, Vec3d p, const mesh::ClosestPoint& nearest, std::span<const Sample> others)
{
    const mesh::Solid& solid = known.solid();
    const mesh::Triangle& t = solid.mesh().triangles[nearest.triangle];
    const auto& v = solid.mesh().vertices;
    const Vec3d n = cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]), d = p - nearest.point;
    const double height = dot(n, d), sideways = norm(cross(n, d));
    const double u = dot(cross(v[t[1]] - nearest.point, v[t[2]] - nearest.point), n),
                 w = dot(cross(v[t[2]] - nearest.point, v[t[0]] - nearest.point), n),
                 x = dot(cross(v[t[0]] - nearest.point, v[t[1]] - nearest.point), n);
    const double corner = 1e-6 * norm_sq(n);
    if (sideways < 1e-6 * std::abs(height) && u > corner && w > corner && x > corner) return height < 0;
    for (const Sample& other : others) {
        const double clear = 0.999 * std::max(nearest.distance, other.nearest.distance);
        if (other.nearest.distance > 0 && norm_sq(p - other.point) < clear * clear) return other.inside;
    }
    return known.at(p) > 0;
}

Vec3d normal_at(const mesh::Solid& solid, const Sample& sample, double cell)
{
    const mesh::ClosestPoint& nearest = sample.nearest;
    const Vec3d n = sample.inside ? nearest.point - sample.point : sample.point - nearest.point;
    if (!(norm(n) < 1e-4 * cell)) return n;
    const mesh::Triangle& t = solid.mesh().triangles[nearest.triangle];
    const auto& v = solid.mesh().vertices;
    return cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]);
}

CellSampler::CellSampler(const SurfaceCell& cell) : cell_(cell), nearby_(nearby_of(cell)) {}

std::vector<Sample> CellSampler::samples()
{
    std::vector<Sample> samples;
    add(k_samples, samples);
    return samples;
}

void CellSampler::add_more(std::vector<Sample>& samples) { add(k_more_samples, samples); }

void CellSampler::add(std::span<const Vec3d> offsets, std::vector<Sample>& samples)
{
    Vec3d points[Nearby::k_points];
    for (std::size_t i = 0; i < offsets.size(); ++i) points[i] = cell_.cube.centre + cell_.cube.side * offsets[i];
    std::vector<mesh::ClosestPoint> found;
    nearby_.closest({points, offsets.size()}, found);
    for (std::size_t i = 0; i < found.size(); ++i) {
        const bool inside =
            cell_.kind == model::LocatorCellKind::Inside || is_inside(cell_.winding, points[i], found[i], samples);
        samples.push_back({points[i], found[i], inside});
    }
}

void CellSampler::add_surface(std::vector<Sample>& samples) const
{
    const mesh::Solid& solid = cell_.subject.solid;
    const Vec3d centre = cell_.cube.centre;
    const double half = cell_.cube.half(), radius_sq = 3.0003 * half * half;
    solid.bvh().visit_nearest(centre, radius_sq, [&](std::uint32_t triangle, double) {
        const mesh::Triangle& t = solid.mesh().triangles[triangle];
        const auto& v = solid.mesh().vertices;
        const ClippedTriangle piece = clip_to_cube({v[t[0]] - centre, v[t[1]] - centre, v[t[2]] - centre}, half);
        Vec3d middle{};
        for (int i = 0; i < piece.count; ++i) middle += piece.corners[i] / double(piece.count);
        for (int i = 0; i <= piece.count && piece.count > 0; ++i) {
            const Vec3d p = centre + (i < piece.count ? piece.corners[i] : middle);
            samples.push_back({p, {p, triangle, 0}, true});
        }
        return radius_sq;
    });
}

}  // namespace sqmap::bake
